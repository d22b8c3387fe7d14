// Measurement noise by its spectrum against explicit covariance matrices of the blocks, with blocks without a recorded
// value and without: the density integrates them out, and in these matrices they have a variance of their own.
#include "posterior/density/spectrum.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/helpers.hpp"
#include "tests/posterior/density/residuals.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

const std::vector<int> two_gaps{7, 8, 9, 10, 11, 30, 43};  // one at the end of 44 blocks

/// Half of the coefficients, a fifth, and two; lengths whose halves are even and odd; missing blocks.
std::vector<Residuals> cases() {
  return {Residuals(40, 0.1, 2.5), Residuals(42, 0.1, 1.0), Residuals(44, 0.1, 100.0), Residuals(26, 0.05, 0.0),
          Residuals(44, 0.1, 2.5, two_gaps)};
}

}  // namespace

TEST_CASE("NoiseSpectrum: as many blocks as are fast") {
  for (int most = 2; most < 1000; ++most) {
    const int found = NoiseSpectrum::fast_blocks(most);
    int expected = 0;
    for (int blocks = 2; blocks <= most; blocks += 2) {
      int rest = blocks;
      for (const int prime : {2, 3, 5, 7, 11, 13})
        while (rest % prime == 0) rest /= prime;
      if (rest == 1) expected = blocks;
    }
    REQUIRE(found == expected);
  }
}

TEST_CASE("NoiseSpectrum: coefficients up to a frequency, at most half of them, at least two") {
  CHECK(NoiseSpectrum(40, 0.1, 2.0, 0.0).rows() == 17);  // k / 8 s
  CHECK(NoiseSpectrum(40, 0.1, 2.5, 0.0).rows() == 20);
  CHECK(NoiseSpectrum(40, 0.1, 0.01, 0.0).rows() == 2);
  const NoiseSpectrum drifting(40, 0.1, 2.5, 0.25);
  CHECK(drifting.white(0) == 1.0);
  CHECK(near(drifting.white(2), 2.0, 8.0 * epsilon));
}

TEST_CASE("NoiseSpectrum: the misfit is the Gaussian density of the kept coefficients") {
  for (Residuals& r : cases()) {
    const std::array<double, lanes> misfit = r.misfit();
    for (std::size_t l = 0; l < lanes; ++l) {
      const DenseNoise dense = r.dense(l);
      const std::vector<double> kept = dense.transform(r.rows, r.folded(r.unfolded, l));
      const DenseGaussian gaussian = dense.of_coefficients(r.rows);
      const double scale = gaussian.product(kept, kept) + std::abs(gaussian.log_determinant());
      CHECK(within(misfit[l], gaussian.misfit(kept), dense.rounding(r.rows) * scale));
    }
  }
}

TEST_CASE("NoiseSpectrum: derivatives by the levels are those of finite differences") {
  for (Residuals& r : cases()) {
    const std::array<double, lanes> here = r.misfit();
    AlignedVector<double> by_unfolded(r.unfolded.size());
    const NoiseSpectrum::LevelGradient by = r.gradient(by_unfolded);
    // By logarithms, so that a step is right for all; its errors are alike at the cube root of epsilon.
    const double step = 6e-6;
    for (std::array<double, lanes> NoiseLevels::*const level :
         {&NoiseLevels::white, &NoiseLevels::slow, &NoiseLevels::memory}) {
      const NoiseLevels levels = r.levels;
      for (double& value : r.levels.*level) value *= std::exp(step);
      const std::array<double, lanes> above = r.misfit();
      r.levels = levels;
      for (double& value : r.levels.*level) value *= std::exp(-step);
      const std::array<double, lanes> below = r.misfit();
      r.levels = levels;
      for (std::size_t l = 0; l < lanes; ++l) {
        const double derivative = level == &NoiseLevels::white  ? by.white[l] * levels.white[l]
                                  : level == &NoiseLevels::slow ? by.slow[l] * levels.slow[l]
                                                                : by.memory[l];
        // The logarithms of the variances, of some 1e-9, cancel in part.
        const double scale = std::abs(here[l]) + 20.0 * static_cast<double>(r.rows);
        CHECK(within(derivative, (above[l] - below[l]) / (2.0 * step), 100.0 * (epsilon / step + step * step) * scale));
      }
    }
  }
}

TEST_CASE("NoiseSpectrum: derivatives by the residual are the inverse covariance times it") {
  for (Residuals& r : cases()) {
    r.misfit();
    AlignedVector<double> by_unfolded(r.unfolded.size());
    r.gradient(by_unfolded);
    for (std::size_t l = 0; l < lanes; ++l) {
      const DenseNoise dense = r.dense(l);
      const DenseGaussian gaussian = dense.of_coefficients(r.rows);
      const std::vector<double> derivative = r.folded(by_unfolded, l);
      const std::vector<double> kept = dense.transform(r.rows, r.folded(r.unfolded, l));
      for (std::size_t m = 0; m < r.blocks; ++m) {
        std::vector<double> unit(r.blocks, 0.0);
        unit[m] = 1.0;
        const std::vector<double> its = dense.transform(r.rows, unit);
        // Entries of the matrix without missing blocks cancel.
        const double of_unit = r.missing.count() > 0 ? 1.0 / r.levels.white[l] : gaussian.product(its, its);
        const double scale = std::sqrt(gaussian.product(kept, kept) * of_unit);
        CHECK(within(derivative[m], gaussian.product(kept, its), dense.rounding(r.rows) * scale));
      }
    }
  }
}

