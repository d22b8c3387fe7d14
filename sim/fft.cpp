// Fast Fourier transforms of any length: see fft.hpp. The passes are kernels (kernels/generic_fft.hpp).
#include "sim/fft.hpp"

#include <algorithm>
#include <string>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "sim/kernels/generic_fft.hpp"
#include "sim/kernels/kernels.hpp"

namespace decid::sim {
namespace {

// exp(-2 pi i n / d)
Complex root_of_unity(long long n, long long d) {
  const auto [sin, cos] = sincos_of_turn(n, d);
  return {cos, -sin};
}

void check_length(std::size_t given, int needed, const char* name, int lanes = 1) {
  if (given < static_cast<std::size_t>(needed) * static_cast<std::size_t>(lanes)) {
    throw Error(Code::size_mismatch, "FFT", std::string(name) + " has space for " + std::to_string(given) + " values",
                "give space for " + std::to_string(static_cast<long long>(needed) * lanes));
  }
}

/// std::complex<double> is two doubles (C++20, 26.4/4).
const double* parts(const Complex* values) {
  return reinterpret_cast<const double*>(values);
}
double* parts(Complex* values) {
  return reinterpret_cast<double*>(values);
}

constexpr const FftKernels& plain = fft_kernels<One, 1>;

}  // namespace

int max_prime_factor(int number) {
  int factor = 1;
  for (int p = 2; p <= number / p; ++p) {
    for (; number % p == 0; number /= p) factor = p;
  }
  return std::max(factor, number);
}

int smooth_length(int min_length) {
  for (int length = min_length + min_length % 2;; length += 2) {
    if (max_prime_factor(length) <= 5) return length;
  }
}

std::vector<int> fft_radices(int length) {
  if (length < 1 || length > longest_fft) {
    throw Error(Code::setting_out_of_range, "FFT", "cannot transform " + std::to_string(length) + " values",
                "give a length from 1 to " + std::to_string(longest_fft));
  }
  std::vector<int> radices;
  int rest = length;
  for (const int radix : {4, 2, 3, 5}) {
    for (; rest % radix == 0; rest /= radix) radices.push_back(radix);
  }
  for (int radix = 7; rest > 1; radix += 2) {
    if (radix * radix > rest) radix = rest;
    for (; rest % radix == 0; rest /= radix) radices.push_back(radix);
  }
  if (max_prime_factor(length) > max_fft_prime) {
    throw Error(
        Code::setting_out_of_range, "FFT",
        "a length of " + std::to_string(length) + " has the prime factor " + std::to_string(max_prime_factor(length)),
        "change the length slightly, to one with prime factors below " + std::to_string(max_fft_prime) +
            "; best are 2, 3 and 5");
  }
  return radices;
}

Fft::Fft(int length) : length_(length) {
  int groups = length, stride = 1;
  for (const int radix : fft_radices(length)) {
    const int points = groups;  // of the transforms that this pass divides
    groups /= radix;
    Pass pass{radix, groups, stride, twiddles_.size(), 0};
    for (int group = 0; group < groups; ++group) {
      for (int r = 1; r < radix; ++r) twiddles_.push_back(root_of_unity(static_cast<long long>(group) * r, points));
    }
    if (radix > 5) {
      pass.roots = twiddles_.size();
      for (int j = 0; j < radix; ++j) twiddles_.push_back(root_of_unity(j, radix));
      fold_length_ = std::max(fold_length_, radix - 1);
    }
    passes_.push_back(pass);
    stride *= radix;
  }
}

void Fft::run(const FftKernels& kernels, int lanes, const double* in, double* out, double* work) const {
  const std::ptrdiff_t values = std::ptrdiff_t{2} * length_ * lanes;
  if (passes_.empty()) {
    std::copy_n(in, values, out);
    return;
  }
  // The passes alternate between work and out so that the last one ends in out. An odd number of passes would start by
  // overwriting an input that is out itself, so it starts from a copy in work.
  const double* source = in;
  if (passes_.size() % 2 == 1 && in == out) {
    std::copy_n(in, values, work);
    source = work;
  }
  double* target = passes_.size() % 2 == 1 ? out : work;
  for (const Pass& planned : passes_) {
    const FftPass pass{planned.radix, planned.groups, planned.stride, parts(twiddles_.data() + planned.twiddles),
                       parts(twiddles_.data() + planned.roots)};
    kernels.pass(pass, source, target, work + values);
    source = target;
    target = target == out ? work : out;
  }
}

void Fft::forward(std::span<const Complex> in, std::span<Complex> out, std::span<Complex> work) const {
  check_length(in.size(), length_, "the input");
  check_length(out.size(), length_, "the output");
  check_length(work.size(), work_length(), "the workspace");
  run(plain, 1, parts(in.data()), parts(out.data()), parts(work.data()));
}

void Fft::inverse(std::span<const Complex> in, std::span<Complex> out, std::span<Complex> work) const {
  forward(in, out, work);
  plain.reverse_and_scale(length_, 1.0 / length_, parts(out.data()));
}

RealFft::RealFft(int length) : length_(length), fft_(length % 2 == 0 ? length / 2 : length) {
  if (length % 2 != 0) return;
  for (int k = 0; k <= length / 4; ++k) roots_.push_back(root_of_unity(k, length));
}

void RealFft::run_forward(const FftKernels& kernels, int lanes, const double* in, double* out, double* work) const {
  if (length_ % 2 == 1) {
    for (int n = 0; n < length_; ++n) {
      std::copy_n(in + n * lanes, lanes, work + 2 * n * lanes);
      std::fill_n(work + (2 * n + 1) * lanes, lanes, 0.0);
    }
    fft_.run(kernels, lanes, work, work, work + 2 * length_ * lanes);
    std::copy_n(work, 2 * bins() * lanes, out);
    return;
  }
  // In memory, even samples are the real parts and odd ones the imaginary parts.
  fft_.run(kernels, lanes, in, out, work);
  kernels.join_halves(length_ / 2, parts(roots_.data()), out);
}

void RealFft::run_inverse(const FftKernels& kernels, int lanes, const double* in, double* out, double* work) const {
  double* rest = work + 2 * fft_.length() * lanes;
  if (length_ % 2 == 1) {
    for (int k = 0; k < bins(); ++k) {
      for (int lane = 0; lane < lanes; ++lane) {
        const double real = in[2 * k * lanes + lane], imaginary = k == 0 ? 0.0 : in[(2 * k + 1) * lanes + lane];
        work[2 * k * lanes + lane] = real;
        work[(2 * k + 1) * lanes + lane] = imaginary;
        if (k == 0) continue;
        work[2 * (length_ - k) * lanes + lane] = real;
        work[(2 * (length_ - k) + 1) * lanes + lane] = -imaginary;
      }
    }
    fft_.run(kernels, lanes, work, work, rest);
    kernels.reverse_and_scale(length_, 1.0 / length_, work);
    for (int n = 0; n < length_; ++n) std::copy_n(work + 2 * n * lanes, lanes, out + n * lanes);
    return;
  }
  const int half = length_ / 2;
  kernels.split_halves(half, parts(roots_.data()), in, work);
  fft_.run(kernels, lanes, work, out, rest);
  kernels.reverse_and_scale(half, 1.0 / half, out);
}

void RealFft::forward(std::span<const double> in, std::span<Complex> out, std::span<Complex> work) const {
  check_length(in.size(), length_, "the input");
  check_length(out.size(), bins(), "the output");
  check_length(work.size(), work_length(), "the workspace");
  run_forward(plain, 1, in.data(), parts(out.data()), parts(work.data()));
}

void RealFft::inverse(std::span<const Complex> in, std::span<double> out, std::span<Complex> work) const {
  check_length(in.size(), bins(), "the input");
  check_length(out.size(), length_, "the output");
  check_length(work.size(), work_length(), "the workspace");
  run_inverse(plain, 1, parts(in.data()), out.data(), parts(work.data()));
}

void RealFft::forward_lanes(std::span<const double> in, std::span<double> out, std::span<double> work, Isa isa) const {
  check_length(in.size(), length_, "the input", fft_lanes);
  check_length(out.size(), bins(), "the output", 2 * fft_lanes);
  check_length(work.size(), work_length(), "the workspace", 2 * fft_lanes);
  run_forward(simulator_kernels(isa).fft, fft_lanes, in.data(), out.data(), work.data());
}

void RealFft::inverse_lanes(std::span<const double> in, std::span<double> out, std::span<double> work, Isa isa) const {
  check_length(in.size(), bins(), "the input", 2 * fft_lanes);
  check_length(out.size(), length_, "the output", fft_lanes);
  check_length(work.size(), work_length(), "the workspace", 2 * fft_lanes);
  run_inverse(simulator_kernels(isa).fft, fft_lanes, in.data(), out.data(), work.data());
}

}  // namespace decid::sim
