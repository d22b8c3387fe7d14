// What the channels of an image show. A header of its own, as kernels for one instruction set need it too.
#pragma once

namespace decid::dataset {

/// What a channel shows: of spectra, of a bin z (rad, as the FFT's sum gives it).
/// asinh_*: asinh(part / asinh_knee_rad), which keeps the sign of large and small values alike. residual: how the
/// cycles differ, sqrt(mean |z_i - z|^2), see ImageSettings::fold.
enum class Channel {
  modulus,
  log_modulus,
  phase,
  cos_phase,
  sin_phase,
  real,
  imaginary,
  asinh_real,
  asinh_imaginary,
  log_residual,
  // Of a time series, see ImageSettings::block:
  sway,           ///< asinh(x / knee) of the means of blocks of the sway
  sway_change,    ///< of their differences from block to block
  sway_bend,      ///< of the differences of these
  torque,         ///< of the ankle torque over m g h that moves the body so, of the block before
  height,         ///< of the body over that of the experiment's, less 1, over height_unit
  tilt,           ///< the platform's tilt, means of blocks over tilt_unit_rad
  tilt_velocity,  ///< and its velocity over tilt_unit_rad a second
};
/// Whether a channel is of a time series, not of a spectrum.
constexpr bool is_of_series(Channel channel) {
  return channel >= Channel::sway;
}
/// Whether a channel of a time series is of the sway, so that each cycle has its own.
constexpr bool is_of_sway(Channel channel) {
  return channel >= Channel::sway && channel <= Channel::torque;
}
/// log_modulus is log(max(|z|, this)): 1e-6 rad, below anything a sensor resolves. log_residual likewise.
inline constexpr double modulus_floor_rad = 1e-6;
/// Where asinh turns from linear to logarithmic: about the bins of good optical tracking's noise (0.01 degrees).
inline constexpr double asinh_knee_rad = 1e-3;
/// The knees of series: about what sway, its changes and their changes are in blocks of 0.1 s.
inline constexpr double sway_knee_rad = 5e-3, sway_change_knee_rad = 1e-3, sway_bend_knee_rad = 5e-4;
inline constexpr double torque_knee_rad = 5e-3;
inline constexpr double tilt_unit_rad = 0.01, height_unit = 0.1;

}  // namespace decid::dataset
