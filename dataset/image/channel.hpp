// Channels of a network input. A separate header, because kernels for one instruction set need it too.
#pragma once

namespace decid::dataset {

/// The content of a channel. Channels of spectra show a bin z (rad, as the FFT's sum). asinh_*: asinh(part /
/// asinh_knee_rad), which keeps the sign of large and small values alike. residual: the difference between cycles,
/// sqrt(mean |z_i - z|^2), see ImageSettings::fold.
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
  // Channels of a time series, see ImageSettings::block:
  sway,           ///< asinh(x / knee) of the means of blocks of the sway
  sway_change,    ///< the same of their differences from block to block
  sway_bend,      ///< the same of the differences of these
  torque,         ///< ankle torque over m g h that causes the body's motion, of the previous block
  height,         ///< body height relative to the experiment's, minus 1, over height_unit
  tilt,           ///< the platform's tilt, means of blocks over tilt_unit_rad
  tilt_velocity,  ///< its velocity over tilt_unit_rad per second
};
/// Returns whether a channel belongs to a time series, not to a spectrum.
constexpr bool is_of_series(Channel channel) {
  return channel >= Channel::sway;
}
/// Returns whether a channel of a time series shows the sway, so that each cycle has its own.
constexpr bool is_of_sway(Channel channel) {
  return channel >= Channel::sway && channel <= Channel::torque;
}
/// log_modulus is log(max(|z|, this)): 1e-6 rad, below the resolution of any sensor. log_residual uses the same bound.
inline constexpr double min_modulus_rad = 1e-6;
/// The transition of asinh from linear to logarithmic: about the noise bins of good optical tracking (0.01 degrees).
inline constexpr double asinh_knee_rad = 1e-3;
/// The knees of series: typical sizes of sway, its changes and their changes in blocks of 0.1 s.
inline constexpr double sway_knee_rad = 5e-3, sway_change_knee_rad = 1e-3, sway_bend_knee_rad = 5e-4;
inline constexpr double torque_knee_rad = 5e-3;
inline constexpr double tilt_unit_rad = 0.01, height_unit = 0.1;

}  // namespace decid::dataset
