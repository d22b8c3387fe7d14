// Fast Fourier transforms of any length: see fft.hpp.
// Method: Stockham's autosort, decimation in frequency (Van Loan, Computational Frameworks for the FFT, 1992, 1.7);
// a general odd radix folds x[j] and x[p - j], which share their cosines and sines.
#include "sim/fft.hpp"

#include <algorithm>
#include <string>

#include "base/error.hpp"
#include "base/math.hpp"

namespace decid::sim {
namespace {

// Products are written out: operator* of std::complex tests for NaN, and its order is the library's business.
Complex product(Complex a, Complex b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}
Complex product_with_conjugate(Complex a, Complex b) {
  return {a.real() * b.real() + a.imag() * b.imag(), a.imag() * b.real() - a.real() * b.imag()};
}
Complex scaled(Complex a, double factor) {
  return {a.real() * factor, a.imag() * factor};
}
Complex times_minus_i(Complex a) {
  return {a.imag(), -a.real()};
}

// exp(-2 pi i n / d)
Complex root_of_unity(long long n, long long d) {
  const auto [sin, cos] = sincos_of_turn(n, d);
  return {cos, -sin};
}

// The butterflies: x[k] = sum_j x[j] exp(-2 pi i j k / radix), in place.
struct Butterfly2 {
  static constexpr int radix = 2;
  static void apply(Complex* x) {
    const Complex sum = x[0] + x[1];
    x[1] = x[0] - x[1];
    x[0] = sum;
  }
};

struct Butterfly3 {
  static constexpr int radix = 3;
  static void apply(Complex* x) {
    constexpr double sin_third = 0.86602540378443865;  // of a third of a turn; the cosine is -1/2
    const Complex sum = x[1] + x[2];
    const Complex side = times_minus_i(scaled(x[1] - x[2], sin_third));
    const Complex middle = x[0] - scaled(sum, 0.5);
    x[0] = x[0] + sum;
    x[1] = middle + side;
    x[2] = middle - side;
  }
};

struct Butterfly4 {
  static constexpr int radix = 4;
  static void apply(Complex* x) {
    const Complex even_sum = x[0] + x[2], even_difference = x[0] - x[2];
    const Complex odd_sum = x[1] + x[3], odd_difference = times_minus_i(x[1] - x[3]);
    x[0] = even_sum + odd_sum;
    x[1] = even_difference + odd_difference;
    x[2] = even_sum - odd_sum;
    x[3] = even_difference - odd_difference;
  }
};

struct Butterfly5 {
  static constexpr int radix = 5;
  static void apply(Complex* x) {
    constexpr double cos1 = 0.30901699437494742, cos2 = -0.80901699437494742;  // of 1/5 and 2/5 of a turn
    constexpr double sin1 = 0.95105651629515357, sin2 = 0.58778525229247313;
    const Complex sum1 = x[1] + x[4], sum2 = x[2] + x[3];
    const Complex difference1 = x[1] - x[4], difference2 = x[2] - x[3];
    const Complex middle1 = x[0] + (scaled(sum1, cos1) + scaled(sum2, cos2));
    const Complex middle2 = x[0] + (scaled(sum1, cos2) + scaled(sum2, cos1));
    const Complex side1 = times_minus_i(scaled(difference1, sin1) + scaled(difference2, sin2));
    const Complex side2 = times_minus_i(scaled(difference1, sin2) - scaled(difference2, sin1));
    x[0] = x[0] + (sum1 + sum2);
    x[1] = middle1 + side1;
    x[2] = middle2 + side2;
    x[3] = middle2 - side2;
    x[4] = middle1 - side1;
  }
};

// Butterfly (group, k) reads in[k + stride (group + groups j)] and writes out[k + stride (radix group + r)].
template <class Butterfly>
void run_butterflies(int groups, int stride, const Complex* twiddles, const Complex* in, Complex* out) {
  constexpr int radix = Butterfly::radix;
  for (int group = 0; group < groups; ++group) {
    const Complex* source = in + stride * group;
    Complex* target = out + stride * radix * group;
    const Complex* factor = twiddles + (radix - 1) * group;
    for (int k = 0; k < stride; ++k) {
      Complex x[radix];
      for (int j = 0; j < radix; ++j) x[j] = source[k + stride * groups * j];
      Butterfly::apply(x);
      target[k] = x[0];
      for (int r = 1; r < radix; ++r) target[k + stride * r] = product(x[r], factor[r - 1]);
    }
  }
}

// The same for any odd radix. fold: radix - 1 values.
void run_general_butterflies(int radix, int groups, int stride, const Complex* twiddles, const Complex* roots,
                             const Complex* in, Complex* out, Complex* fold) {
  const int half = radix / 2;
  Complex* const sums = fold;
  Complex* const differences = fold + half;
  for (int group = 0; group < groups; ++group) {
    const Complex* factor = twiddles + (radix - 1) * group;
    for (int k = 0; k < stride; ++k) {
      const Complex* source = in + stride * group + k;
      Complex* target = out + stride * radix * group + k;
      const Complex first = source[0];
      Complex total = first;
      for (int j = 1; j <= half; ++j) {
        const Complex a = source[stride * groups * j], b = source[stride * groups * (radix - j)];
        sums[j - 1] = a + b;
        differences[j - 1] = a - b;
        total += sums[j - 1];
      }
      target[0] = total;
      for (int r = 1; r <= half; ++r) {
        Complex middle = first, side = 0.0;
        for (int j = 1, power = r; j <= half; ++j) {
          middle += scaled(sums[j - 1], roots[power].real());
          side += scaled(differences[j - 1], -roots[power].imag());
          power += r;
          if (power >= radix) power -= radix;
        }
        side = times_minus_i(side);
        target[stride * r] = product(middle + side, factor[r - 1]);
        target[stride * (radix - r)] = product(middle - side, factor[radix - r - 1]);
      }
    }
  }
}

// The radices of a length, in the order of the passes.
std::vector<int> radices_of(int length) {
  if (length < 1 || length > longest_fft) {
    throw Error("FFT", "cannot transform " + std::to_string(length) + " values",
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
  if (!radices.empty() && radices.back() > largest_fft_prime) {
    throw Error("FFT",
                "a length of " + std::to_string(length) + " has the prime factor " + std::to_string(radices.back()),
                "change the length a little, to one whose prime factors are below " +
                    std::to_string(largest_fft_prime) + "; best are 2, 3 and 5");
  }
  return radices;
}

void check_length(std::size_t given, int needed, const char* name) {
  if (given < static_cast<std::size_t>(needed)) {
    throw Error("FFT", std::string(name) + " holds " + std::to_string(given) + " values",
                "make room for " + std::to_string(needed));
  }
}

}  // namespace

Fft::Fft(int length) : length_(length) {
  int groups = length, stride = 1;
  for (const int radix : radices_of(length)) {
    const int points = groups;  // of the transforms that this pass divides
    groups /= radix;
    Stage stage{radix, groups, stride, twiddles_.size(), 0};
    for (int group = 0; group < groups; ++group) {
      for (int r = 1; r < radix; ++r) twiddles_.push_back(root_of_unity(static_cast<long long>(group) * r, points));
    }
    if (radix > 5) {
      stage.roots = twiddles_.size();
      for (int j = 0; j < radix; ++j) twiddles_.push_back(root_of_unity(j, radix));
      fold_length_ = std::max(fold_length_, radix - 1);
    }
    stages_.push_back(stage);
    stride *= radix;
  }
}

void Fft::run_stage(const Stage& stage, const Complex* in, Complex* out, Complex* fold) const {
  const Complex* twiddles = twiddles_.data() + stage.twiddles;
  switch (stage.radix) {
    case 2:
      return run_butterflies<Butterfly2>(stage.groups, stage.stride, twiddles, in, out);
    case 3:
      return run_butterflies<Butterfly3>(stage.groups, stage.stride, twiddles, in, out);
    case 4:
      return run_butterflies<Butterfly4>(stage.groups, stage.stride, twiddles, in, out);
    case 5:
      return run_butterflies<Butterfly5>(stage.groups, stage.stride, twiddles, in, out);
    default:
      return run_general_butterflies(stage.radix, stage.groups, stage.stride, twiddles, twiddles_.data() + stage.roots,
                                     in, out, fold);
  }
}

void Fft::forward(std::span<const Complex> in, std::span<Complex> out, std::span<Complex> work) const {
  check_length(in.size(), length_, "the input");
  check_length(out.size(), length_, "the output");
  check_length(work.size(), work_length(), "the workspace");
  // The passes alternate between work and out so that the last one ends in out. An odd number of them would start by
  // overwriting an input that is out itself: it starts from a copy in work.
  const Complex* source = in.data();
  if (stages_.size() % 2 == 1 && in.data() == out.data()) {
    std::copy_n(in.data(), length_, work.data());
    source = work.data();
  }
  Complex* target = stages_.size() % 2 == 1 ? out.data() : work.data();
  for (const Stage& stage : stages_) {
    run_stage(stage, source, target, work.data() + length_);
    source = target;
    target = target == out.data() ? work.data() : out.data();
  }
  if (stages_.empty()) out[0] = in[0];
}

void Fft::inverse(std::span<const Complex> in, std::span<Complex> out, std::span<Complex> work) const {
  // x[n] = forward(X)[-n mod N] / N
  forward(in, out, work);
  std::reverse(out.data() + 1, out.data() + length_);
  const double factor = 1.0 / length_;
  for (int n = 0; n < length_; ++n) out.data()[n] = scaled(out.data()[n], factor);
}

RealFft::RealFft(int length) : length_(length), fft_(length % 2 == 0 ? length / 2 : length) {
  if (length % 2 != 0) return;
  for (int k = 0; k <= length / 4; ++k) roots_.push_back(root_of_unity(k, length));
}

void RealFft::forward(std::span<const double> in, std::span<Complex> out, std::span<Complex> work) const {
  check_length(in.size(), length_, "the input");
  check_length(out.size(), bins(), "the output");
  check_length(work.size(), work_length(), "the workspace");
  const double* x = in.data();
  if (length_ % 2 == 1) {
    const std::span<Complex> values = work.first(static_cast<std::size_t>(length_));
    std::copy_n(x, length_, values.data());
    fft_.forward(values, values, work.subspan(values.size()));
    std::copy_n(values.data(), bins(), out.data());
    return;
  }
  const int half = length_ / 2;
  Complex* z = out.data();
  for (int n = 0; n < half; ++n) z[n] = {x[2 * n], x[2 * n + 1]};
  fft_.forward(out, out, work);
  // The spectra of the even and odd samples are the Hermitian and anti-Hermitian part of z's.
  z[half] = z[0];
  for (int k = 0; k <= half / 2; ++k) {
    const Complex a = z[k], b = std::conj(z[half - k]);
    const Complex even = scaled(a + b, 0.5);
    const Complex odd = product(scaled(times_minus_i(a - b), 0.5), roots_.data()[k]);
    z[k] = even + odd;
    z[half - k] = std::conj(even - odd);
  }
}

void RealFft::inverse(std::span<const Complex> in, std::span<double> out, std::span<Complex> work) const {
  check_length(in.size(), bins(), "the input");
  check_length(out.size(), length_, "the output");
  check_length(work.size(), work_length(), "the workspace");
  const std::span<Complex> values = work.first(static_cast<std::size_t>(fft_.length()));
  const std::span<Complex> rest = work.subspan(values.size());
  const Complex* spectrum = in.data();
  Complex* z = values.data();
  if (length_ % 2 == 1) {
    z[0] = spectrum[0].real();
    for (int k = 1; k < bins(); ++k) {
      z[k] = spectrum[k];
      z[length_ - k] = std::conj(spectrum[k]);
    }
    fft_.inverse(values, values, rest);
    for (int n = 0; n < length_; ++n) out.data()[n] = z[n].real();
    return;
  }
  const int half = length_ / 2;
  for (int k = 0; k <= half / 2; ++k) {
    const Complex a = k == 0 ? spectrum[0].real() : spectrum[k];
    const Complex b = k == 0 ? spectrum[half].real() : std::conj(spectrum[half - k]);
    const Complex even = scaled(a + b, 0.5);
    const Complex odd = product_with_conjugate(scaled(a - b, 0.5), roots_.data()[k]);
    // z = even + i odd, and its mirror image.
    z[k] = even - times_minus_i(odd);
    if (k > 0) z[half - k] = std::conj(even + times_minus_i(odd));
  }
  fft_.inverse(values, values, rest);
  for (int n = 0; n < half; ++n) {
    out.data()[2 * n] = z[n].real();
    out.data()[2 * n + 1] = z[n].imag();
  }
}

}  // namespace decid::sim
