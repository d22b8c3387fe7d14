// Measurement noise by its spectrum: see spectrum.hpp.
#include "posterior/density/spectrum.hpp"

#include <algorithm>
#include <cmath>

#include "base/math/math.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::posterior {
namespace {

// Wider than any recording's, so they have no influence.
constexpr double offset_sd_rad = 10.0 * sim::rad_per_deg, line_sd_rad = 10.0 * sim::rad_per_deg;
constexpr int max_fast_prime = 13;
constexpr double rounded_precision = 1e-12;  // of a block given the others, over that with known line and gaps

}  // namespace

int NoiseSpectrum::fast_blocks(int max_blocks) {
  int blocks = max_blocks - max_blocks % 2;
  while (blocks > 2 && sim::max_prime_factor(blocks) > max_fast_prime) blocks -= 2;
  return blocks;
}

NoiseSpectrum::NoiseSpectrum(int blocks, double block_s, double highest_hz, double drift_hz)
    : fft_(blocks),
      offset_variance_(offset_sd_rad * offset_sd_rad * blocks),
      line_variance_(line_sd_rad * line_sd_rad) {
  // At most half of the coefficients: they are in the stored half of a real transform's bins.
  const double length_s = blocks * block_s;
  const int count = std::clamp(static_cast<int>(2.0 * length_s * highest_hz) + 1, 2, std::max(2, blocks / 2));
  for (int k = 0; k < count; ++k) {
    const auto [sin, cos] = sincos_of_turn(k, 4LL * blocks);
    const double norm = std::sqrt((k == 0 ? 1.0 : 2.0) / blocks);
    turn_.push_back(norm * cos);
    turn_.push_back(-norm * sin);
    // The inverse divides by the length, and each bin except the first represents two.
    const double of_inverse = k == 0 ? blocks : 0.5 * blocks;
    back_.push_back(of_inverse * norm * cos);
    back_.push_back(of_inverse * norm * sin);
    const double omega = sim::pi * k / length_s;
    square_.push_back(omega * omega);
    const double drift = k == 0 ? 0.0 : 2.0 * sim::pi * drift_hz / omega;
    white_.push_back(1.0 + drift * drift);
    // The line (m + 1/2) / blocks - 1/2: 0 for even k.
    double sum = 0.0;
    if (k % 2 == 1) {
      for (int m = 0; m < blocks; ++m) {
        const double place = (m + 0.5) / blocks - 0.5;
        sum = std::fma(place, sincos_of_turn(static_cast<long long>(k) * (2 * m + 1), 4LL * blocks).cos, sum);
      }
    }
    line_.push_back(norm * sum);
  }
}

NoiseWorkspace NoiseSpectrum::workspace() const {
  NoiseWorkspace work;
  const auto of = [](int count) { return static_cast<std::size_t>(count) * lanes; };
  work.spectrum.assign(of(2 * fft_.bins()), 0.0);
  for (auto* values : {&work.coefficient, &work.precision, &work.slow_fraction, &work.root, &work.line_row})
    values->assign(of(rows()), 0.0);
  work.unfolded.assign(of(blocks()), 0.0);
  work.fft_work.assign(of(2 * fft_.work_length()), 0.0);
  return work;
}

NoiseRows NoiseSpectrum::constants() const {
  return {rows(), turn_.data(), back_.data(), line_.data(), square_.data(), white_.data(), offset_variance_};
}

std::array<double, lanes> NoiseSpectrum::misfit(const NoiseLevels& levels, std::span<const double> unfolded,
                                                NoiseWorkspace& work, Isa isa) const {
  fft_.forward_lanes(unfolded, work.spectrum, work.fft_work, isa);
  std::array<double, 4 * lanes> sums;
  kernels(isa).noise_rows(constants(), {levels.white.data(), levels.slow.data(), levels.memory.data()},
                          work.spectrum.data(), work.state(), sums.data());
  std::array<double, lanes> misfit;
  for (std::size_t l = 0; l < lanes; ++l) {
    const double along = sums[lanes + l];
    work.line_precision[l] = 1.0 / line_variance_ + sums[2 * lanes + l];
    work.line[l] = along / work.line_precision[l];
    work.half_log_determinant[l] = 0.5 * (sums[3 * lanes + l] + decid::log(line_variance_ * work.line_precision[l]));
    misfit[l] = 0.5 * (sums[l] - along * work.line[l]) + work.half_log_determinant[l];
  }
  return misfit;
}

NoiseSpectrum::LevelGradient NoiseSpectrum::gradient(const NoiseLevels& levels, std::span<double> by_unfolded,
                                                     NoiseWorkspace& work, Isa isa) const {
  std::array<double, lanes> uncertainty;
  for (std::size_t l = 0; l < lanes; ++l) uncertainty[l] = 1.0 / work.line_precision[l];
  std::array<double, 3 * lanes> sums;
  std::fill(work.spectrum.begin() + 2 * rows() * lanes, work.spectrum.end(), 0.0);
  kernels(isa).noise_rows_gradient(constants(), {levels.white.data(), levels.slow.data(), levels.memory.data()},
                                   work.line.data(), uncertainty.data(), work.state(), work.spectrum.data(),
                                   sums.data());
  fft_.inverse_lanes(work.spectrum, by_unfolded, work.fft_work, isa);
  LevelGradient by;
  std::copy_n(sums.begin(), lanes, by.white.begin());
  std::copy_n(sums.begin() + lanes, lanes, by.slow.begin());
  std::copy_n(sums.begin() + 2 * lanes, lanes, by.memory.begin());
  return by;
}

