// Fast Fourier transforms of any length, by mixed radix: 2, 3, 4, 5 by hand-written butterflies, any other prime
// factor p by its p x p definition. Forward: X[k] = sum_n x[n] exp(-2 pi i k n / N); inverse divides by N.
// Method: Stockham autosort (no bit reversal); twiddles from sincos_of_turn, so the bits are the same everywhere.
#pragma once

#include <complex>
#include <span>
#include <vector>

namespace decid::sim {

using Complex = std::complex<double>;

/// A plan for one length; immutable, so one plan serves any number of threads, each with a workspace of its own.
class Fft {
 public:
  /// Throws Error if length < 1.
  explicit Fft(int length);
  int length() const noexcept { return length_; }
  /// Values that `work` must hold.
  int work_length() const noexcept { return length_; }

  /// in and out: length() values each, may be the same memory. work: work_length() values, apart from both.
  void forward(std::span<const Complex> in, std::span<Complex> out, std::span<Complex> work) const;
  void inverse(std::span<const Complex> in, std::span<Complex> out, std::span<Complex> work) const;
};

/// Real signals: length real values <-> bins() = length / 2 + 1 complex values (the other half is the mirror image).
class RealFft {
 public:
  explicit RealFft(int length);
  int length() const noexcept { return length_; }
  int bins() const noexcept { return length_ / 2 + 1; }
  int work_length() const noexcept;

  void forward(std::span<const double> in, std::span<Complex> out, std::span<Complex> work) const;
  /// The imaginary parts of bin 0 and, for even lengths, of bin length / 2 are taken as zero.
  void inverse(std::span<const Complex> in, std::span<double> out, std::span<Complex> work) const;
};

}  // namespace decid::sim
