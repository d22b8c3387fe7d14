// The information about all coordinates at the chains' points: see Density::add_information.
// Column i of J is the change of the blocks, over their noise, with coordinate i; changes of the loop and of the dead
// band go through the same transforms as the sway itself.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "identify/posterior/chains.hpp"

namespace decid::posterior {

using sim::Complex;

void Density::add_information(const Observation& observation, std::span<const double> x, std::span<double> matrix,
                              Workspace& work, std::optional<double> fixed_noise_deg) const {
  const Kernels& run = kernels(isa_);
  const Chains c = chains(x, fixed_noise_deg);
  std::array<double, lanes> squares;
  forward(observation, x, c, work, squares.data());
  const auto count = static_cast<std::size_t>(size()), noises = static_cast<std::size_t>(noise_.size());
  const std::size_t blocks_of_columns = (count + 3) / 4, column_size = static_cast<std::size_t>(blocks_) * lanes;
  work.columns.assign(4 * blocks_of_columns * column_size, 0.0);
  work.products.assign(blocks_of_columns * (blocks_of_columns + 1) / 2 * 16 * lanes, 0.0);
  work.noise_column.resize(static_cast<std::size_t>(noise_.edges()));

  const auto number = [](const AlignedVector<double>& values, std::size_t k) {
    return Complex(values[2 * k], values[2 * k + 1]);
  };
  const auto in_lane = [](const AlignedVector<double>& values, std::size_t k, std::size_t l) {
    return Complex(values[2 * k * lanes + l], values[(2 * k + 1) * lanes + l]);
  };
  const auto put_lane = [](AlignedVector<double>& values, std::size_t k, std::size_t l, Complex value) {
    values[2 * k * lanes + l] = value.real();
    values[(2 * k + 1) * lanes + l] = value.imag();
  };
  const AlignedVector<double> silence(static_cast<std::size_t>(blocks_), 0.0);
  // The column of the change of the observed sway whose transform is in work.sway_spectrum.
  const auto write_column = [&](std::size_t column, auto&& factor_of) {
    to_blocks(work);
    double* out = work.columns.data() + column * column_size;
    run.residual(blocks_, drift_decay_, silence.data(), work.modelled.data(), undamp_.data(), out, squares.data());
    std::array<double, lanes> factor;
    for (std::size_t l = 0; l < lanes; ++l)
      factor[l] = -factor_of(l) / (c.noise_rad[l] * std::sqrt(static_cast<double>(lanes)));
    for (std::size_t m = 0; m < static_cast<std::size_t>(blocks_); ++m)
      for (std::size_t l = 0; l < lanes; ++l) out[m * lanes + l] *= factor[l];
  };

  // Those of the loop, from the state that the way there left; then of what the dead band passes.
  const auto frequencies = static_cast<std::size_t>(frequencies_);
  const auto loop_column = [&](std::size_t global, auto&& change) {
    for (std::size_t k = 0; k < frequencies; ++k) {
      const Complex sum = number(sum_, k), rate = number(rate_, k), s = number(s_, k), v = number(platform_, k);
      for (std::size_t l = 0; l < lanes; ++l) {
        const Complex sway = in_lane(work.sway, k, l), delayed = in_lane(work.delayed, k, l);
        const Complex error = v - in_lane(work.bins_spectrum, k, l), inverse = in_lane(work.inverse, k, l);
        put_lane(work.sway_spectrum, k, l,
                 change(l, sum, rate, s, v, sway, delayed, error, inverse) * in_lane(work.observe, k, l));
      }
    }
    write_column(noises + global, [&](std::size_t l) { return c.by_coordinate[global][l]; });
  };
  loop_column(sim::Kp,
              [&](std::size_t l, Complex sum, Complex, Complex, Complex, Complex sway, Complex delayed, Complex error,
                  Complex inverse) { return c.value[gain][l] * inverse * delayed * (sum * error - 2.0 * sway); });
  loop_column(sim::Kd,
              [&](std::size_t l, Complex, Complex rate, Complex, Complex, Complex sway, Complex delayed, Complex error,
                  Complex inverse) { return c.value[gain][l] * inverse * delayed * (error - 2.0 * rate * sway); });
  loop_column(sim::Kp_pass, [&](std::size_t l, Complex sum, Complex, Complex, Complex v, Complex sway, Complex, Complex,
                                Complex inverse) { return c.value[gain][l] * inverse * (sum * v - sway); });
  loop_column(sim::Kd_pass, [&](std::size_t l, Complex, Complex rate, Complex, Complex v, Complex sway, Complex,
                                Complex, Complex inverse) { return c.value[gain][l] * inverse * (v - rate * sway); });
  loop_column(sim::Delay, [&](std::size_t l, Complex sum, Complex rate, Complex s, Complex, Complex sway,
                              Complex delayed, Complex error, Complex inverse) {
    const double kp = c.value[sim::Kp][l], kd = c.value[sim::Kd][l];
    return -c.value[gain][l] * s * inverse * delayed * ((kp * sum + kd) * error - 2.0 * (kp + kd * rate) * sway);
  });
  loop_column(start, [&](std::size_t l, Complex, Complex, Complex s, Complex, Complex sway, Complex, Complex, Complex) {
    return c.value[gain][l] * s * sway;
  });
  loop_column(gain, [&](std::size_t, Complex, Complex, Complex, Complex, Complex sway, Complex, Complex, Complex) {
    return sway;
  });
  for (std::size_t k = 0; k < frequencies; ++k) {
    for (std::size_t l = 0; l < lanes; ++l) {
      const Complex active = c.value[sim::Kp][l] * number(sum_, k) + c.value[sim::Kd][l];
      put_lane(work.response, k, l,
               -c.value[gain][l] * in_lane(work.delayed, k, l) * active * in_lane(work.inverse, k, l) *
                   number(hold_, k) * in_lane(work.observe, k, l));
    }
  }
  const auto passed_column = [&](std::size_t column, auto&& factor_of) {
    bins_fft_.forward_lanes(work.by_passed, work.loop_spectrum, work.fft_work, isa_);
    run.product(frequencies_, work.loop_spectrum.data(), work.response.data(), work.sway_spectrum.data());
    write_column(column, factor_of);
  };
  const auto all_bins = static_cast<std::size_t>(bins_) * lanes;
  std::fill(work.by_passed.begin(), work.by_passed.end(), 0.0);
  std::copy_n(work.by_theta.begin(), all_bins, work.by_passed.begin());
  passed_column(noises + sim::Theta, [&](std::size_t l) { return c.by_coordinate[sim::Theta][l]; });
  for (std::size_t i = 0; i < all_bins; ++i)
    work.by_passed[i] = work.by_low[i] * work.velocity[i] + work.by_high[i] * work.velocity[i + lanes];
  passed_column(noises + sim::Nv, [&](std::size_t l) { return c.by_nv[l] * c.by_coordinate[sim::Nv][l]; });
  const DeadBandValues values = dead_band_values(c, work);
  for (std::size_t i = 0; i < noises; ++i) {
    noise_.column(static_cast<int>(i), work.noise_column);
    run.dead_band_change(bins_, values, work.noise_column.data(), work.by_passed.data());
    passed_column(i, [&](std::size_t l) { return c.noise_gain[l]; });
  }
  std::fill(work.loop_spectrum.begin(), work.loop_spectrum.end(), 0.0);
  run.add_products(blocks_, static_cast<int>(blocks_of_columns), work.columns.data(), work.products.data());

  const double* products = work.products.data();
  for (std::size_t i = 0; i < blocks_of_columns; ++i) {
    for (std::size_t j = 0; j <= i; ++j, products += std::size_t{16} * lanes) {
      for (std::size_t r = 4 * i; r < std::min(4 * i + 4, count); ++r) {
        for (std::size_t column = 4 * j; column < 4 * j + 4 && column <= r; ++column) {
          const double* p = products + (4 * (r - 4 * i) + (column - 4 * j)) * lanes;
          matrix[r * (r + 1) / 2 + column] += ((p[0] + p[1]) + (p[2] + p[3])) + ((p[4] + p[5]) + (p[6] + p[7]));
        }
      }
    }
  }
  const auto diagonal = [&](std::size_t i) -> double& { return matrix[i * (i + 1) / 2 + i]; };
  for (std::size_t l = 0; l < lanes; ++l) {
    const double of_prior = 1.0 / (c.radius[l] * c.radius[l]);
    for (std::size_t i = 0; i < noises; ++i) diagonal(i) += of_prior / lanes;
    const double by_nv = c.by_coordinate[sim::Nv][l] * c.value[sim::Nv][l] * of_prior;
    diagonal(noises + sim::Nv) += 2.0 * static_cast<double>(noises) * by_nv * by_nv / lanes;
    const double by_noise = c.by_coordinate[sensor_noise][l];
    diagonal(noises + sensor_noise) += 2.0 * blocks_ * by_noise * by_noise / lanes;
  }
  for (std::size_t i = 0; i < globals; ++i) diagonal(noises + i) += 1.0;
}

}  // namespace decid::posterior
