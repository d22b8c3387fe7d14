// Measurement noise by its spectrum, for `lanes` chains in parallel: white noise, slow noise, an offset and a straight
// line. The cosine transform (DCT-II, orthonormal) of M blocks of T seconds makes stationary noise independent between
// coefficients. Each coefficient has the power of the spectrum at its frequency k / (2 M T):
//
//   P_k = white (1 + (drift / f_k)^2) + slow / (1 + (2 pi f_k memory)^2), and P_0 also has the offset's prior.
//
// The straight line with its prior adds a matrix of rank one (Woodbury's identity). The transform is a real FFT of the
// reordered blocks: Makhoul, IEEE Trans. Acoust. Speech Signal Process. 28, 1980.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "base/aligned.hpp"
#include "posterior/kernels/kernels.hpp"
#include "sim/fft.hpp"

namespace decid::posterior {

/// One value per chain: variances of a block's mean in rad^2; the square of the slow noise's memory in s^2.
struct NoiseLevels {
  std::array<double, lanes> white, slow, memory;
};

/// Work space for one thread.
struct NoiseWorkspace {
  AlignedVector<double> spectrum, coefficient, precision, slow_fraction, root, line_row, unfolded, fft_work;
  std::array<double, lanes> line;            ///< the straight line's most probable rise from end to end, rad
  std::array<double, lanes> line_precision;  ///< the precision of that rise, with the prior
  std::array<double, lanes> line_shrinkage;
};

class NoiseSpectrum {
 public:
  /// blocks: a number without prime factors above 13 is fast. highest_hz: coefficients above are ignored. drift_hz: the
  /// white noise rises below it.
  NoiseSpectrum(int blocks, double block_s, double highest_hz, double drift_hz);
  /// Returns the largest fast number of blocks, up to `max_blocks`.
  static int fast_blocks(int max_blocks);

  int blocks() const noexcept { return fft_.length(); }
  int rows() const noexcept { return static_cast<int>(line_.size()); }
  double white(std::size_t row) const { return white_[row]; }
  NoiseWorkspace workspace() const;

  // unfolded: one value per block and chain, reordered by Kernels::unfold; blocks() * lanes.

  /// Returns minus the logarithm of the residual's density, up to a constant. Call it before the functions below.
  std::array<double, lanes> misfit(const NoiseLevels& levels, std::span<const double> unfolded, NoiseWorkspace& work,
                                   Isa isa) const;
  struct LevelGradient {
    std::array<double, lanes> white, slow, memory;  ///< memory: by the logarithm of its square
  };
  /// Returns the derivatives of misfit() by the levels, and by the unfolded residual.
  LevelGradient gradient(const NoiseLevels& levels, std::span<double> by_unfolded, NoiseWorkspace& work, Isa isa) const;
  /// Prepares whiten().
  void begin_whitening(NoiseWorkspace& work) const;
  /// Whitens a change of the unfolded blocks into work.coefficient, rows() values per chain. Products of two such
  /// columns equal products with the inverse covariance.
  void whiten(std::span<const double> unfolded, NoiseWorkspace& work, Isa isa) const;
  /// Computes log p of each block of the residual given all others, for blocks in rad; blocks() values per chain.
  void leave_block_out(std::span<double> log_density, NoiseWorkspace& work, Isa isa) const;

 private:
  NoiseRows constants() const;

  sim::RealFft fft_;
  double offset_variance_, line_variance_;
  std::vector<double> turn_, back_;            // complex
  std::vector<double> line_, square_, white_;  // as in NoiseRows; the line rises by 1
};

}  // namespace decid::posterior
