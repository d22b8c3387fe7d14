// What the channels of an image show. A header of its own, as kernels for one instruction set need it too.
#pragma once

namespace decid::dataset {

/// What a channel shows of a bin z (rad, as the FFT's sum gives it).
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
  log_residual
};
/// log_modulus is log(max(|z|, this)): 1e-6 rad, below anything a sensor resolves. log_residual likewise.
inline constexpr double modulus_floor_rad = 1e-6;
/// Where asinh turns from linear to logarithmic: about the bins of good optical tracking's noise (0.01 degrees).
inline constexpr double asinh_knee_rad = 1e-3;

}  // namespace decid::dataset
