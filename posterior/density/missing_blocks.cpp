// Blocks without a recorded value, integrated out of the density: the members of NoiseSpectrum that take MissingBlocks.
// With C their columns, Q the inverse covariance and s the standard deviation of their values, Woodbury's identity
// gives
//
//   Q - Q C A^-1 C^t Q,  A = C^t Q C + 1 / s^2,
//
// which is Q applied to the residual r - C x, x = A^-1 C^t Q r: the missing blocks get their most probable values.
#include <algorithm>
#include <cmath>

#include "base/math/math.hpp"
#include "posterior/density/spectrum.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::posterior {
namespace {

// Wider than any sway, so it has no influence; it bounds what the ignored frequencies leave open.
constexpr double missing_sd_rad = 10.0 * sim::rad_per_deg;

MissingPairs pairs_of(const MissingBlocks& missing) {
  return {missing.count(), missing.apart.data(), missing.sum.data(), 1.0 / (missing_sd_rad * missing_sd_rad)};
}

std::size_t diagonal(std::size_t row) {
  return row * (row + 3) / 2;
}

/// Returns a block's values of all chains.
std::span<double> block_of(std::span<double> unfolded, int block, int blocks) {
  return unfolded.subspan(static_cast<std::size_t>(unfolded_place(block, blocks)) * lanes, lanes);
}

}  // namespace

MissingBlocks NoiseSpectrum::make_missing(std::vector<int> blocks) const {
  MissingBlocks missing{std::move(blocks)};
  const long long parts = 4LL * this->blocks();
  const auto square = [&](int k) { return (k == 0 ? 1.0 : 2.0) / this->blocks(); };
  const auto entry = [&](int k, int m) {
    return std::sqrt(square(k)) * sincos_of_turn(static_cast<long long>(k) * (2 * m + 1) % parts, parts).cos;
  };
  for (int k = 0; k < rows(); ++k)
    for (const int m : missing.blocks) missing.basis.push_back(entry(k, m));
  for (const int m : missing.blocks)
    for (int k = 0; k < rows(); ++k) missing.basis_columns.push_back(entry(k, m));

  std::vector<int>& distances = missing.distances;
  const auto for_each_pair = [&](const auto& run) {
    for (std::size_t i = 0; i < missing.blocks.size(); ++i)
      for (std::size_t j = 0; j <= i; ++j)
        run(missing.blocks[i] - missing.blocks[j], missing.blocks[i] + missing.blocks[j] + 1);
  };
  for_each_pair([&](int apart, int sum) {
    distances.push_back(apart);
    distances.push_back(sum);
  });
  std::ranges::sort(distances);
  distances.erase(std::ranges::unique(distances).begin(), distances.end());
  const auto place = [&](int distance) {
    return static_cast<int>(std::ranges::lower_bound(distances, distance) - distances.begin());
  };
  for_each_pair([&](int apart, int sum) {
    missing.apart.push_back(place(apart));
    missing.sum.push_back(place(sum));
  });
  const auto cosine = [&](int k, int distance) {
    return square(k) * sincos_of_turn(2LL * k * distance % parts, parts).cos;
  };
  for (int k = 0; k < rows(); ++k)
    for (const int distance : distances) missing.cosines.push_back(cosine(k, distance));
  for (const int distance : distances)
    for (int k = 0; k < rows(); ++k) missing.cosines_by_distance.push_back(cosine(k, distance));
  return missing;
}

void NoiseSpectrum::clear(const MissingBlocks& missing, std::span<double> unfolded) const {
  for (const int m : missing.blocks) std::ranges::fill(block_of(unfolded, m, blocks()), 0.0);
}

