// Images of windows' spectra, written once on a vector type V (base/math/doubles.hpp) and compiled once per instruction
// set.
#pragma once

#include "base/math/math_lanes.hpp"
#include "dataset/image/kernels/image.hpp"

namespace decid::dataset {
namespace {

template <class V>
void load_windows(const float* const* windows, int window, int lanes, double* signal) {
  for (int n = 0; n < window; ++n) {
    double* row = signal + static_cast<std::ptrdiff_t>(n) * image_lanes;
    for (int lane = 0; lane < image_lanes; ++lane) {
      row[lane] = lane < lanes ? static_cast<double>(windows[lane][n]) : 0.0;
    }
  }
}

template <class V>
void average_cycles(int fold, int bins, int used, const double* spectra, double* mean, double* residual) {
  using D = typename V::D;
  if (fold == 1) {
    for (std::ptrdiff_t at = 0; at < std::ptrdiff_t{2} * used * image_lanes; at += V::width)
      V::store(mean + at, V::set(0.0) + V::load(spectra + at));
    for (std::ptrdiff_t at = 0; at < std::ptrdiff_t{1} * used * image_lanes; ++at) residual[at] = 0.0;
    return;
  }
  const D count = V::set(fold);
  const std::ptrdiff_t apart = std::ptrdiff_t{2} * bins * image_lanes;
  for (std::ptrdiff_t k = 0; k < used; ++k) {
    for (int lane = 0; lane < image_lanes; lane += V::width) {
      const std::ptrdiff_t at = 2 * k * image_lanes + lane;
      // The sums begin with +0, so no part of the mean is -0: the phase of a real bin is 0 or +pi, never -pi.
      D real = V::set(0.0), imaginary = V::set(0.0), squares = V::set(0.0);
      for (int i = 0; i < fold; ++i) {
        real = real + V::load(spectra + i * apart + at);
        imaginary = imaginary + V::load(spectra + i * apart + at + image_lanes);
      }
      real = real / count;
      imaginary = imaginary / count;
      for (int i = 0; i < fold; ++i) {
        const D dx = V::load(spectra + i * apart + at) - real;
        const D dy = V::load(spectra + i * apart + at + image_lanes) - imaginary;
        squares = squares + (dx * dx + dy * dy);
      }
      V::store(mean + at, real);
      V::store(mean + at + image_lanes, imaginary);
      V::store(residual + k * image_lanes + lane, V::sqrt(squares / count));
    }
  }
}

template <class V, class D = typename V::D>
[[gnu::always_inline]] inline D modulus(D real, D imaginary) {
  return V::sqrt(real * real + imaginary * imaginary);
}
template <class V, class D = typename V::D>
[[gnu::always_inline]] inline D floored_log(D modulus) {
  return log_lanes<V>(V::max(V::set(min_modulus_rad), modulus));
}

/// Returns a channel's value of the bin whose mean is `real` + i `imaginary`.
template <class V, Channel channel, class D = typename V::D>
[[gnu::always_inline]] inline D shown(D real, D imaginary, D residual) {
  const D zero = V::set(0.0);
  switch (channel) {
    case Channel::modulus:
      return modulus<V>(real, imaginary);
    case Channel::log_modulus:
      return floored_log<V>(modulus<V>(real, imaginary));
    case Channel::phase:
      return atan2_lanes<V>(imaginary, real);
    case Channel::cos_phase: {
      const D r = modulus<V>(real, imaginary);
      return r > zero ? real / r : V::set(1.0);
    }
    case Channel::sin_phase: {
      const D r = modulus<V>(real, imaginary);
      return r > zero ? imaginary / r : zero;
    }
    case Channel::real:
      return real;
    case Channel::imaginary:
      return imaginary;
    case Channel::asinh_real:
      return asinh_lanes<V>(real / asinh_knee_rad);
    case Channel::asinh_imaginary:
      return asinh_lanes<V>(imaginary / asinh_knee_rad);
    case Channel::log_residual:
      return floored_log<V>(residual);
    case Channel::sway:
    case Channel::sway_change:
    case Channel::sway_bend:
    case Channel::torque:
    case Channel::height:
    case Channel::tilt:
    case Channel::tilt_velocity:
      break;  // not a channel of bins
  }
  return zero;
}

/// Returns whether a channel changes its sign from z to its conjugate.
constexpr bool is_odd(Channel channel) {
  return channel == Channel::phase || channel == Channel::sin_phase || channel == Channel::imaginary ||
         channel == Channel::asinh_imaginary;
}

/// Stores values[l] to planes[l][offset] for the used lanes.
[[gnu::always_inline]] inline void spread(const DrawRequest& request, std::ptrdiff_t offset, const float* values) {
  if (request.lanes == image_lanes && request.planes[image_lanes - 1] - request.planes[0] == image_lanes - 1) {
    __builtin_memcpy(request.planes[0] + offset, values, image_lanes * sizeof(float));
    return;
  }
  for (int lane = 0; lane < request.lanes; ++lane) request.planes[lane][offset] = values[lane];
}

template <class V, Channel channel>
void draw_channel(const DrawRequest& request) {
  using D = typename V::D;
  for (int k = 0; k < request.bins; ++k) {
    float values[image_lanes], mirrored[image_lanes];
    const double* mean = request.mean + std::ptrdiff_t{2} * k * image_lanes;
    const double* residual = request.residual + static_cast<std::ptrdiff_t>(k) * image_lanes;
    for (int lane = 0; lane < image_lanes; lane += V::width) {
      const D imaginary = V::load(mean + image_lanes + lane);
      const D value = shown<V, channel>(V::load(mean + lane), imaginary, V::load(residual + lane));
      V::store_floats(values + lane, value);
      // A real z is its own conjugate: its phase stays pi, where -pi would be outside (-pi, pi].
      if (is_odd(channel)) V::store_floats(mirrored + lane, imaginary == V::set(0.0) ? value : -value);
    }
    spread(request, static_cast<std::ptrdiff_t>(k) * request.columns, values);
    const int mirror = request.window - k;
    if (k == 0 || mirror < request.bins || mirror >= request.rows) continue;
    spread(request, static_cast<std::ptrdiff_t>(mirror) * request.columns, is_odd(channel) ? mirrored : values);
  }
}

template <class V>
void draw(const DrawRequest& request) {
  switch (request.channel) {
    case Channel::modulus:
      return draw_channel<V, Channel::modulus>(request);
    case Channel::log_modulus:
      return draw_channel<V, Channel::log_modulus>(request);
    case Channel::phase:
      return draw_channel<V, Channel::phase>(request);
    case Channel::cos_phase:
      return draw_channel<V, Channel::cos_phase>(request);
    case Channel::sin_phase:
      return draw_channel<V, Channel::sin_phase>(request);
    case Channel::real:
      return draw_channel<V, Channel::real>(request);
    case Channel::imaginary:
      return draw_channel<V, Channel::imaginary>(request);
    case Channel::asinh_real:
      return draw_channel<V, Channel::asinh_real>(request);
    case Channel::asinh_imaginary:
      return draw_channel<V, Channel::asinh_imaginary>(request);
    case Channel::log_residual:
      return draw_channel<V, Channel::log_residual>(request);
    case Channel::sway:
    case Channel::sway_change:
    case Channel::sway_bend:
    case Channel::torque:
    case Channel::height:
    case Channel::tilt:
    case Channel::tilt_velocity:
      return;  // not a channel of spectra
  }
}

template <class V>
void asinh(int count, const double* values, double knee, float* shown) {
  for (int i = 0; i < count; i += V::width) V::store_floats(shown + i, asinh_lanes<V>(V::load(values + i) / knee));
}

template <class V>
constexpr ImageKernels image_table{load_windows<V>, average_cycles<V>, draw<V>, asinh<V>};

}  // namespace
}  // namespace decid::dataset
