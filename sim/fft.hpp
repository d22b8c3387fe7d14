// Fast Fourier transforms of any length, by mixed radix: 2, 3, 4, 5 by hand-written butterflies, any other prime factor
// p by its p x p definition. Forward: X[k] = sum_n x[n] exp(-2 pi i k n / N); inverse divides by N. Method: Stockham
// autosort (no bit reversal). Twiddles come from sincos_of_turn, so the bits are the same everywhere. Transforms one
// signal, or eight in parallel in vector registers with the same bits.
#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

#include "base/isa.hpp"
#include "sim/kernels/fft.hpp"

namespace decid::sim {

using Complex = std::complex<double>;

/// The longest possible transform.
inline constexpr int longest_fft = 1 << 26;
/// The largest prime factor of a length: its work grows with its square.
inline constexpr int max_fft_prime = 10'000;
/// The number of parallel signals in the *_lanes transforms. Real value n of lane l is at [n * fft_lanes + l]; the
/// parts of complex value n are at [2 n * fft_lanes + l] and [(2 n + 1) * fft_lanes + l].
inline constexpr int fft_lanes = 8;

/// Returns the largest prime factor, 1 for 1; number >= 1.
int max_prime_factor(int number);

/// Returns the shortest even length, at least `min_length`, without a prime factor above 5: its transforms are fast.
int smooth_length(int min_length);

/// Returns the radices of a transform's passes, in order. Throws Error if length < 1, length > longest_fft or a prime
/// factor exceeds max_fft_prime.
std::vector<int> fft_radices(int length);

/// A plan for one length. Immutable: any number of threads may share it, each with its own workspace.
class Fft {
 public:
  /// Throws Error as fft_radices does.
  explicit Fft(int length);
  int length() const noexcept { return length_; }
  /// Returns the number of values that `work` must hold.
  int work_length() const noexcept { return length_ + fold_length_; }

  /// Transforms. in and out: length() values each, may be the same memory. work: work_length() values, apart from both.
  /// Throws Error if a span is shorter.
  void forward(std::span<const Complex> in, std::span<Complex> out, std::span<Complex> work) const;
  void inverse(std::span<const Complex> in, std::span<Complex> out, std::span<Complex> work) const;

 private:
  friend class RealFft;
  struct Pass {
    int radix, groups, stride;    // as in FftPass
    std::size_t twiddles, roots;  // their offsets in twiddles_
  };
  /// Transforms raw memory, for any number of lanes; sizes as above, times 2 times the lanes.
  void run(const FftKernels& kernels, int lanes, const double* in, double* out, double* work) const;

  int length_;
  int fold_length_ = 0;  // space for one butterfly of the largest general radix
  std::vector<Pass> passes_;
  std::vector<Complex> twiddles_;
};

/// Real signals: length real values <-> bins() = length / 2 + 1 complex values (the other half is the mirror image).
/// For even lengths, even and odd samples are the real and imaginary part of a complex signal of half the length.
class RealFft {
 public:
  /// Throws Error as Fft does.
  explicit RealFft(int length);
  int length() const noexcept { return length_; }
  int bins() const noexcept { return length_ / 2 + 1; }
  /// Returns the number of values that `work` must hold.
  int work_length() const noexcept { return fft_.length() + fft_.work_length(); }

  /// Transforms. in: length() values, out: bins(), work: work_length(). Throws Error if a span is shorter.
  void forward(std::span<const double> in, std::span<Complex> out, std::span<Complex> work) const;
  /// Inverts. Takes the imaginary parts of bin 0 and, for even lengths, of bin length / 2 as zero.
  void inverse(std::span<const Complex> in, std::span<double> out, std::span<Complex> work) const;

  /// Transforms eight signals at once; the sizes are those above times fft_lanes (complex: times 2 fft_lanes) doubles.
  /// Fastest on memory aligned to 64 bytes.
  void forward_lanes(std::span<const double> in, std::span<double> out, std::span<double> work,
                     Isa isa = chosen_isa()) const;
  void inverse_lanes(std::span<const double> in, std::span<double> out, std::span<double> work,
                     Isa isa = chosen_isa()) const;

 private:
  /// Transforms raw memory, for any number of lanes.
  void run_forward(const FftKernels& kernels, int lanes, const double* in, double* out, double* work) const;
  void run_inverse(const FftKernels& kernels, int lanes, const double* in, double* out, double* work) const;

  int length_;
  Fft fft_;                     // of half the length if that is even, else of the length
  std::vector<Complex> roots_;  // exp(-2 pi i k / length), even lengths only
};

}  // namespace decid::sim