void NoiseSpectrum::leave_out(const MissingBlocks& missing, NoiseWorkspace& work, std::array<double, lanes>& misfit,
                              Isa isa) const {
  const int count = missing.count();
  if (count == 0) return;
  const Kernels& run = kernels(isa);
  const auto blocks = static_cast<std::size_t>(count), all = static_cast<std::size_t>(rows());
  const auto distances = static_cast<int>(missing.distances.size());
  work.missing_distances.assign(missing.distances.size() * lanes, 0.0);
  work.missing_along.assign(blocks * lanes, 0.0);
  work.missing_value.assign(blocks * lanes, 0.0);
  work.missing_rise.resize(blocks * lanes);
  work.missing_row.resize(all * lanes);
  work.missing_matrix.resize(blocks * (blocks + 1) / 2 * lanes);

  // C^t Q l with the line's coefficients l, without the line's own part of Q.
  for (std::size_t k = 0; k < all; ++k)
    for (std::size_t l = 0; l < lanes; ++l) work.missing_row[k * lanes + l] = line_[k] * work.precision[k * lanes + l];
  run.add_matrix_times(count, rows(), missing.basis_columns.data(), work.missing_row.data(), work.missing_along.data());
  for (std::size_t i = 0; i < blocks; ++i)
    for (std::size_t l = 0; l < lanes; ++l)
      work.missing_rise[i * lanes + l] = work.missing_along[i * lanes + l] / work.line_precision[l];
  run.add_matrix_times(distances, rows(), missing.cosines_by_distance.data(), work.precision.data(),
                       work.missing_distances.data());
  run.missing_matrix(pairs_of(missing), work.missing_distances.data(), work.missing_along.data(),
                     work.missing_rise.data(), work.missing_matrix.data());
  // C^t Q r.
  for (std::size_t k = 0; k < all; ++k)
    for (std::size_t l = 0; l < lanes; ++l) {
      const std::size_t at = k * lanes + l;
      work.missing_row[at] = work.precision[at] * std::fma(-line_[k], work.line[l], work.coefficient[at]);
    }
  run.add_matrix_times(count, rows(), missing.basis_columns.data(), work.missing_row.data(), work.missing_value.data());
  run.factorize(count, work.missing_matrix.data());
  run.solve_lower(count, work.missing_matrix.data(), work.missing_value.data());
  run.solve_transposed(count, work.missing_matrix.data(), work.missing_value.data());
  for (double& value : work.missing_value) value = -value;
  run.add_matrix_times(rows(), count, missing.basis.data(), work.missing_value.data(), work.coefficient.data());
  for (std::size_t i = 0; i < blocks; ++i)
    for (std::size_t l = 0; l < lanes; ++l)
      work.line[l] = std::fma(work.missing_value[i * lanes + l], work.missing_rise[i * lanes + l], work.line[l]);
  // From the residual with its new values: the difference of two misfits would cancel.
  std::array<double, lanes> squares, of_prior;
  run.squares(count, work.missing_value.data(), of_prior.data());
  squares.fill(0.0);
  for (std::size_t k = 0; k < all; ++k)
    for (std::size_t l = 0; l < lanes; ++l) {
      const double value = work.coefficient[k * lanes + l];
      squares[l] += value * value * work.precision[k * lanes + l];
    }
  for (std::size_t l = 0; l < lanes; ++l) {
    squares[l] -= work.line[l] * work.line[l] * work.line_precision[l];
    misfit[l] = 0.5 * (squares[l] + of_prior[l] / (missing_sd_rad * missing_sd_rad)) + work.half_log_determinant[l];
    for (std::size_t i = 0; i < blocks; ++i)
      misfit[l] += decid::log(missing_sd_rad * work.missing_matrix[diagonal(i) * lanes + l]);
  }
}

// The derivative of log det A / 2 by a coefficient's precision is u^t A^-1 u / 2, where u is the row of C for this
// coefficient less the line's part. The products of two cosines in C are sums of the cosines of both distances.
void NoiseSpectrum::add_gradient(const MissingBlocks& missing, const NoiseLevels& levels, NoiseWorkspace& work,
                                 LevelGradient& by, Isa isa) const {
  const int count = missing.count();
  if (count == 0) return;
  const Kernels& run = kernels(isa);
  const auto blocks = static_cast<std::size_t>(count), all = static_cast<std::size_t>(rows());
  work.missing_inverse.resize(work.missing_matrix.size());
  run.inverse_of_factor(count, work.missing_matrix.data(), work.missing_inverse.data(), work.missing_value.data());
  std::ranges::fill(work.missing_distances, 0.0);
  run.add_to_distances(pairs_of(missing), work.missing_inverse.data(), work.missing_distances.data());
  work.missing_trace.assign(all * lanes, 0.0);
  run.add_matrix_times(rows(), static_cast<int>(missing.distances.size()), missing.cosines.data(),
                       work.missing_distances.data(), work.missing_trace.data());
  // A^-1 applied to the rise of the line in the missing blocks.
  work.missing_value.assign(blocks * lanes, 0.0);
  run.symmetric_times(count, work.missing_inverse.data(), work.missing_rise.data(), work.missing_value.data());
  std::array<double, lanes> square{};
  for (std::size_t i = 0; i < blocks; ++i)
    for (std::size_t l = 0; l < lanes; ++l)
      square[l] = std::fma(work.missing_rise[i * lanes + l], work.missing_value[i * lanes + l], square[l]);
  work.missing_row.assign(all * lanes, 0.0);
  run.add_matrix_times(rows(), count, missing.basis.data(), work.missing_value.data(), work.missing_row.data());
  std::array<double, 3 * lanes> sums;
  run.missing_powers(constants(), levels.slow.data(), work.state(), work.missing_trace.data(), work.missing_row.data(),
                     square.data(), sums.data());
  for (std::size_t l = 0; l < lanes; ++l) {
    by.white[l] += sums[l];
    by.slow[l] += sums[lanes + l];
    by.memory[l] += sums[2 * lanes + l];
  }
}

