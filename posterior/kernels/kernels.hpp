// The kernels of the posterior density, one table an instruction set. All compute the same bits. They work on `lanes`
// chains side by side: value n of chain l is at [n * lanes + l], the parts of complex value n at [2 n * lanes + l] and
// [(2 n + 1) * lanes + l].
#pragma once

#include <cstddef>

#include "base/isa.hpp"
#include "sim/fft.hpp"

namespace decid::posterior {

inline constexpr int lanes = sim::fft_lanes;
inline constexpr int strip_rows = 32;  ///< of add_products

constexpr std::size_t inverse_work(std::size_t size) {
  return size * ((size + 31) / 32 * 32);
}

/// The dead band on bins of time, in each of which the platform's velocity and the noise's run linearly.
struct DeadBandBins {
  int count;
  const double* rate_low;   ///< the platform's velocity where a bin begins, rad/s
  const double* rate_high;  ///< and where it ends
  const double* weight;     ///< what a bin counts in the transform
};
/// Of `lanes` chains. The noise has count + 1 values, at the bins' edges.
struct DeadBandValues {
  const double* noise;    ///< velocity for a gain of 1, rad/s
  const double* gain;     ///< a value a chain
  const double* theta;    ///< a value a chain, rad/s
  double* passed;         ///< the mean of what passes the dead band, times the weight
  double* by_noise_low;   ///< derivatives of `passed` by gain * noise at a bin's begin
  double* by_noise_high;  ///< at its end
  double* by_theta;
};
/// From derivatives by `passed` to those by the noise at the edges, by the gain and by theta.
struct DeadBandGradient {
  const double* by_passed;
  double* by_noise;  ///< count + 1 values a chain, of gain * noise
  double* by_gain;   ///< a value a chain
  double* by_theta;  ///< a value a chain
};

/// What does not depend on the parameters, at each frequency s of the contour: complex numbers, the same for all
/// chains.
struct LoopConstants {
  int count;
  const double* s;         ///< 1/s
  const double* sum;       ///< of a velocity's steps to an angle: T / (z - 1), s
  const double* rate;      ///< of an angle to its velocity: (z - 1) / (T z), 1/s
  const double* body;      ///< J (z - 1)^2 / (T^2 z) - m g h, N m/rad
  const double* hold;      ///< of a bin's value to its steps
  const double* observe;   ///< of sway to the mean of a block of samples
  const double* platform;  ///< transform of the platform's velocity
  const double* torque;    ///< transform of the torque of gravity beyond m g h times the angle
  double back;             ///< LoopGradient::by_observed is conjugated, and multiplied by this
};
/// A chain's parameters, each `lanes` values.
struct LoopParameters {
  const double *kp, *kd, *kp_pass, *kd_pass;
  const double* gain;
  const double *delay_first, *delay_turn;  ///< complex, exp(-s delay) at the first frequency, and from one to the next
  const double *start_first, *start_turn;  ///< the same of exp(s start)
};
/// What the way back needs from the way there; complex, count values a chain each.
struct LoopState {
  double* passed;    ///< in: transform of the bins; out: times hold
  double* delayed;   ///< exp(-s delay)
  double* inverse;   ///< 1 / D
  double* sway;      ///< transform of the sway
  double* observe;   ///< observe * exp(s start)
  double* observed;  ///< transform of what is observed
};
struct LoopGradient {
  const double* by_observed;  ///< transform of the derivatives by the observed values; complex
  double* by_passed;          ///< out: the transform of the derivatives by the bins, complex
  double* sums;               ///< 7 values a chain: by kp, kd, kp_pass, kd_pass, delay, start, gain
};

/// The cosine transform's coefficients, the same for all chains: see spectrum.hpp.
struct NoiseRows {
  int count;
  const double* turn;    ///< complex: coefficient k is Re(turn[k] spectrum[k])
  const double* back;    ///< complex: from a derivative by coefficient k to the transform that is turned back
  const double* line;    ///< of the straight line
  const double* square;  ///< (2 pi f)^2, 1/s^2
  const double* white;   ///< the white noise's power, with the drift that is part of it
  double first;          ///< the offset's variance, which coefficient 0 has besides
};
/// A value a chain each: see NoiseLevels.
struct NoiseVariances {
  const double *white, *slow, *memory;
};
/// count values a chain each.
struct NoiseState {
  double *coefficient, *precision, *share;  ///< share: 1 / (1 + square * memory)
};

struct Kernels {
  void (*dead_band)(const DeadBandBins&, const DeadBandValues&);
  void (*dead_band_gradient)(const DeadBandBins&, const DeadBandValues&, const DeadBandGradient&);
  /// Between values the cubic through four of them, at the ends a line: fine has 2 count - 1 values a chain.
  void (*refine)(int count, const double* coarse, double* fine);
  /// From derivatives by fine values to those by the coarse ones.
  void (*refine_gradient)(int count, const double* by_fine, double* by_coarse);
  /// Of halves of bins, two a bin: their mean, and what they differ as mass that is moved, with which a bin is more
  /// than a mean that is held. bins[i] = (h[2 i] + h[2 i + 1]) / 2 + d[i - 1] - d[i + 1], d[i] = (h[2 i + 1] - h[2 i])
  /// / 12.
  void (*join)(int count, const double* halves, double* bins);
  /// From derivatives by the bins to those by their halves.
  void (*join_gradient)(int count, const double* by_bins, double* by_halves);
  /// How `passed` changes with noise that is the same for all chains: count + 1 values at the bins' edges.
  void (*dead_band_change)(int count, const DeadBandValues&, const double* noise, double* passed);
  void (*loop)(const LoopConstants&, const LoopParameters&, const LoopState&);
  void (*loop_gradient)(const LoopConstants&, const LoopParameters&, const LoopState&, const LoopGradient&);
  /// out = a b, complex.
  void (*product)(int count, const double* a, const double* b, double* out);
  /// out[i] = in[i] * factors[i], complex; the factors are the same for all chains.
  void (*turn)(int count, const double* in, const double* factors, double* out);
  /// out[i] += in[i] * conj(factors[i]), complex; the factors are the same for all chains.
  void (*turn_back)(int count, const double* in, const double* factors, double* out);
  /// out = in * factors, real; the factors are the same for all chains.
  void (*scale)(int count, const double* in, const double* factors, double* out);
  /// Blocks in the order of Makhoul's cosine transform: the even ones, then the odd ones backwards.
  /// out[place of m] = recorded[m] - modelled[m] * factors[m]; recorded: the same for all chains.
  void (*unfold)(int count, const double* recorded, const double* modelled, const double* factors, double* out);
  /// out[m] = unfolded[place of m] * factors[m].
  void (*fold)(int count, const double* unfolded, const double* factors, double* out);
  /// From the transform of unfolded blocks to NoiseState. sums: 4 values a chain, over the coefficients R with
  /// precision u, those of u R^2, u R line, u line^2 and -log u.
  void (*noise_rows)(const NoiseRows&, const NoiseVariances&, const double* spectrum, const NoiseState&, double* sums);
  /// Half the sum of u e^2, e = R - line * rise, and of -log u: its derivatives by R to the transform that is turned
  /// back; sums: 3 values a chain, by white, slow and the logarithm of memory. uncertainty: of the rise, its variance.
  void (*noise_rows_gradient)(const NoiseRows&, const NoiseVariances&, const double* rise, const double* uncertainty,
                              const NoiseState&, double* spectrum, double* sums);
  /// out = root R - line_row * shrinkage * (their product with line_row), of coefficients R; shrinkage: a value a
  /// chain.
  void (*whiten)(const NoiseRows&, const double* spectrum, const double* root, const double* line_row,
                 const double* shrinkage, double* out);
  /// out = T in for a lower triangular T, rows one after the other: row i has i + 1 values.
  void (*lower_times)(int size, const double* lower, const double* in, double* out);
  /// out = T^t in.
  void (*upper_times)(int size, const double* lower, const double* in, double* out);
  /// out += matrix in, rows one after the other.
  void (*add_matrix_times)(int rows, int columns, const double* matrix, const double* in, double* out);
  /// Of each chain: a symmetric matrix, its rows to the diagonal one after the other, becomes its Cholesky factor; a
  /// chain whose matrix is not positive definite gets NaN.
  void (*factorize)(int size, double* matrix);
  /// Of each chain: x becomes the solution of lower^t x = x.
  void (*solve_transposed)(int size, const double* lower, double* x);
  /// out += matrix in, of each chain: a symmetric matrix, its rows to the diagonal one after the other.
  void (*symmetric_times)(int size, const double* matrix, const double* in, double* out);
  /// root: 4 q becomes q; cube: q^3; values *= q^4; product: of all q, a value a chain.
  void (*stretch)(int count, double* root, double* cube, double* values, double* product);
  /// The gradient by the stretched values becomes that by `values`; by_root: by 4 q, less that of 4 log q.
  void (*stretch_gradient)(int count, const double* root, const double* cube, const double* values, double* gradient,
                           double* by_root);
  /// values += factor * by, and values -= factor * by; the factors: a value a chain.
  void (*add_times)(int size, const double* factor, const double* by, double* values);
  void (*subtract_times)(int size, const double* factor, const double* by, double* values);
  /// gradient = fma(factor, gradient, values * prior); factor and prior: a value a chain.
  void (*with_prior)(int size, const double* factor, const double* prior, const double* values, double* gradient);
  /// The sum of squares of each chain.
  void (*squares)(int size, const double* values, double* sums);
  /// products += columns^t columns, chain by chain. columns: 4 blocks of them; strips of strip_rows rows, one after the
  /// other, each column after column; products: for each block i of four columns and each j <= i the 4 x 4 products of
  /// its columns with those of j.
  void (*add_products)(int strips, int blocks, const double* columns, double* products);
  /// One matrix for all chains, its rows to the diagonal one after the other, becomes the inverse of its Cholesky
  /// factor: the bits of factorize() and invert_lower(). False if it is not positive definite or not finite; it is void
  /// then. work: inverse_work(size) values.
  bool (*inverse_factor)(int size, double* matrix, double* work);
};

const Kernels& kernels(Isa isa);

/// For table_of.
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
