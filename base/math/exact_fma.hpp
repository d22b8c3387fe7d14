// The fused multiply-add of doubles for machines without one, two lanes at a time (WebAssembly's vectors): made of sums
// and products, rounded once. Scalars use the same method (bindings/web/runtime/fma.cpp). Method: the exact product as
// a sum of two doubles (Dekker, Numerische Mathematik 18, 1971), then rounding to odd: Boldo and Melquiond, "Emulation
// of FMA and correctly rounded sums", IEEE Trans. Computers 57 (2008), figure 5.
#pragma once

#include <wasm_simd128.h>

#include <cstdint>

namespace decid {

/// The C library's function, for values outside of this method's range (bindings/web/runtime/fma.cpp).
double slow_fma(double a, double b, double c);

namespace {

using ExactLanes = double __attribute__((vector_size(16)));
using ExactBits = std::int64_t __attribute__((vector_size(16)));

/// sum + error is exactly a + b.
struct ExactSum {
  ExactLanes sum, error;
};
[[gnu::always_inline]] inline ExactSum two_sum(ExactLanes a, ExactLanes b) {
  const ExactLanes sum = a + b, from_b = sum - a;
  return {sum, (a - (sum - from_b)) + (b - from_b)};
}

/// Returns a + b rounded to odd: an exact sum stays, another becomes the neighbour whose last bit is 1.
[[gnu::always_inline]] inline ExactLanes sum_to_odd(ExactLanes a, ExactLanes b) {
  const ExactSum found = two_sum(a, b);
  const ExactBits bits = (ExactBits)found.sum, one = ExactBits{} + 1;
  // With infinities the error is NaN, which is neither below nor above zero.
  const ExactBits inexact = (ExactBits)((found.error < ExactLanes{}) | (found.error > ExactLanes{}));
  const ExactBits even = ~bits & one & inexact;
  // The odd neighbour of an even sum lies in the error's direction: away from zero if the signs agree, else towards it.
  const ExactBits opposed = (bits ^ (ExactBits)found.error) < 0;
  return (ExactLanes)(bits + ((even ^ opposed) - opposed));
}

/// Returns the upper 26 bits of each lane; the rest of x also has 26 bits.
[[gnu::always_inline]] inline ExactLanes upper_half(ExactLanes x) {
  const ExactLanes scaled = x * 134217729.0;  // 2^27 + 1
  return scaled - (scaled - x);
}

[[gnu::always_inline]] inline ExactLanes exact_fma(ExactLanes a, ExactLanes b, ExactLanes c) {
  const ExactLanes product = a * b, zero{};
  // Excludes overflow below, and underflow of the product's error: infinities, NaN, and values near the limits.
  const v128_t within = wasm_v128_and(
      wasm_v128_and(wasm_f64x2_le(wasm_f64x2_abs((v128_t)a), wasm_f64x2_splat(0x1p500)),
                    wasm_f64x2_le(wasm_f64x2_abs((v128_t)b), wasm_f64x2_splat(0x1p500))),
      wasm_v128_and(wasm_f64x2_le(wasm_f64x2_abs((v128_t)c), wasm_f64x2_splat(0x1p1000)),
                    wasm_v128_or(wasm_f64x2_ge(wasm_f64x2_abs((v128_t)product), wasm_f64x2_splat(0x1p-900)),
                                 (v128_t)((a == zero) | (b == zero)))));
  if (!wasm_i64x2_all_true(within)) [[unlikely]]
    return ExactLanes{slow_fma(a[0], b[0], c[0]), slow_fma(a[1], b[1], c[1])};
  const ExactLanes a_high = upper_half(a), a_low = a - a_high, b_high = upper_half(b), b_low = b - b_high;
  const ExactLanes product_error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low);
  const ExactSum low = two_sum(c, product_error);
  const ExactSum high = two_sum(product, low.sum);
  const ExactLanes sum = high.sum + sum_to_odd(low.error, high.error);
  return product == zero ? product + c : sum;  // the sign of a zero result must be right
}

}  // namespace
}  // namespace decid
