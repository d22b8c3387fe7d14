// Residuals of blocks with known noise, in NoiseSpectrum's order and as explicit matrices.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "base/math/random.hpp"
#include "posterior/density/spectrum.hpp"
#include "posterior/streams.hpp"
#include "tests/posterior/density/dense_noise.hpp"

namespace decid::test {

/// Eight residuals with eight levels of noise.
struct Residuals {
  static constexpr double drift_hz = 0.03;

  posterior::NoiseSpectrum spectrum;
  double block_s;
  std::size_t blocks, rows;
  posterior::MissingBlocks missing;
  posterior::NoiseLevels levels;
  AlignedVector<double> unfolded;
  posterior::NoiseWorkspace work;

  Residuals(int count, double block_s_, double highest_hz, std::vector<int> missing_blocks = {})
      : spectrum(count, block_s_, highest_hz, drift_hz),
        block_s(block_s_),
        blocks(static_cast<std::size_t>(spectrum.blocks())),
        rows(static_cast<std::size_t>(spectrum.rows())),
        missing(spectrum.make_missing(std::move(missing_blocks))),
        unfolded(blocks * posterior::lanes),
        work(spectrum.workspace()) {
    for (std::size_t l = 0; l < posterior::lanes; ++l) {
      const double white = (0.002 + 0.003 * static_cast<double>(l)) * sim::rad_per_deg;
      levels.white[l] = white * white;
      levels.slow[l] = l == 0 ? 0.0 : 20.0 / static_cast<double>(l) * levels.white[l];
      levels.memory[l] = std::pow(0.5 + static_cast<double>(l), 2);
      put(random(l, std::sqrt(levels.white[l] * 2.0)), l);
    }
  }
  DenseNoise dense(std::size_t l) const {
    return {blocks, block_s, drift_hz, levels.white[l], levels.slow[l], levels.memory[l], missing.blocks};
  }
  /// Returns noise, an offset and a line.
  std::vector<double> random(std::uint64_t item, double sd) const {
    std::vector<double> values(blocks);
    Random(4, posterior::streams::chains, item).fill_normal(values);
    for (std::size_t m = 0; m < blocks; ++m) values[m] = sd * (values[m] + 30.0 + 0.7 * static_cast<double>(m));
    return values;
  }
  std::size_t at(std::size_t m, std::size_t l) const {
    const auto place = posterior::unfolded_place(static_cast<std::ptrdiff_t>(m), static_cast<std::ptrdiff_t>(blocks));
    return static_cast<std::size_t>(place) * posterior::lanes + l;
  }
  void put(const std::vector<double>& values, std::size_t l) {
    for (std::size_t m = 0; m < blocks; ++m) unfolded[at(m, l)] = values[m];
  }
  std::vector<double> folded(const AlignedVector<double>& from, std::size_t l) const {
    std::vector<double> values(blocks);
    for (std::size_t m = 0; m < blocks; ++m) values[m] = from[at(m, l)];
    return values;
  }
  std::array<double, posterior::lanes> misfit(Isa isa = chosen_isa()) {
    std::array<double, posterior::lanes> value = spectrum.misfit(levels, unfolded, work, isa);
    spectrum.leave_out(missing, work, value, isa);
    return value;
  }
  posterior::NoiseSpectrum::LevelGradient gradient(AlignedVector<double>& by_unfolded, Isa isa = chosen_isa()) {
    posterior::NoiseSpectrum::LevelGradient by = spectrum.gradient(levels, by_unfolded, work, isa);
    spectrum.add_gradient(missing, levels, work, by, isa);
    return by;
  }
};

}  // namespace decid::test