void NoiseSpectrum::begin_whitening(const MissingBlocks& missing, NoiseWorkspace& work, Isa isa) const {
  begin_whitening(work);
  const std::size_t all = static_cast<std::size_t>(rows()) * lanes, count = static_cast<std::size_t>(missing.count());
  work.missing_columns.resize(count * all);
  for (std::size_t i = 0; i < count; ++i) {
    std::ranges::fill(work.unfolded, 0.0);
    std::ranges::fill(block_of(work.unfolded, missing.blocks[i], blocks()), 1.0);
    whiten(work.unfolded, work, isa);
    std::copy_n(work.coefficient.begin(), all, work.missing_columns.begin() + static_cast<std::ptrdiff_t>(i * all));
  }
}

void NoiseSpectrum::whiten(const MissingBlocks& missing, std::span<const double> unfolded, NoiseWorkspace& work,
                           Isa isa) const {
  whiten(unfolded, work, isa);
  const int count = missing.count();
  if (count == 0) return;
  const Kernels& run = kernels(isa);
  run.columns_times(rows(), count, work.missing_columns.data(), work.coefficient.data(), work.missing_value.data());
  run.solve_lower(count, work.missing_matrix.data(), work.missing_value.data());
  run.solve_transposed(count, work.missing_matrix.data(), work.missing_value.data());
  const std::size_t all = static_cast<std::size_t>(rows()) * lanes;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i)
    run.subtract_times(rows(), work.missing_value.data() + i * lanes, work.missing_columns.data() + i * all,
                       work.coefficient.data());
  for (double& value : work.missing_value) value /= missing_sd_rad;
}

std::vector<double> NoiseSpectrum::explained_by_missing(const MissingBlocks& missing, NoiseWorkspace& work,
                                                        Isa isa) const {
  const auto count = static_cast<std::size_t>(missing.count()), all = static_cast<std::size_t>(rows());
  std::vector<double> sums(static_cast<std::size_t>(blocks()) * lanes, 0.0);
  work.missing_columns.resize(count * all * lanes);
  for (std::size_t i = 0; i < count; ++i) {
    double* column = work.missing_columns.data() + i * all * lanes;
    for (std::size_t k = 0; k < all; ++k)  // of Q C
      for (std::size_t l = 0; l < lanes; ++l) {
        const double rise = work.missing_rise[i * lanes + l], here = missing.basis_columns[i * all + k];
        column[k * lanes + l] = work.precision[k * lanes + l] * std::fma(-line_[k], rise, here);
      }
    for (std::size_t j = 0; j <= i; ++j) {
      std::array<double, lanes> factor;
      const double* row = work.missing_matrix.data() + (diagonal(i) - i + j) * lanes;
      std::copy_n(row, lanes, factor.begin());
      if (j < i) {
        kernels(isa).subtract_times(rows(), factor.data(), work.missing_columns.data() + j * all * lanes, column);
        continue;
      }
      for (std::size_t k = 0; k < all; ++k)
        for (std::size_t l = 0; l < lanes; ++l) column[k * lanes + l] /= factor[l];
    }
    std::fill(work.spectrum.begin() + 2 * rows() * lanes, work.spectrum.end(), 0.0);
    for (std::size_t k = 0; k < all; ++k)
      for (std::size_t l = 0; l < lanes; ++l) {
        work.spectrum[2 * k * lanes + l] = back_[2 * k] * column[k * lanes + l];
        work.spectrum[(2 * k + 1) * lanes + l] = back_[2 * k + 1] * column[k * lanes + l];
      }
    fft_.inverse_lanes(work.spectrum, work.unfolded, work.fft_work, isa);
    for (std::size_t b = 0; b < sums.size(); ++b) sums[b] = std::fma(work.unfolded[b], work.unfolded[b], sums[b]);
  }
  return sums;
}

}  // namespace decid::posterior
