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

/// The change with a parameter of the family: of all coefficients that it is a term of.
class ParameterChange {
 public:
  ParameterChange(const sim::Family& family, std::size_t parameter) {
    for (const sim::Family::Term& term : family.terms) {
      const LoopChange change = change_with(term.coefficient);
      if (term.parameter == parameter && change != nullptr) terms_.emplace_back(term.factor, change);
    }
  }
  /// Returns true for parameters of the dead band alone.
  bool empty() const noexcept { return terms_.empty(); }
  Complex operator()(const Place& p) const {
    Complex sum = terms_.front().first * terms_.front().second(p);
    for (std::size_t t = 1; t < terms_.size(); ++t) sum += terms_[t].first * terms_[t].second(p);
    return sum;
  }

 private:
  std::vector<std::pair<double, LoopChange>> terms_;
};

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

// Writes columns into strips of rows, as Kernels::add_products reads them.
class Density::Jacobian {
 public:
  Jacobian(const Density& density, const Observation& observation, const Chains& chains, Workspace& work)
      : density_(density),
        observation_(observation),
        chains_(chains),
        work_(work),
        run_(kernels(density.isa_)),
        count_(static_cast<std::size_t>(density.size())),
        noises_(static_cast<std::size_t>(density.noise_.size())),
        kept_(static_cast<std::size_t>(density.spectrum_.rows())),
        rows_(kept_ + static_cast<std::size_t>(observation.missing.count())),
        blocks_of_columns_((count_ + 3) / 4),
        strips_((rows_ + strip_rows - 1) / strip_rows),
        silence_(static_cast<std::size_t>(density.blocks_), 0.0) {
    density.spectrum_.begin_whitening(observation.missing, work.noise, density.isa_);
    const std::size_t strip = 4 * blocks_of_columns_ * strip_size;
    work.columns.resize(strips_ * strip, 0.0);  // the padding of columns stays 0
    std::fill_n(work.columns.end() - static_cast<std::ptrdiff_t>(strip), strip,
                0.0);  // the padding of rows, which another observation may have used
  }

  /// Writes the columns of parameters of the loop, of the start and of the gain, from the forward pass's state.
  void write_loop() {
    for (std::size_t i = 0; i < density_.quantiles_.size(); ++i)
      if (const ParameterChange change(density_.family(), i); !change.empty()) write_loop_column(i, change);
    write_loop_column(density_.place(start), [](const Place& p) { return p.gain * p.s * p.sway; });
    write_loop_column(density_.place(gain), [](const Place& p) { return p.sway; });
  }

  /// Writes the columns of the threshold and of the vestibular noise's level.
  void write_dead_band() {
    set_response();
    std::fill(work_.by_passed.begin(), work_.by_passed.end(), 0.0);
    run_.join(density_.bins_, work_.by_theta.data(), work_.by_passed.data());
    if (const std::optional<std::size_t> theta = density_.family().find_parameter(sim::Coefficient::theta))
      write_passed_column(noises_ + *theta, chains_.d_coordinate[*theta]);
    for (std::size_t i = 0; i < work_.halves.size(); ++i)
      work_.halves[i] = work_.by_low[i] * work_.fine[i] + work_.by_high[i] * work_.fine[i + lanes];
    run_.join(density_.bins_, work_.halves.data(), work_.by_passed.data());
    if (const std::optional<std::size_t> nv = density_.family().find_parameter(sim::Coefficient::nv)) {
      std::array<double, lanes> of_nv;
      for (std::size_t l = 0; l < lanes; ++l) of_nv[l] = chains_.d_nv[l] * chains_.d_coordinate[*nv][l];
      write_passed_column(noises_ + *nv, of_nv);
    }
  }

  /// Writes the columns of the vestibular noise's coefficients; call it after write_dead_band().
  void write_noise() {
    const DeadBandValues values = density_.dead_band_values(chains_, work_);
    const auto last = static_cast<std::size_t>(2 * density_.bins_);
    work_.noise_column.resize(static_cast<std::size_t>(density_.noise_.edges()));
    work_.fine_column.resize(last + 1);
    for (std::size_t i = 0; i < noises_; ++i) {
      density_.noise_.column(static_cast<int>(i), work_.noise_column);
      for (std::size_t half = 0; half <= last; ++half)
        work_.fine_column[half] = refined(work_.noise_column, half, last);
      run_.dead_band_change(2 * density_.bins_, values, work_.fine_column.data(), work_.halves.data());
      run_.join(density_.bins_, work_.halves.data(), work_.by_passed.data());
      write_passed_column(i, chains_.noise_gain);
    }
    std::fill(work_.loop_spectrum.begin(), work_.loop_spectrum.end(), 0.0);
  }

  /// Computes J^t J from all columns: a lower triangle per chain.
  void multiply(std::span<double> matrices) {
    work_.products.assign(blocks_of_columns_ * (blocks_of_columns_ + 1) / 2 * 16 * lanes, 0.0);
    run_.add_products(static_cast<int>(strips_), static_cast<int>(blocks_of_columns_), work_.columns.data(),
                      work_.products.data());
    unpack(work_.products, count_, matrices);
  }

