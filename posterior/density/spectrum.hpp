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

/// Blocks without a recorded value, such as a gap that was bridged by a straight line. Each has any value, with a
/// normal prior of 10 degrees that is integrated out.
struct MissingBlocks {
  std::vector<int> blocks = {};            ///< ascending
  std::vector<double> basis = {};          ///< rows() * count(): their cosine transforms, row after row
  std::vector<double> basis_columns = {};  ///< the same, column after column
  /// The differences m - n and the sums m + n + 1 of all pairs of blocks, each once, ascending.
  std::vector<int> distances = {};
  std::vector<int> apart = {}, sum = {};  ///< their places, of each pair, row after row up to the diagonal
  /// The squares of the transform's factors times cos(pi k d / blocks()) of row k and distance d: row after row, and
  /// distance after distance.
  std::vector<double> cosines = {}, cosines_by_distance = {};
  int count() const noexcept { return static_cast<int>(blocks.size()); }
};

/// Work space for one thread.
struct NoiseWorkspace {
  NoiseState state() { return {coefficient.data(), precision.data(), slow_fraction.data()}; }

  AlignedVector<double> spectrum, coefficient, precision, slow_fraction, root, line_row, unfolded, fft_work;
  std::array<double, lanes> line;            ///< the straight line's most probable rise from end to end, rad
  std::array<double, lanes> line_precision;  ///< the precision of that rise, with the prior
  std::array<double, lanes> line_shrinkage;
  std::array<double, lanes> half_log_determinant;  ///< of the covariance
  // For missing blocks: the factor of A (missing_blocks.cpp) and its inverse; values per block, per distance and per
  // coefficient; columns of coefficients.
  AlignedVector<double> missing_matrix, missing_inverse, missing_along, missing_rise, missing_value, missing_distances,
      missing_trace, missing_row, missing_columns;
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
  /// Computes log p of each block of the residual given all others, for blocks in rad; blocks() values per chain.
  /// Missing blocks get 0. Call it after misfit() and leave_out().
  void leave_block_out(const MissingBlocks& missing, std::span<double> log_density, NoiseWorkspace& work,
                       Isa isa) const;

  /// Returns the cosine transforms of missing blocks; blocks: ascending, below blocks().
  MissingBlocks make_missing(std::vector<int> blocks) const;
  /// Sets missing blocks to 0 among unfolded values, or derivatives by them. Their values have no influence, but large
  /// ones would round the others.
  void clear(const MissingBlocks& missing, std::span<double> unfolded) const;
  /// Integrates missing blocks out: adds to misfit() what they change. Replaces their residuals in work by their most
  /// probable values, so gradient() is right after it except for the levels. Call it after misfit().
  void leave_out(const MissingBlocks& missing, NoiseWorkspace& work, std::array<double, lanes>& misfit, Isa isa) const;
  /// Adds to gradient() the part of the levels that missing blocks change. Call it after leave_out().
  void add_gradient(const MissingBlocks& missing, const NoiseLevels& levels, NoiseWorkspace& work, LevelGradient& by,
                    Isa isa) const;
  /// Prepares whiten(). Call it after leave_out().
  void begin_whitening(const MissingBlocks& missing, NoiseWorkspace& work, Isa isa) const;
  /// Whitens a change of the unfolded blocks into work.coefficient, rows() values per chain, and work.missing_value,
  /// missing.count() values more. Products of two such columns equal products with the inverse covariance.
  void whiten(const MissingBlocks& missing, std::span<const double> unfolded, NoiseWorkspace& work, Isa isa) const;

 private:
  // The same without missing blocks.
  void begin_whitening(NoiseWorkspace& work) const;
  void whiten(std::span<const double> unfolded, NoiseWorkspace& work, Isa isa) const;
  NoiseRows constants() const;
  /// Returns how much less precise each block is for the missing ones: blocks() values per chain, in the order of
  /// unfold.
  std::vector<double> explained_by_missing(const MissingBlocks& missing, NoiseWorkspace& work, Isa isa) const;

  sim::RealFft fft_;
  double offset_variance_, line_variance_;
  std::vector<double> turn_, back_;            // complex
  std::vector<double> line_, square_, white_;  // as in NoiseRows; the line rises by 1
};

}  // namespace decid::posterior