TEST_CASE("NoiseSpectrum: products of whitened columns are those of the inverse covariance") {
  for (Residuals& r : cases()) {
    r.misfit();
    r.spectrum.begin_whitening(r.missing, r.work, chosen_isa());
    std::array<std::vector<std::vector<double>>, 2> columns;  // of each chain
    std::array<AlignedVector<double>, 2> whitened;            // each missing block gives a value more
    for (std::size_t i = 0; i < 2; ++i) {
      for (std::size_t l = 0; l < lanes; ++l) {
        columns[i].push_back(r.random(100 * (i + 1) + l, 1e-3));
        r.put(columns[i].back(), l);
      }
      r.spectrum.whiten(r.missing, r.unfolded, r.work, chosen_isa());
      whitened[i] = r.work.coefficient;
      whitened[i].insert(whitened[i].end(), r.work.missing_value.begin(), r.work.missing_value.end());
      REQUIRE(whitened[i].size() == (r.rows + r.missing.blocks.size()) * lanes);
    }
    for (std::size_t l = 0; l < lanes; ++l) {
      const DenseNoise dense = r.dense(l);
      const DenseGaussian gaussian = dense.of_coefficients(r.rows);
      for (std::size_t a = 0; a < 2; ++a) {
        for (std::size_t b = 0; b <= a; ++b) {
          const std::vector<double> of_a = dense.transform(r.rows, columns[a][l]),
                                    of_b = dense.transform(r.rows, columns[b][l]);
          double product = 0.0;
          for (std::size_t k = l; k < whitened[a].size(); k += lanes) product += whitened[a][k] * whitened[b][k];
          const double scale = std::sqrt(gaussian.product(of_a, of_a) * gaussian.product(of_b, of_b));
          CHECK(within(product, gaussian.product(of_a, of_b), dense.rounding(r.rows) * scale));
        }
      }
    }
  }
}

// The coefficients that are left out have a variance that says nothing: 1e8 times the smallest one's, so that what it
// does say and what rounding leaves are both 1e-8; so do missing blocks.
TEST_CASE(
    "NoiseSpectrum: a block given all others has the density of all over that of the others, a missing one none") {
  for (Residuals& r : cases()) {
    if (r.rows < 8) continue;  // offset and line alone say as little
    r.misfit();
    std::vector<double> log_density(r.blocks * lanes, 1.0);
    r.spectrum.leave_block_out(r.missing, log_density, r.work, chosen_isa());
    for (std::size_t l = 0; l < lanes; ++l) {
      const DenseNoise dense = r.dense(l);
      const std::vector<double> covariance = dense.of_blocks(r.rows, 1e8 * r.levels.white[l]);
      const std::vector<double> residual = r.folded(r.unfolded, l);
      const double all = DenseGaussian(covariance).misfit(residual);
      for (std::size_t i = 0; i < r.blocks; ++i) {
        if (std::ranges::count(r.missing.blocks, static_cast<int>(i)) > 0) {
          CHECK(log_density[i * lanes + l] == 0.0);
          continue;
        }
        std::vector<double> others, of_others;
        for (std::size_t m = 0; m < r.blocks; ++m) {
          if (m == i) continue;
          of_others.push_back(residual[m]);
          for (std::size_t n = 0; n < r.blocks; ++n)
            if (n != i) others.push_back(covariance[m * r.blocks + n]);
        }
        const double expected = DenseGaussian(others).misfit(of_others) - all - 0.5 * std::log(2.0 * sim::pi);
        CHECK(within(log_density[i * lanes + l], expected, r.missing.count() > 0 ? 1e-4 : 1e-5));
      }
    }
  }
}

TEST_CASE("NoiseSpectrum: the same bits for every instruction set") {
  for (const std::vector<int>& missing : {std::vector<int>(), two_gaps}) {
    std::vector<double> first;
    for (const Isa isa : available_isas()) {
      Residuals r(44, 0.1, 2.5, missing);
      AlignedVector<double> by_unfolded(r.unfolded.size());
      std::vector<double> all(r.blocks * lanes);
      const auto add = [&](const auto& values) { all.insert(all.end(), values.begin(), values.end()); };
      add(r.misfit(isa));
      r.spectrum.leave_block_out(r.missing, all, r.work, isa);
      r.misfit(isa);
      const NoiseSpectrum::LevelGradient by = r.gradient(by_unfolded, isa);
      add(by_unfolded);
      for (const auto& values : {by.white, by.slow, by.memory}) add(values);
      r.misfit(isa);
      r.spectrum.begin_whitening(r.missing, r.work, isa);
      r.spectrum.whiten(r.missing, r.unfolded, r.work, isa);
      add(r.work.coefficient);
      add(r.work.missing_value);
      if (first.empty()) first = all;
      CHECK(all == first);
    }
  }
}