 private:
  static constexpr std::size_t strip_size = std::size_t{strip_rows} * lanes;  // of a column

  /// Writes the column of the observed sway's change, whose transform is in work.sway_spectrum.
  void write(std::size_t column, const std::array<double, lanes>& factors) {
    density_.to_blocks(work_);
    run_.unfold(density_.blocks_, silence_.data(), density_.trial_blocks(work_.modelled), density_.undamp_.data(),
                work_.unfolded.data());
    density_.spectrum_.clear(observation_.missing, work_.unfolded);
    density_.spectrum_.whiten(observation_.missing, work_.unfolded, work_.noise, density_.isa_);
    for (std::size_t k = 0; k < rows_; ++k) {
      const double* in = k < kept_ ? work_.noise.coefficient.data() + k * lanes
                                   : work_.noise.missing_value.data() + (k - kept_) * lanes;
      const std::size_t strip = k / strip_rows, row = k % strip_rows;
      double* out = work_.columns.data() + (strip * 4 * blocks_of_columns_ + column) * strip_size + row * lanes;
      for (std::size_t l = 0; l < lanes; ++l) out[l] = in[l] * factors[l];
    }
  }

  template <class Change>
  void write_loop_column(std::size_t global, const Change& change) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(density_.frequencies_); ++k)
      for (std::size_t l = 0; l < lanes; ++l)
        put_lane(work_.sway_spectrum, k, l, change(locate(k, l)) * in_lane(work_.observe, k, l));
    write(noises_ + global, chains_.d_coordinate[global]);
  }

  /// Writes the column of the passed velocity's change, whose bins are in work.by_passed.
  void write_passed_column(std::size_t column, const std::array<double, lanes>& factors) {
    density_.fft_.forward_lanes(work_.by_passed, work_.loop_spectrum, work_.fft_work, density_.isa_);
    run_.product(density_.frequencies_, work_.loop_spectrum.data(), work_.response.data(), work_.sway_spectrum.data());
    write(column, factors);
  }

  /// Sets work.response: from the transform of the bins to the observed sway's.
  void set_response() {
    for (std::size_t k = 0; k < static_cast<std::size_t>(density_.frequencies_); ++k) {
      for (std::size_t l = 0; l < lanes; ++l) {
        const Place p = locate(k, l);
        put_lane(work_.response, k, l,
                 -(p.gain * p.tilt) * p.active() * p.c() * p.inverse * number(density_.hold_, k) *
                     in_lane(work_.observe, k, l));
      }
    }
  }

  Place locate(std::size_t k, std::size_t l) const {
    using enum sim::Coefficient;
    const Chains& c = chains_;
    Place here{.s = number(density_.s_, k),
               .sum = number(density_.sum_, k),
               .rate = number(density_.rate_, k),
               .platform = number(density_.platform_, k),
               .passed = in_lane(work_.bins_spectrum, k, l),
               .sway = in_lane(work_.sway, k, l),
               .delayed = in_lane(work_.delayed, k, l),
               .inverse = in_lane(work_.inverse, k, l),
               .kp = c[kp][l],
               .kd = c[kd][l],
               .gain = c.value[density_.place(Quantity::gain)][l]};
    if (density_.unit_gains_) return here;
    here.position = c[position][l];
    here.tilt = c[tilt][l];
    here.gravity = c[gravity][l];
    here.slow = c[slow][l];
    here.torque = c[torque][l];
    here.derivative = number(density_.derivative_, k);
    here.slow_response = number(density_.slow_response_, k);
    here.torque_response = number(density_.torque_response_, k);
    return here;
  }

  const Density& density_;
  const Observation& observation_;
  const Chains& chains_;
  Workspace& work_;
  const Kernels& run_;
  std::size_t count_, noises_, kept_, rows_, blocks_of_columns_, strips_;
  std::vector<double> silence_;
};

void Density::add_prior_information(const Chains& c, std::span<double> matrices) const {
  const auto noises = static_cast<std::size_t>(noise_.size());
  const std::optional<std::size_t> nv = family().find_parameter(sim::Coefficient::nv);
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
}

void Density::information(const Observation& observation, std::span<const double> x, std::span<double> matrices,
                          Workspace& work, std::optional<double> fixed_noise_deg) const {
  check(observation, x, matrices.size(), triangle(static_cast<std::size_t>(size())) * lanes);
  const Chains c = chains(x, fixed_noise_deg);
  forward(observation, x, c, work);
  Jacobian jacobian(*this, observation, c, work);
  jacobian.write_loop();
  jacobian.write_dead_band();
  jacobian.write_noise();
  jacobian.multiply(matrices);
  add_prior_information(c, matrices);
  add_noise_information(c, work, matrices);
}

}  // namespace decid::posterior
