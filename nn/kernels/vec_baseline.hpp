// A quarter of the 16 lanes with SSE2, which has no fused multiply-add: it is computed in double and rounded once.
// Method: rounding to odd before the last rounding, Boldo and Melquiond, "Emulation of FMA and correctly rounded sums:
// proved algorithms using rounding to odd", IEEE Trans. Computers 57 (2008).
#pragma once

#include <emmintrin.h>

namespace decid::nn {
namespace {

struct Baseline {
  using Float = __m128;
  static constexpr int width = 4;
  // The emulation uses most of the 16 registers; a tile gains only by sharing the conversions to double.
  static constexpr int tile_channels = 2, tile_columns = 2;
  static constexpr int gradient_channels = 2, gradient_columns = 2;
  static constexpr int block_bytes() { return 24 * 1024; }
  static constexpr int gradient_bytes(bool) { return 24 * 1024; }
  static constexpr int block_taps = 256;

  [[gnu::always_inline]] static Float load(const float* p) { return _mm_loadu_ps(p); }
  [[gnu::always_inline]] static void store(float* p, Float v) { _mm_storeu_ps(p, v); }
  /// v, in a register: keeps the compiler from loading it again at each use.
  [[gnu::always_inline]] static Float keep(Float v) {
    asm("" : "+x"(v));
    return v;
  }
  [[gnu::always_inline]] static Float broadcast(float v) { return _mm_set1_ps(v); }
  [[gnu::always_inline]] static Float add(Float a, Float b) { return _mm_add_ps(a, b); }
  [[gnu::always_inline]] static Float sub(Float a, Float b) { return _mm_sub_ps(a, b); }
  [[gnu::always_inline]] static Float mul(Float a, Float b) { return _mm_mul_ps(a, b); }
  [[gnu::always_inline]] static Float fma(Float a, Float b, Float c) {
    const __m128d low = sum_to_odd(_mm_mul_pd(_mm_cvtps_pd(a), _mm_cvtps_pd(b)), _mm_cvtps_pd(c));
    const __m128d high = sum_to_odd(_mm_mul_pd(upper(a), upper(b)), upper(c));
    return _mm_movelh_ps(_mm_cvtpd_ps(low), _mm_cvtpd_ps(high));
  }
  /// a > b ? x : y, false for NaN.
  [[gnu::always_inline]] static Float if_greater(Float a, Float b, Float x, Float y) {
    const __m128 mask = _mm_cmpgt_ps(a, b);
    return _mm_or_ps(_mm_and_ps(mask, x), _mm_andnot_ps(mask, y));
  }
  /// a > b ? x : y, true if a is NaN, false if only b is NaN.
  [[gnu::always_inline]] static Float if_greater_or_nan(Float a, Float b, Float x, Float y) {
    const __m128 mask = _mm_or_ps(_mm_cmpgt_ps(a, b), _mm_cmpunord_ps(a, a));
    return _mm_or_ps(_mm_and_ps(mask, x), _mm_andnot_ps(mask, y));
  }

 private:
  [[gnu::always_inline]] static __m128d upper(Float v) { return _mm_cvtps_pd(_mm_movehl_ps(v, v)); }

  /// product + c, rounded to odd: exact sums stay, others become the neighbour whose last bit is 1. Such a value is
  /// never halfway between two floats (53 bits >= 24 + 2), so the conversion to float rounds as if from the exact sum.
  /// The product of two floats is exact in double, and neither it nor the error of the sum can underflow there.
  [[gnu::always_inline]] static __m128d sum_to_odd(__m128d product, __m128d c) {
    const __m128d sum = _mm_add_pd(product, c);
    // TwoSum: sum + error is the exact result. With infinities error is NaN, which compares false below.
    const __m128d from_c = _mm_sub_pd(sum, product);
    const __m128d error = _mm_add_pd(_mm_sub_pd(product, _mm_sub_pd(sum, from_c)), _mm_sub_pd(c, from_c));
    const __m128d zero = _mm_setzero_pd();
    const __m128i inexact =
        _mm_castpd_si128(_mm_or_pd(_mm_cmplt_pd(error, zero), _mm_cmpgt_pd(error, zero)));  // all ones or zero
    const __m128i one = _mm_set_epi32(0, 1, 0, 1);
    const __m128i bits = _mm_castpd_si128(sum);
    // The odd neighbour of an even sum lies towards the error: away from zero if the signs agree (+1), else -1.
    const __m128i even = _mm_andnot_si128(bits, one);
    const __m128i opposed = _mm_srli_epi64(_mm_xor_si128(bits, _mm_castpd_si128(error)), 63);
    const __m128i step = _mm_sub_epi64(even, _mm_add_epi64(_mm_and_si128(opposed, even), _mm_and_si128(opposed, even)));
    return _mm_castsi128_pd(_mm_add_epi64(bits, _mm_and_si128(step, inexact)));
  }
};

}  // namespace
}  // namespace decid::nn
