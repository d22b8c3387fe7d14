// The information about all coordinates at the chains' points: see Density::information. Column i of J is the change of
// the blocks with coordinate i, divided by their noise. Changes of the loop and of the dead band use the sway's own
// transforms.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <optional>
#include <utility>
#include <vector>

#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "posterior/density/elementary.hpp"
#include "posterior/sampling/detail/chains.hpp"

namespace decid::posterior {

namespace {

using sim::Complex;

/// One frequency of one chain: see LoopConstants, LoopState and kernels/generic_family.hpp. With unit gains all factors
/// that other members add are exactly 1 or 0.
struct Place {
  Complex s, sum, rate, platform;
  Complex passed;  // the passed velocity
  Complex sway, delayed, inverse;
  double kp, kd, gain;
  double position = 1.0, tilt = 1.0, gravity = 1.0, slow = 0.0, torque = 0.0;
  Complex derivative = 0.0, slow_response = 0.0, torque_response = 0.0;

  Complex c() const { return kp * sum + kd; }
  Complex e() const { return kp + kd * rate; }
  Complex p() const { return kp + kd * derivative; }
  /// Returns 1 / (1 - delayed P torque Y).
  Complex closed() const {
    return torque == 0.0 ? Complex(1.0) : quotient(1.0, 1.0 - delayed * (p() * torque_response) * torque);
  }
  Complex active() const { return torque == 0.0 ? delayed : delayed * closed(); }
  Complex error() const { return position * platform - tilt * passed; }
  double reach() const { return position + gravity; }
  /// Returns the command behind the active torque.
  Complex command() const {
    const Complex of_body = c() * error() - reach() * e() * sway;
    return slow == 0.0 ? of_body : of_body - slow * p() * slow_response * sway;
  }
  /// Returns the change of the sway with P, of slow and torque feedback.
  Complex by_p() const {
    return gain * inverse * active() * (active() * torque * torque_response * command() - slow * slow_response * sway);
  }
};

/// The change of the sway's transform with a quantity of the loop.
using LoopChange = Complex (*)(const Place& p);

/// Returns the change with a coefficient; null for those of the dead band.
LoopChange change_with(sim::Coefficient coefficient) {
  using enum sim::Coefficient;
  switch (coefficient) {
    case kp:
      return [](const Place& p) {
        const Complex change = p.gain * p.inverse * p.active() * (p.sum * p.error() - p.reach() * p.sway);
        return p.slow == 0.0 && p.torque == 0.0 ? change : change + p.by_p();
      };
    case kd:
      return [](const Place& p) {
        const Complex change = p.gain * p.inverse * p.active() * (p.error() - p.reach() * p.rate * p.sway);
        return p.slow == 0.0 && p.torque == 0.0 ? change : change + p.derivative * p.by_p();
      };
    case kp_pass:
      return [](const Place& p) { return p.gain * p.inverse * (p.sum * p.platform - p.sway); };
    case kd_pass:
      return [](const Place& p) { return p.gain * p.inverse * (p.platform - p.rate * p.sway); };
    case delay:
      return [](const Place& p) {
        const Complex change = -p.gain * p.s * p.inverse * p.active() * p.command();
        return p.torque == 0.0 ? change : change * p.closed();
      };
    case position:
      return [](const Place& p) { return p.gain * p.inverse * p.active() * (p.c() * p.platform - p.e() * p.sway); };
    case tilt:
      return [](const Place& p) { return -p.gain * p.inverse * p.active() * p.c() * p.passed; };
    case gravity:
      return [](const Place& p) { return -p.gain * p.inverse * p.active() * p.e() * p.sway; };
    case slow:
      return [](const Place& p) { return -p.gain * p.inverse * p.active() * p.p() * p.slow_response * p.sway; };
    case torque:
      return [](const Place& p) {
        return p.gain * p.inverse * p.active() * p.active() * p.p() * p.torque_response * p.command();
      };
    default:
      return nullptr;
  }
}

Complex number(const AlignedVector<double>& values, std::size_t k) {
  return {values[2 * k], values[2 * k + 1]};
}

Complex in_lane(const AlignedVector<double>& values, std::size_t k, std::size_t l) {
  return {values[2 * k * lanes + l], values[(2 * k + 1) * lanes + l]};
}

void put_lane(AlignedVector<double>& values, std::size_t k, std::size_t l, Complex value) {
  values[2 * k * lanes + l] = value.real();
  values[(2 * k + 1) * lanes + l] = value.imag();
}

/// Returns value `half` of a column at twice its places, of 0 to `last`, as Kernels::refine does.
double refined(std::span<const double> column, std::size_t half, std::size_t last) {
  const double* at = column.data() + half / 2;
  if (half % 2 == 0) return at[0];
  if (half == 1 || half + 1 == last) return 0.5 * (at[0] + at[1]);
  return std::fma(9.0 / 16, at[0] + at[1], -(1.0 / 16 * (at[-1] + at[2])));
}

/// Copies products of columns, in blocks of 4 x 4, into the lower triangle of matrices of `count` rows.
void unpack(const AlignedVector<double>& blocks, std::size_t count, std::span<double> matrices) {
  const double* products = blocks.data();
  for (std::size_t i = 0; 4 * i < count; ++i) {
    for (std::size_t j = 0; j <= i; ++j, products += std::size_t{16} * lanes) {
      for (std::size_t r = 4 * i; r < std::min(4 * i + 4, count); ++r) {
        for (std::size_t column = 4 * j; column < 4 * j + 4 && column <= r; ++column) {
          const double* p = products + (4 * (r - 4 * i) + (column - 4 * j)) * lanes;
          std::copy_n(p, lanes, matrices.data() + (triangle(r) + column) * lanes);
        }
      }
    }
  }
}

}  // namespace

std::array<double, 3> Density::power_changes(const Chains& c, const Workspace& work, std::size_t k,
                                             std::size_t l) const {
  const double precision = work.noise.precision[k * lanes + l], slow_fraction = work.noise.slow_fraction[k * lanes + l];
  const double slow = precision * c.levels.slow[l] * slow_fraction;
  return {precision * spectrum_.white(k) * c.levels.white[l] * c.d_white[l] + slow * c.d_slow_white[l],
          slow * c.d_slow[l], slow * (1.0 - 2.0 * (1.0 - slow_fraction)) * c.d_memory[l]};
}

// A Gaussian coefficient of variance P has the information (d log P)_a (d log P)_b / 2 about two coordinates.
void Density::add_noise_information(const Chains& c, const Workspace& work, std::span<double> matrices) const {
  const auto noises = static_cast<std::size_t>(noise_.size()), rows = static_cast<std::size_t>(spectrum_.rows());
  const std::array<std::size_t, 3> quantities{place(sensor_noise), place(slow_noise), place(slow_memory)};
  for (std::size_t l = 0; l < lanes; ++l) {
    std::array<std::array<double, 3>, 3> sums{};
    for (std::size_t k = 0; k < rows; ++k) {
      const std::array<double, 3> change = power_changes(c, work, k, l);
      for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t b = 0; b <= a; ++b) sums[a][b] = std::fma(0.5 * change[a], change[b], sums[a][b]);
    }
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t b = 0; b <= a; ++b)
        matrices[(triangle(noises + quantities[a]) + noises + quantities[b]) * lanes + l] += sums[a][b];
  }
}

