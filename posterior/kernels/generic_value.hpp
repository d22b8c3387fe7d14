// Complex values on a vector type V (base/math/doubles.hpp): see kernels.hpp for their places.
#pragma once

#include "base/math/doubles.hpp"
#include "posterior/kernels/kernels.hpp"

namespace decid::posterior {
namespace {

/// A complex value in each lane of a register.
template <class V>
struct Value {
  using D = typename V::D;
  D re, im;

  [[gnu::always_inline]] static Value load(const double* signal, std::ptrdiff_t n, int v) {
    const double* p = signal + 2 * n * lanes + v * V::width;
    return {V::load(p), V::load(p + lanes)};
  }
  [[gnu::always_inline]] void store(double* signal, std::ptrdiff_t n, int v) const {
    double* p = signal + 2 * n * lanes + v * V::width;
    V::store(p, re);
    V::store(p + lanes, im);
  }
  /// Returns the same number in all lanes.
  [[gnu::always_inline]] static Value same(const double* number) { return {V::set(number[0]), V::set(number[1])}; }
  [[gnu::always_inline]] friend Value operator+(Value a, Value b) { return {a.re + b.re, a.im + b.im}; }
  [[gnu::always_inline]] friend Value operator-(Value a, Value b) { return {a.re - b.re, a.im - b.im}; }
  [[gnu::always_inline]] friend Value operator*(Value a, Value b) {
    return {V::fma(a.re, b.re, -(a.im * b.im)), V::fma(a.re, b.im, a.im * b.re)};
  }
  [[gnu::always_inline]] friend Value operator*(Value a, D factor) { return {a.re * factor, a.im * factor}; }
  /// Returns a + b * factor.
  [[gnu::always_inline]] static Value sum(Value a, Value b, D factor) {
    return {V::fma(b.re, factor, a.re), V::fma(b.im, factor, a.im)};
  }
  /// Returns a / b.
  [[gnu::always_inline]] static Value quotient(Value a, Value b) {
    const D scale = V::set(1.0) / V::fma(b.re, b.re, b.im * b.im);
    return a * Value{b.re * scale, -(b.im * scale)};
  }
  /// Returns Re(a b).
  [[gnu::always_inline]] static D real_product(Value a, Value b) { return V::fma(a.re, b.re, -(a.im * b.im)); }
};

}  // namespace
}  // namespace decid::posterior