// With w the whitened line, |w|^2 = d - 1 / v, the covariance's rank-one part leaves 1 - w w^t / d, whose root is
// 1 - c w w^t, c = (1 - sqrt(1 - |w|^2 / d)) / |w|^2.
void NoiseSpectrum::begin_whitening(NoiseWorkspace& work) const {
  for (std::size_t k = 0; k < line_.size(); ++k) {
    for (std::size_t l = 0; l < lanes; ++l) {
      const std::size_t at = k * lanes + l;
      work.root[at] = std::sqrt(work.precision[at]);
      work.line_row[at] = line_[k] * work.root[at];
    }
  }
  for (std::size_t l = 0; l < lanes; ++l) {
    const double left = 1.0 / (line_variance_ * work.line_precision[l]);  // the remainder of 1 - |w|^2 / d
    const double square = work.line_precision[l] * (1.0 - left);
    work.line_shrinkage[l] = square > 0.0 ? (1.0 - std::sqrt(left)) / square : 0.0;
  }
}

void NoiseSpectrum::whiten(std::span<const double> unfolded, NoiseWorkspace& work, Isa isa) const {
  fft_.forward_lanes(unfolded, work.spectrum, work.fft_work, isa);
  kernels(isa).whiten(constants(), work.spectrum.data(), work.root.data(), work.line_row.data(),
                      work.line_shrinkage.data(), work.coefficient.data());
}

// A Gaussian r with inverse covariance Q: block i given the others has the precision Q_ii and the mean
// r_i - (Q r)_i / Q_ii.
void NoiseSpectrum::leave_block_out(const MissingBlocks& missing, std::span<double> log_density, NoiseWorkspace& work,
                                    Isa isa) const {
  const auto count = static_cast<std::size_t>(blocks()), kept = line_.size();
  const std::vector<double> explained = explained_by_missing(missing, work, isa);
  // Q r, unfolded: the gradient of the misfit.
  std::array<double, lanes> uncertainty, nothing{};
  for (std::size_t l = 0; l < lanes; ++l) uncertainty[l] = 1.0 / work.line_precision[l];
  std::array<double, 3 * lanes> sums;
  std::fill(work.spectrum.begin() + 2 * rows() * lanes, work.spectrum.end(), 0.0);
  kernels(isa).noise_rows_gradient(constants(), {nothing.data(), nothing.data(), nothing.data()}, work.line.data(),
                                   uncertainty.data(), work.state(), work.spectrum.data(), sums.data());
  fft_.inverse_lanes(work.spectrum, work.unfolded, work.fft_work, isa);
  // The line's part of a block, sum of entry * line * precision, is its inverse cosine transform, unfolded.
  AlignedVector<double> along(work.unfolded.size()), precision(work.unfolded.size());
  const auto transform = [&](const auto& coefficient, AlignedVector<double>& out) {
    std::ranges::fill(work.spectrum, 0.0);
    for (std::size_t k = 0; k < kept; ++k) {
      const sim::Complex factor = coefficient(k);
      for (std::size_t l = 0; l < lanes; ++l) {
        const double value = work.precision[k * lanes + l];
        work.spectrum[2 * k * lanes + l] = factor.real() * value;
        work.spectrum[(2 * k + 1) * lanes + l] = factor.imag() * value;
      }
    }
    fft_.inverse_lanes(work.spectrum, out, work.fft_work, isa);
  };
  transform([&](std::size_t k) { return line_[k] * sim::Complex(back_[2 * k], back_[2 * k + 1]); }, along);
  // Q_ii without the line: the squares of the entries, (1 + cos(pi k (2 m + 1) / blocks)) / blocks and half of it for
  // k = 0, are another transform plus the sum over all coefficients. Block after block.
  transform(
      [&](std::size_t k) {
        const auto [sin, cos] = sincos_of_turn(static_cast<long long>(k), 2LL * blocks());
        return k == 0 ? sim::Complex(0.5) : 0.5 * sim::Complex(cos, sin);
      },
      precision);
  std::array<double, lanes> sum{};
  for (std::size_t k = 0; k < kept; ++k)
    for (std::size_t l = 0; l < lanes; ++l)
      sum[l] += work.precision[k * lanes + l] * ((k == 0 ? 0.5 : 1.0) / static_cast<double>(count));
  const double constant = -0.5 * decid::log(2.0 * sim::pi);
  for (std::size_t m = 0; m < count; ++m) {
    const std::size_t place =
        static_cast<std::size_t>(unfolded_place(static_cast<std::ptrdiff_t>(m), fft_.length())) * lanes;
    for (std::size_t l = 0; l < lanes; ++l) {
      const double all = sum[l] + precision[m * lanes + l], of_line = along[place + l];
      // A block that nothing else predicts keeps a precision of rounding.
      const double left =
          std::max(all - of_line * of_line * uncertainty[l] - explained[place + l], rounded_precision * all);
      const double weighed = work.unfolded[place + l];
      log_density[m * lanes + l] = constant + 0.5 * decid::log(left) - 0.5 * weighed * weighed / left;
    }
  }
  for (const int m : missing.blocks)
    std::fill_n(log_density.begin() + static_cast<std::ptrdiff_t>(m) * static_cast<std::ptrdiff_t>(lanes), lanes, 0.0);
}

}  // namespace decid::posterior