void Density::information(const Observation& observation, std::span<const double> x, std::span<double> matrices,
                          Workspace& work, std::optional<double> fixed_noise_deg) const {
  check(observation, x, matrices.size(), triangle(static_cast<std::size_t>(size())) * lanes);
  const Kernels& run = kernels(isa_);
  const Chains c = chains(x, fixed_noise_deg);
  forward(observation, x, c, work);
  spectrum_.begin_whitening(observation.missing, work.noise, isa_);
  const auto count = static_cast<std::size_t>(size()), noises = static_cast<std::size_t>(noise_.size());
  const auto kept = static_cast<std::size_t>(spectrum_.rows()),
             rows = kept + static_cast<std::size_t>(observation.missing.count());
  const std::size_t blocks_of_columns = (count + 3) / 4, strips = (rows + strip_rows - 1) / strip_rows;
  constexpr std::size_t strip_size = std::size_t{strip_rows} * lanes;     // of a column
  work.columns.resize(strips * 4 * blocks_of_columns * strip_size, 0.0);  // the padding of columns stays 0
  std::fill_n(work.columns.end() - static_cast<std::ptrdiff_t>(4 * blocks_of_columns * strip_size),
              4 * blocks_of_columns * strip_size, 0.0);  // the padding of rows, which another observation may have used
  work.products.assign(blocks_of_columns * (blocks_of_columns + 1) / 2 * 16 * lanes, 0.0);
  work.noise_column.resize(static_cast<std::size_t>(noise_.edges()));

  const std::vector<double> silence(static_cast<std::size_t>(blocks_), 0.0);
  // Writes the column of the observed sway's change, whose transform is in work.sway_spectrum.
  const auto write_column = [&](std::size_t column, const std::array<double, lanes>& factors) {
    to_blocks(work);
    run.unfold(blocks_, silence.data(), trial_blocks(work.modelled), undamp_.data(), work.unfolded.data());
    spectrum_.clear(observation.missing, work.unfolded);
    spectrum_.whiten(observation.missing, work.unfolded, work.noise, isa_);
    for (std::size_t k = 0; k < rows; ++k) {
      const double* in =
          k < kept ? work.noise.coefficient.data() + k * lanes : work.noise.missing_value.data() + (k - kept) * lanes;
      const std::size_t strip = k / strip_rows, row = k % strip_rows;
      double* out = work.columns.data() + (strip * 4 * blocks_of_columns + column) * strip_size + row * lanes;
      for (std::size_t l = 0; l < lanes; ++l) out[l] = in[l] * factors[l];
    }
  };

  // Columns of the loop, from the forward pass's state; then columns of the passed velocity.
  const auto frequencies = static_cast<std::size_t>(frequencies_);
  const auto locate = [&](std::size_t k, std::size_t l) {
    using enum sim::Coefficient;
    Place here{.s = number(s_, k),
               .sum = number(sum_, k),
               .rate = number(rate_, k),
               .platform = number(platform_, k),
               .passed = in_lane(work.bins_spectrum, k, l),
               .sway = in_lane(work.sway, k, l),
               .delayed = in_lane(work.delayed, k, l),
               .inverse = in_lane(work.inverse, k, l),
               .kp = c[kp][l],
               .kd = c[kd][l],
               .gain = c.value[place(Quantity::gain)][l]};
    if (unit_gains_) return here;
    here.position = c[position][l];
    here.tilt = c[tilt][l];
    here.gravity = c[gravity][l];
    here.slow = c[slow][l];
    here.torque = c[torque][l];
    here.derivative = number(derivative_, k);
    here.slow_response = number(slow_response_, k);
    here.torque_response = number(torque_response_, k);
    return here;
  };
  const auto write_loop_column = [&](std::size_t global, const auto& change) {
    for (std::size_t k = 0; k < frequencies; ++k)
      for (std::size_t l = 0; l < lanes; ++l)
        put_lane(work.sway_spectrum, k, l, change(locate(k, l)) * in_lane(work.observe, k, l));
    write_column(noises + global, c.d_coordinate[global]);
  };
  for (std::size_t i = 0; i < quantiles_.size(); ++i) {
    std::vector<std::pair<double, LoopChange>> changes;
    for (const sim::Family::Term& term : family().terms) {
      const LoopChange change = change_with(term.coefficient);
      if (term.parameter == i && change != nullptr) changes.emplace_back(term.factor, change);
    }
    if (changes.empty()) continue;  // of the dead band
    write_loop_column(i, [&](const Place& p) {
      Complex sum = changes.front().first * changes.front().second(p);
      for (std::size_t t = 1; t < changes.size(); ++t) sum += changes[t].first * changes[t].second(p);
      return sum;
    });
  }
  write_loop_column(place(start), [](const Place& p) { return p.gain * p.s * p.sway; });
  write_loop_column(place(gain), [](const Place& p) { return p.sway; });
  for (std::size_t k = 0; k < frequencies; ++k) {
    for (std::size_t l = 0; l < lanes; ++l) {
      const Place p = locate(k, l);
      put_lane(work.response, k, l,
               -(p.gain * p.tilt) * p.active() * p.c() * p.inverse * number(hold_, k) * in_lane(work.observe, k, l));
    }
  }
  const auto passed_column = [&](std::size_t column, const std::array<double, lanes>& factors) {
    fft_.forward_lanes(work.by_passed, work.loop_spectrum, work.fft_work, isa_);
    run.product(frequencies_, work.loop_spectrum.data(), work.response.data(), work.sway_spectrum.data());
    write_column(column, factors);
  };
  std::fill(work.by_passed.begin(), work.by_passed.end(), 0.0);
  run.join(bins_, work.by_theta.data(), work.by_passed.data());
  const std::optional<std::size_t> theta = family().find_parameter(sim::Coefficient::theta),
                                   nv = family().find_parameter(sim::Coefficient::nv);
  if (theta) passed_column(noises + *theta, c.d_coordinate[*theta]);
  for (std::size_t i = 0; i < work.halves.size(); ++i)
    work.halves[i] = work.by_low[i] * work.fine[i] + work.by_high[i] * work.fine[i + lanes];
  run.join(bins_, work.halves.data(), work.by_passed.data());
  if (nv) {
    std::array<double, lanes> of_nv;
    for (std::size_t l = 0; l < lanes; ++l) of_nv[l] = c.d_nv[l] * c.d_coordinate[*nv][l];
    passed_column(noises + *nv, of_nv);
  }
  const DeadBandValues values = dead_band_values(c, work);
  const auto bins = static_cast<std::size_t>(bins_);
  work.fine_column.resize(2 * bins + 1);
  for (std::size_t i = 0; i < noises; ++i) {
    noise_.column(static_cast<int>(i), work.noise_column);
    for (std::size_t half = 0; half <= 2 * bins; ++half)
      work.fine_column[half] = refined(work.noise_column, half, 2 * bins);
    run.dead_band_change(2 * bins_, values, work.fine_column.data(), work.halves.data());
    run.join(bins_, work.halves.data(), work.by_passed.data());
    passed_column(i, c.noise_gain);
  }
  std::fill(work.loop_spectrum.begin(), work.loop_spectrum.end(), 0.0);
  run.add_products(static_cast<int>(strips), static_cast<int>(blocks_of_columns), work.columns.data(),
                   work.products.data());

  unpack(work.products, count, matrices);
  for (std::size_t l = 0; l < lanes; ++l) {
    const auto diagonal = [&](std::size_t i) -> double& { return matrices[(triangle(i) + i) * lanes + l]; };
    const double of_prior = 1.0 / (c.radius[l] * c.radius[l]);
    for (std::size_t i = 0; i < noises; ++i) diagonal(i) += of_prior;
    if (nv) {
      const double by_nv = c.d_coordinate[*nv][l] * c.value[*nv][l] * of_prior;
      diagonal(noises + *nv) += 2.0 * static_cast<double>(noises) * by_nv * by_nv;
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(globals()); ++i) diagonal(noises + i) += 1.0;
  }
  add_noise_information(c, work, matrices);
}

}  // namespace decid::posterior
