// The passes of the Fourier transforms, written once on a vector type V (base/math/doubles.hpp) for `lanes` parallel
// signals: part p (0 real, 1 imaginary) of value n of lane l is at [(2 n + p) lanes + l]. One lane is the plain
// transform. Uses only multiplications and additions, in one order: the bits are the same for any V and any number of
// lanes. Method: Stockham's autosort, decimation in frequency (Van Loan, Computational Frameworks for the FFT, 1992,
// 1.7). A general odd radix adds and subtracts x[j] and x[p - j], which share their cosines and sines.
#pragma once

#include "base/math/doubles.hpp"
#include "sim/kernels/fft.hpp"

namespace decid::sim {
namespace {

/// A complex value in each lane of a register.
template <class V>
struct Value {
  typename V::D re, im;

  [[gnu::always_inline]] friend Value operator+(Value a, Value b) { return {a.re + b.re, a.im + b.im}; }
  [[gnu::always_inline]] friend Value operator-(Value a, Value b) { return {a.re - b.re, a.im - b.im}; }
  [[gnu::always_inline]] friend Value operator*(Value a, double factor) { return {a.re * factor, a.im * factor}; }
};
template <class V>
[[gnu::always_inline]] inline Value<V> times_minus_i(Value<V> a) {
  return {a.im, -a.re};
}
template <class V>
[[gnu::always_inline]] inline Value<V> conjugate(Value<V> a) {
  return {a.re, -a.im};
}
/// Returns a times the complex number at `factor`.
template <class V>
[[gnu::always_inline]] inline Value<V> product(Value<V> a, const double* factor) {
  return {a.re * factor[0] - a.im * factor[1], a.re * factor[1] + a.im * factor[0]};
}
template <class V>
[[gnu::always_inline]] inline Value<V> product_with_conjugate(Value<V> a, const double* factor) {
  return {a.re * factor[0] + a.im * factor[1], a.im * factor[0] - a.re * factor[1]};
}

/// Values of a signal of `lanes` lanes; v: the register's index.
template <class V, int lanes>
[[gnu::always_inline]] inline Value<V> load(const double* signal, std::ptrdiff_t n, int v) {
  const double* p = signal + 2 * n * lanes + v * V::width;
  return {V::load(p), V::load(p + lanes)};
}
template <class V, int lanes>
[[gnu::always_inline]] inline void store(double* signal, std::ptrdiff_t n, int v, Value<V> value) {
  double* p = signal + 2 * n * lanes + v * V::width;
  V::store(p, value.re);
  V::store(p + lanes, value.im);
}

// The butterflies: x[k] = sum_j x[j] exp(-2 pi i j k / radix), in place.
struct Butterfly2 {
  static constexpr int radix = 2;
  template <class V>
  [[gnu::always_inline]] static void apply(Value<V>* x) {
    const Value<V> sum = x[0] + x[1];
    x[1] = x[0] - x[1];
    x[0] = sum;
  }
};

struct Butterfly3 {
  static constexpr int radix = 3;
  template <class V>
  [[gnu::always_inline]] static void apply(Value<V>* x) {
    constexpr double sin_third = 0.86602540378443865;  // sine of a third of a turn; the cosine is -1/2
    const Value<V> sum = x[1] + x[2];
    const Value<V> side = times_minus_i((x[1] - x[2]) * sin_third);
    const Value<V> middle = x[0] - sum * 0.5;
    x[0] = x[0] + sum;
    x[1] = middle + side;
    x[2] = middle - side;
  }
};

struct Butterfly4 {
  static constexpr int radix = 4;
  template <class V>
  [[gnu::always_inline]] static void apply(Value<V>* x) {
    const Value<V> even_sum = x[0] + x[2], even_difference = x[0] - x[2];
    const Value<V> odd_sum = x[1] + x[3], odd_difference = times_minus_i(x[1] - x[3]);
    x[0] = even_sum + odd_sum;
    x[1] = even_difference + odd_difference;
    x[2] = even_sum - odd_sum;
    x[3] = even_difference - odd_difference;
  }
};

struct Butterfly5 {
  static constexpr int radix = 5;
  template <class V>
  [[gnu::always_inline]] static void apply(Value<V>* x) {
    constexpr double cos1 = 0.30901699437494742, cos2 = -0.80901699437494742;  // cosines of 1/5 and 2/5 of a turn
    constexpr double sin1 = 0.95105651629515357, sin2 = 0.58778525229247313;
    const Value<V> sum1 = x[1] + x[4], sum2 = x[2] + x[3];
    const Value<V> difference1 = x[1] - x[4], difference2 = x[2] - x[3];
    const Value<V> middle1 = x[0] + (sum1 * cos1 + sum2 * cos2);
    const Value<V> middle2 = x[0] + (sum1 * cos2 + sum2 * cos1);
    const Value<V> side1 = times_minus_i(difference1 * sin1 + difference2 * sin2);
    const Value<V> side2 = times_minus_i(difference1 * sin2 - difference2 * sin1);
    x[0] = x[0] + (sum1 + sum2);
    x[1] = middle1 + side1;
    x[2] = middle2 + side2;
    x[3] = middle2 - side2;
    x[4] = middle1 - side1;
  }
};

// Butterfly (group, k) reads in[k + stride (group + groups j)] and writes out[k + stride (radix group + r)].
template <class V, int lanes, class Butterfly>
void run_butterflies(const FftPass& pass, const double* in, double* out) {
  constexpr int radix = Butterfly::radix;
  const std::ptrdiff_t stride = pass.stride, apart = stride * pass.groups;
  for (int group = 0; group < pass.groups; ++group) {
    const double* factor = pass.twiddles + 2 * (radix - 1) * static_cast<std::ptrdiff_t>(group);
    for (std::ptrdiff_t k = 0; k < stride; ++k) {
      const std::ptrdiff_t source = k + stride * group, target = k + stride * radix * group;
      for (int v = 0; v < lanes / V::width; ++v) {
        Value<V> x[radix];
        for (int j = 0; j < radix; ++j) x[j] = load<V, lanes>(in, source + apart * j, v);
        Butterfly::apply(x);
        store<V, lanes>(out, target, v, x[0]);
        for (int r = 1; r < radix; ++r) {
          store<V, lanes>(out, target + stride * r, v, product(x[r], factor + 2 * (r - 1)));
        }
      }
    }
  }
}

/// Values in memory without alignment.
template <class V>
struct FoldMemory {
  double* memory;
  [[gnu::always_inline]] Value<V> get(int i) const { return load<V, V::width>(memory, i, 0); }
  [[gnu::always_inline]] void set(int i, Value<V> value) const { store<V, V::width>(memory, i, 0, value); }
};
/// Values in registers, if there are enough.
template <class V, int count>
struct FoldRegisters {
  Value<V> values[count];
  [[gnu::always_inline]] Value<V> get(int i) const { return values[i]; }
  [[gnu::always_inline]] void set(int i, Value<V> value) { values[i] = value; }
};

// Computes the same for any odd radix: `fixed` if that is not 0, else pass.radix. sums, differences: radix / 2 values
// each.
template <class V, int lanes, int fixed, class Fold>
[[gnu::always_inline]] inline void run_folded(const FftPass& pass, const double* in, double* out, Fold sums,
                                              Fold differences) {
  const int radix = fixed != 0 ? fixed : pass.radix, half = radix / 2;
  const std::ptrdiff_t stride = pass.stride, apart = stride * pass.groups;
  for (int group = 0; group < pass.groups; ++group) {
    const double* factor = pass.twiddles + 2 * (radix - 1) * static_cast<std::ptrdiff_t>(group);
    for (std::ptrdiff_t k = 0; k < stride; ++k) {
      const std::ptrdiff_t source = k + stride * group, target = k + stride * radix * group;
      for (int v = 0; v < lanes / V::width; ++v) {
        const Value<V> first = load<V, lanes>(in, source, v);
        Value<V> total = first;
#pragma GCC unroll 8
        for (int j = 1; j <= half; ++j) {
          const Value<V> a = load<V, lanes>(in, source + apart * j, v);
          const Value<V> b = load<V, lanes>(in, source + apart * (radix - j), v);
          sums.set(j - 1, a + b);
          differences.set(j - 1, a - b);
          total = total + sums.get(j - 1);
        }
        store<V, lanes>(out, target, v, total);
#pragma GCC unroll 8
        for (int r = 1; r <= half; ++r) {
          Value<V> middle = first, side{};
          int power = r;
#pragma GCC unroll 8
          for (int j = 1; j <= half; ++j) {
            const double* root = pass.roots + 2 * power;
            middle = middle + sums.get(j - 1) * root[0];
            side = side + differences.get(j - 1) * -root[1];
            power += r;
            if (power >= radix) power -= radix;
          }
          side = times_minus_i(side);
          store<V, lanes>(out, target + stride * r, v, product(middle + side, factor + 2 * (r - 1)));
          store<V, lanes>(out, target + stride * (radix - r), v, product(middle - side, factor + 2 * (radix - r - 1)));
        }
      }
    }
  }
}

template <class V, int lanes, int fixed>
void run_fixed(const FftPass& pass, const double* in, double* out) {
  run_folded<V, lanes, fixed>(pass, in, out, FoldRegisters<V, fixed / 2>{}, FoldRegisters<V, fixed / 2>{});
}

/// fold: 2 (radix - 1) lanes doubles, for radices above 5.
template <class V, int lanes>
void fft_pass(const FftPass& pass, const double* in, double* out, double* fold) {
  switch (pass.radix) {
    case 2:
      return run_butterflies<V, lanes, Butterfly2>(pass, in, out);
    case 3:
      return run_butterflies<V, lanes, Butterfly3>(pass, in, out);
    case 4:
      return run_butterflies<V, lanes, Butterfly4>(pass, in, out);
    case 5:
      return run_butterflies<V, lanes, Butterfly5>(pass, in, out);
    case 7:
      return run_fixed<V, lanes, 7>(pass, in, out);
    case 11:
      return run_fixed<V, lanes, 11>(pass, in, out);
    default:
      const FoldMemory<V> sums{fold}, differences{fold + pass.radix / 2 * 2 * V::width};
      return run_folded<V, lanes, 0>(pass, in, out, sums, differences);
  }
}

/// Converts the spectrum z of (even samples) + i (odd samples), `half` values, to that of the real signal, half + 1
/// values, in place. roots[k] = exp(-2 pi i k / (2 half)), k = 0 .. half / 2.
template <class V, int lanes>
void join_halves(int half, const double* roots, double* z) {
  for (int v = 0; v < lanes / V::width; ++v) {
    store<V, lanes>(z, half, v, load<V, lanes>(z, 0, v));
    // The spectra of the even and odd samples are the Hermitian and anti-Hermitian part of z's.
    for (int k = 0; k <= half / 2; ++k) {
      const Value<V> a = load<V, lanes>(z, k, v), b = conjugate(load<V, lanes>(z, half - k, v));
      const Value<V> even = (a + b) * 0.5;
      const Value<V> odd = product(times_minus_i(a - b) * 0.5, roots + 2 * k);
      store<V, lanes>(z, k, v, even + odd);
      store<V, lanes>(z, half - k, v, conjugate(even - odd));
    }
  }
}

/// Inverts this: from half + 1 values to `half`. Takes the imaginary parts of the first and the last as zero.
template <class V, int lanes>
void split_halves(int half, const double* roots, const double* spectrum, double* z) {
  for (int v = 0; v < lanes / V::width; ++v) {
    for (int k = 0; k <= half / 2; ++k) {
      Value<V> a = load<V, lanes>(spectrum, k, v), b = conjugate(load<V, lanes>(spectrum, half - k, v));
      if (k == 0) a.im = b.im = typename V::D{};
      const Value<V> even = (a + b) * 0.5;
      const Value<V> odd = product_with_conjugate((a - b) * 0.5, roots + 2 * k);
      // z = even + i odd, and its mirror image.
      store<V, lanes>(z, k, v, even - times_minus_i(odd));
      if (k > 0) store<V, lanes>(z, half - k, v, conjugate(even + times_minus_i(odd)));
    }
  }
}

/// Computes x[n] = forward(X)[-n mod length] * factor, in place: turns a forward transform into an inverse one.
template <class V, int lanes>
void reverse_and_scale(int length, double factor, double* z) {
  for (int v = 0; v < lanes / V::width; ++v) {
    store<V, lanes>(z, 0, v, load<V, lanes>(z, 0, v) * factor);
    for (int n = 1; 2 * n <= length; ++n) {
      const Value<V> a = load<V, lanes>(z, n, v), b = load<V, lanes>(z, length - n, v);
      store<V, lanes>(z, n, v, b * factor);
      store<V, lanes>(z, length - n, v, a * factor);
    }
  }
}

/// Computes out[i] = in[i] * factors[i], with the same factors for all lanes.
template <class V, int lanes>
void turn(int count, const double* in, const double* factors, double* out) {
  for (int i = 0; i < count; ++i) {
    for (int v = 0; v < lanes / V::width; ++v) {
      store<V, lanes>(out, i, v, product(load<V, lanes>(in, i, v), factors + 2 * i));
    }
  }
}

template <class V, int lanes>
constexpr FftKernels fft_kernels{fft_pass<V, lanes>, join_halves<V, lanes>, split_halves<V, lanes>,
                                 reverse_and_scale<V, lanes>, turn<V, lanes>};

}  // namespace
}  // namespace decid::sim
