// The kernels of the posterior density, one table per instruction set. All compute the same bits. They process `lanes`
// chains in parallel: value n of chain l is at [n * lanes + l], the parts of complex value n at [2 n * lanes + l] and
// [(2 n + 1) * lanes + l].
#pragma once

#include <cstddef>

#include "base/isa.hpp"
#include "sim/fft.hpp"

namespace decid::posterior {

inline constexpr int lanes = sim::fft_lanes;
inline constexpr int strip_rows = 32;  ///< of add_products

/// Returns the place of block m of `count` among unfolded ones: the even ones, then the odd ones backwards (Makhoul's
/// cosine transform). Always inline, because the linker may choose the copy of another instruction set.
[[gnu::always_inline]] constexpr std::ptrdiff_t unfolded_place(std::ptrdiff_t m, std::ptrdiff_t count) {
  return m % 2 == 0 ? m / 2 : count - 1 - m / 2;
}

constexpr std::size_t inverse_work(std::size_t size) {
  return size * ((size + 31) / 32 * 32);
}

/// The dead band on bins of time, in each of which the platform's velocity and the noise's are linear.
struct DeadBandBins {
  int count;
  const double* rate_low;   ///< the platform's velocity at the bin's begin, rad/s
  const double* rate_high;  ///< and at its end
  const double* weight;     ///< of a bin in the transform
};
/// Values of `lanes` chains. The noise has count + 1 values, at the bins' edges.
struct DeadBandValues {
  const double* noise;    ///< velocity for a gain of 1, rad/s
  const double* gain;     ///< one value per chain
  const double* theta;    ///< one value per chain, rad/s
  double* passed;         ///< the mean output of the dead band, times the weight
  double* by_noise_low;   ///< derivatives of `passed` by gain * noise at a bin's begin
  double* by_noise_high;  ///< at its end
  double* by_theta;
};
/// Converts derivatives by `passed` to derivatives by the noise at the edges, by the gain and by theta.
struct DeadBandGradient {
  const double* by_passed;
  double* by_noise;  ///< count + 1 values per chain, of gain * noise
  double* by_gain;   ///< one value per chain
  double* by_theta;  ///< one value per chain
};

/// Values at each frequency s of the contour that do not depend on the parameters: complex numbers, the same for all
/// chains.
struct LoopConstants {
  int count;
  const double* s;         ///< 1/s
  const double* sum;       ///< from a velocity's steps to an angle: T / (z - 1), s
  const double* rate;      ///< from an angle to its velocity: (z - 1) / (T z), 1/s
  const double* body;      ///< J (z - 1)^2 / (T^2 z) - m g h, N m/rad
  const double* hold;      ///< from a bin's value to its steps
  const double* observe;   ///< from sway to the mean of a block of samples
  const double* platform;  ///< transform of the platform's velocity
  const double* unbinned;  ///< the platform's velocity minus what the bins have of it
  const double* torque;    ///< transform of the torque of gravity minus m g h times the angle
  double back;             ///< LoopGradient::by_observed is conjugated and multiplied by this
  // For members of the family without unit gains:
  const double* derivative = nullptr;       ///< from a signal to its change in a step: (z - 1) / T, 1/s
  const double* slow_response = nullptr;    ///< slow feedback for a gain of 1 /s: T / (z - 1 + T / slow_time), s
  const double* torque_response = nullptr;  ///< T / (z (z - 1 + T / torque_time)) over m g h, s / (N m)
};
/// Parameters of the chains, `lanes` values each.
struct LoopParameters {
  const double *kp, *kd, *kp_pass, *kd_pass;
  const double* gain;
  const double *delay_first,
      *delay_turn;  ///< complex, exp(-s delay) at the first frequency, and its factor from one to the next
  const double *start_first, *start_turn;  ///< the same for exp(s start)
  // For members of the family without unit gains: see sim/family.hpp.
  const double *position = nullptr, *tilt = nullptr, *gravity = nullptr, *slow = nullptr, *torque = nullptr;
};
/// The state that the forward pass leaves for the backward pass; complex, count values per chain each.
struct LoopState {
  double* passed;    ///< in: transform of the bins; out: times hold, plus unbinned
  double* delayed;   ///< exp(-s delay)
  double* inverse;   ///< 1 / D
  double* sway;      ///< transform of the sway
  double* observe;   ///< observe * exp(s start)
  double* observed;  ///< transform of the observed sway
};
struct LoopGradient {
  const double* by_observed;  ///< transform of the derivatives by the observed values; complex
  double* by_passed;          ///< out: the transform of the derivatives by the bins, complex
  /// 7 values per chain: by kp, kd, kp_pass, kd_pass, delay, start, gain; without unit gains 5 more: by position, tilt,
  /// gravity, slow, torque.
  double* sums;
};
inline constexpr std::size_t loop_sums = 12;

/// Constants of the cosine transform's coefficients, the same for all chains: see spectrum.hpp.
struct NoiseRows {
  int count;
  const double* turn;    ///< complex: coefficient k is Re(turn[k] spectrum[k])
  const double* back;    ///< complex: from a derivative by coefficient k to the transform that is inverted
  const double* line;    ///< of the straight line
  const double* square;  ///< (2 pi f)^2, 1/s^2
  const double* white;   ///< the white noise's power, including drift
  double first;          ///< the offset's variance, which adds to coefficient 0
};
/// One value per chain each: see NoiseLevels.
struct NoiseVariances {
  const double *white, *slow, *memory;
};
/// The missing blocks, which may have any value: see MissingBlocks (posterior/density/spectrum.hpp).
struct MissingPairs {
  int count;               ///< of blocks
  const int *apart, *sum;  ///< of each pair, row after row up to the diagonal: places among MissingBlocks::distances
  double prior_precision;  ///< of each block's value, 1/rad^2
};
/// count values per chain each.
struct NoiseState {
  double *coefficient, *precision, *slow_fraction;  ///< slow_fraction: 1 / (1 + square * memory)
};

struct Kernels {
  void (*dead_band)(const DeadBandBins&, const DeadBandValues&);
  void (*dead_band_gradient)(const DeadBandBins&, const DeadBandValues&, const DeadBandGradient&);
  /// Interpolates between values by cubics through four of them, linearly at the ends: fine has 2 count - 1 values per
  /// chain.
  void (*refine)(int count, const double* coarse, double* fine);
  /// Converts derivatives by fine values to derivatives by coarse ones.
  void (*refine_gradient)(int count, const double* by_fine, double* by_coarse);
  /// Joins halves of bins, two per bin. A bin keeps their mean, and moves their difference as mass, which makes it more
  /// than a held mean. bins[i] = (h[2 i] + h[2 i + 1]) / 2 + d[i - 1] - d[i + 1], d[i] = (h[2 i + 1] - h[2 i]) / 12.
  void (*join)(int count, const double* halves, double* bins);
  /// Converts derivatives by the bins to derivatives by their halves.
  void (*join_gradient)(int count, const double* by_bins, double* by_halves);
  /// Computes the change of `passed` with noise that is the same for all chains: count + 1 values at the bins' edges.
  void (*dead_band_change)(int count, const DeadBandValues&, const double* noise, double* passed);
  void (*loop)(const LoopConstants&, const LoopParameters&, const LoopState&);
  void (*loop_gradient)(const LoopConstants&, const LoopParameters&, const LoopState&, const LoopGradient&);
  /// The same for members of the family without unit gains.
  void (*family_loop)(const LoopConstants&, const LoopParameters&, const LoopState&);
  void (*family_loop_gradient)(const LoopConstants&, const LoopParameters&, const LoopState&, const LoopGradient&);
  /// Computes out = a b, complex.
  void (*product)(int count, const double* a, const double* b, double* out);
  /// Computes out[i] = in[i] * factors[i], complex; the factors are the same for all chains.
  void (*turn)(int count, const double* in, const double* factors, double* out);
  /// Computes out[i] += in[i] * conj(factors[i]), complex; the factors are the same for all chains.
  void (*add_conjugate_product)(int count, const double* in, const double* factors, double* out);
  /// Computes out = in * factors, real; the factors are the same for all chains.
  void (*scale)(int count, const double* in, const double* factors, double* out);
  /// Reorders blocks as unfolded_place() states. out[place of m] = recorded[m] - modelled[m] * factors[m]; recorded:
  /// the same for all chains.
  void (*unfold)(int count, const double* recorded, const double* modelled, const double* factors, double* out);
  /// Inverts unfold: out[m] = unfolded[place of m] * factors[m].
  void (*fold)(int count, const double* unfolded, const double* factors, double* out);
  /// Computes NoiseState from the transform of unfolded blocks. sums: 4 values per chain, over the coefficients R with
  /// precision u: the sums of u R^2, u R line, u line^2 and -log u.
  void (*noise_rows)(const NoiseRows&, const NoiseVariances&, const double* spectrum, const NoiseState&, double* sums);
  /// Differentiates half the sum of u e^2 and -log u, with e = R - line * rise. Writes its derivatives by R for the
  /// inverse transform; sums: 3 values per chain, by white, slow and the logarithm of memory. uncertainty: the variance
  /// of the rise.
  void (*noise_rows_gradient)(const NoiseRows&, const NoiseVariances&, const double* rise, const double* uncertainty,
                              const NoiseState&, double* spectrum, double* sums);
  /// Computes out = root R - line_row * shrinkage * (their product with line_row) from coefficients R; shrinkage: one
  /// value per chain.
  void (*whiten)(const NoiseRows&, const double* spectrum, const double* root, const double* line_row,
                 const double* shrinkage, double* out);
  /// Writes the matrix of missing blocks, a lower triangle: half the sum of `cosines` at both distances of a pair, less
  /// the product of their values in `along` and `rise`, plus the prior's precision in the diagonal.
  void (*missing_matrix)(const MissingPairs&, const double* cosines, const double* along, const double* rise,
                         double* matrix);
  /// Adds a symmetric matrix, row after row up to the diagonal, to the distances of its pairs: half of each entry of
  /// the whole matrix to both distances.
  void (*add_to_distances)(const MissingPairs&, const double* matrix, double* distances);
  /// Computes the product of each of `count` columns of `rows` values with `in`: count values per chain.
  void (*columns_times)(int rows, int count, const double* columns, const double* in, double* out);
  /// Computes the sums over the coefficients of -t d / 2, d: the derivatives of a coefficient's precision by white,
  /// slow and the logarithm of memory, times -1; t = trace - 2 line along + line^2 square. trace, along: one value per
  /// coefficient and chain; square: one value per chain. sums: 3 values per chain.
  void (*missing_powers)(const NoiseRows&, const double* slow, const NoiseState&, const double* trace,
                         const double* along, const double* square, double* sums);
  /// Computes out = T in for a lower triangular T, row after row: row i has i + 1 values.
  void (*lower_times)(int size, const double* lower, const double* in, double* out);
  /// Computes out = T^t in.
  void (*upper_times)(int size, const double* lower, const double* in, double* out);
  /// Computes out += matrix in, with the matrix row after row.
  void (*add_matrix_times)(int rows, int columns, const double* matrix, const double* in, double* out);
  /// Factorizes each chain's symmetric matrix, stored row after row up to the diagonal, into its Cholesky factor. A
  /// chain whose matrix is not positive definite gets NaN.
  void (*factorize)(int size, double* matrix);
  /// Solves lower x = x, and lower^t x = x, for each chain.
  void (*solve_lower)(int size, const double* lower, double* x);
  void (*solve_transposed)(int size, const double* lower, double* x);
  /// Computes the inverse of each chain's matrix from its Cholesky factor; both row after row up to the diagonal.
  /// column: work space of `size` values per chain.
  void (*inverse_of_factor)(int size, const double* lower, double* inverse, double* column);
  /// Computes out += matrix in for each chain: a symmetric matrix, row after row up to the diagonal.
  void (*symmetric_times)(int size, const double* matrix, const double* in, double* out);
  /// Stretches values: root: 4 q becomes q; cube: q^3; values *= q^4; product: of all q, one value per chain.
  void (*stretch)(int count, double* root, double* cube, double* values, double* product);
  /// Converts the gradient by the stretched values to the gradient by `values`; by_root: by 4 q, minus the gradient
  /// of 4 log q.
  void (*stretch_gradient)(int count, const double* root, const double* cube, const double* values, double* gradient,
                           double* by_root);
  /// Computes values += factor * by, and values -= factor * by; factor: one value per chain.
  void (*add_times)(int size, const double* factor, const double* by, double* values);
  void (*subtract_times)(int size, const double* factor, const double* by, double* values);
  /// Computes gradient = fma(factor, gradient, values * prior); factor and prior: one value per chain.
  void (*with_prior)(int size, const double* factor, const double* prior, const double* values, double* gradient);
  /// Computes the sum of squares of each chain.
  void (*squares)(int size, const double* values, double* sums);
  /// Computes products += columns^t columns, chain by chain. columns: 4 * blocks of them, in strips of strip_rows rows,
  /// each strip column after column. products: for each block i of four columns and each j <= i, the 4 x 4 products of
  /// its columns with those of block j.
  void (*add_products)(int strips, int blocks, const double* columns, double* products);
  /// Replaces one matrix for all chains, stored row after row up to the diagonal, by the inverse of its Cholesky
  /// factor: the bits of factorize() and invert_lower(). Returns false if the matrix is not positive definite or not
  /// finite; it is then undefined. work: inverse_work(size) values.
  bool (*inverse_factor)(int size, double* matrix, double* work);
};

const Kernels& kernels(Isa isa);

/// Gives table_for access to the tables.
struct Tables {
  static const Kernels& reference();
  static const Kernels& baseline();
  static const Kernels& avx2();
  static const Kernels& avx512();
  static const Kernels& neon();
  static const Kernels& wasm();
  static const Kernels& relaxed();
};

}  // namespace decid::posterior
