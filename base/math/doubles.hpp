// Vectors of doubles for code that is compiled once per instruction set: `One` is a plain double, `Native` the widest
// register of the translation unit. Arithmetic and comparisons use the compilers' vector extensions; this header adds
// the missing operations. Every operation follows IEEE 754 in each lane, so all widths agree in every bit.
// Everything is in an unnamed namespace. Functions are then internal to their translation unit, and the linker cannot
// give a lesser machine a copy compiled for AVX-512.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#if defined(__x86_64__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#elif defined(__wasm__)
#include <wasm_simd128.h>

#include "base/math/exact_fma.hpp"
#endif

namespace decid {
namespace {

/// A single lane.
struct One {
  using D = double;
  using I = std::int64_t;
  static constexpr int width = 1;
  [[gnu::always_inline]] static D set(double a) { return a; }
  [[gnu::always_inline]] static D load(const double* p) { return *p; }
  [[gnu::always_inline]] static void store(double* p, D v) { *p = v; }
  [[gnu::always_inline]] static D fma(D a, D b, D c) { return __builtin_fma(a, b, c); }
  /// Returns a < b ? a : b, so b if either is NaN.
  [[gnu::always_inline]] static D min(D a, D b) { return a < b ? a : b; }
  [[gnu::always_inline]] static D max(D a, D b) { return a > b ? a : b; }
  [[gnu::always_inline]] static D abs(D a) { return __builtin_fabs(a); }
  [[gnu::always_inline]] static D sqrt(D a) { return __builtin_sqrt(a); }
  /// Returns true if every lane is <= limit; false if one is NaN.
  [[gnu::always_inline]] static bool all_within(D a, double limit) { return a <= limit; }
  [[gnu::always_inline]] static I bits(D a) { return std::bit_cast<I>(a); }
  [[gnu::always_inline]] static D from_bits(I a) { return std::bit_cast<D>(a); }
  [[gnu::always_inline]] static I set_bits(std::int64_t a) { return a; }
  /// Returns the product of the lower 32 bits, unsigned.
  [[gnu::always_inline]] static I multiply_low(I a, I b) {
    const auto low = [](I x) { return static_cast<std::uint64_t>(x) & 0xffffffffU; };
    return static_cast<I>(low(a) * low(b));
  }
  /// Loads as many floats as there are lanes.
  [[gnu::always_inline]] static D load_floats(const float* p) { return static_cast<double>(*p); }
  /// Stores the lanes as float, rounded to nearest.
  [[gnu::always_inline]] static void store_floats(float* p, D v) { *p = static_cast<float>(v); }
  /// Stores a0 b0 a1 b1 ...
  [[gnu::always_inline]] static void store_pairs(double* p, D a, D b) {
    p[0] = a;
    p[1] = b;
  }
  /// Returns lanes p[i][offset].
  [[gnu::always_inline]] static D gather(const double* const* p, std::ptrdiff_t offset) { return p[0][offset]; }
  [[gnu::always_inline]] static void scatter(double* const* p, std::ptrdiff_t offset, D v) { p[0][offset] = v; }
};

#if defined(__AVX512F__)

struct Native {
  using D = __m512d;
  using I = std::int64_t __attribute__((vector_size(64)));
  static constexpr int width = 8;
  [[gnu::always_inline]] static D set(double a) { return _mm512_set1_pd(a); }
  [[gnu::always_inline]] static D load(const double* p) { return _mm512_loadu_pd(p); }
  [[gnu::always_inline]] static void store(double* p, D v) { _mm512_storeu_pd(p, v); }
  [[gnu::always_inline]] static D fma(D a, D b, D c) { return _mm512_fmadd_pd(a, b, c); }
  [[gnu::always_inline]] static D min(D a, D b) { return _mm512_min_pd(a, b); }
  [[gnu::always_inline]] static D max(D a, D b) { return _mm512_max_pd(a, b); }
  [[gnu::always_inline]] static D abs(D a) { return _mm512_abs_pd(a); }
  [[gnu::always_inline]] static D sqrt(D a) { return _mm512_sqrt_pd(a); }
  [[gnu::always_inline]] static bool all_within(D a, double limit) {
    return _mm512_cmp_pd_mask(a, _mm512_set1_pd(limit), _CMP_NLE_UQ) == 0;
  }
  [[gnu::always_inline]] static I bits(D a) { return (I)a; }
  [[gnu::always_inline]] static D from_bits(I a) { return (D)a; }
  [[gnu::always_inline]] static I set_bits(std::int64_t a) { return I{} + a; }
  [[gnu::always_inline]] static I multiply_low(I a, I b) { return (I)_mm512_mul_epu32((__m512i)a, (__m512i)b); }
  [[gnu::always_inline]] static D load_floats(const float* p) { return _mm512_cvtps_pd(_mm256_loadu_ps(p)); }
  [[gnu::always_inline]] static void store_floats(float* p, D v) { _mm256_storeu_ps(p, _mm512_cvtpd_ps(v)); }
  [[gnu::always_inline]] static void store_pairs(double* p, D a, D b) {
    store(p, _mm512_permutex2var_pd(a, _mm512_set_epi64(11, 3, 10, 2, 9, 1, 8, 0), b));
    store(p + width, _mm512_permutex2var_pd(a, _mm512_set_epi64(15, 7, 14, 6, 13, 5, 12, 4), b));
  }
  [[gnu::always_inline]] static D gather(const double* const* p, std::ptrdiff_t offset) {
    const __m256d low = _mm256_insertf128_pd(_mm256_castpd128_pd256(pair(p[0] + offset, p[1] + offset)),
                                             pair(p[2] + offset, p[3] + offset), 1);
    const __m256d high = _mm256_insertf128_pd(_mm256_castpd128_pd256(pair(p[4] + offset, p[5] + offset)),
                                              pair(p[6] + offset, p[7] + offset), 1);
    return _mm512_insertf64x4(_mm512_castpd256_pd512(low), high, 1);
  }
  [[gnu::always_inline]] static void scatter(double* const* p, std::ptrdiff_t offset, D v) {
    double values[width];
    store(values, v);
    for (int lane = 0; lane < width; ++lane) p[lane][offset] = values[lane];
  }

 private:
  [[gnu::always_inline]] static __m128d pair(const double* a, const double* b) {
    return _mm_loadh_pd(_mm_load_sd(a), b);
  }
};

#elif defined(__AVX2__) && defined(__FMA__)

struct Native {
  using D = __m256d;
  using I = std::int64_t __attribute__((vector_size(32)));
  static constexpr int width = 4;
  [[gnu::always_inline]] static D set(double a) { return _mm256_set1_pd(a); }
  [[gnu::always_inline]] static D load(const double* p) { return _mm256_loadu_pd(p); }
  [[gnu::always_inline]] static void store(double* p, D v) { _mm256_storeu_pd(p, v); }
  [[gnu::always_inline]] static D fma(D a, D b, D c) { return _mm256_fmadd_pd(a, b, c); }
  [[gnu::always_inline]] static D min(D a, D b) { return _mm256_min_pd(a, b); }
  [[gnu::always_inline]] static D max(D a, D b) { return _mm256_max_pd(a, b); }
  [[gnu::always_inline]] static D abs(D a) { return _mm256_andnot_pd(_mm256_set1_pd(-0.0), a); }
  [[gnu::always_inline]] static D sqrt(D a) { return _mm256_sqrt_pd(a); }
  [[gnu::always_inline]] static bool all_within(D a, double limit) {
    return _mm256_movemask_pd(_mm256_cmp_pd(a, _mm256_set1_pd(limit), _CMP_NLE_UQ)) == 0;
  }
  [[gnu::always_inline]] static I bits(D a) { return (I)a; }
  [[gnu::always_inline]] static D from_bits(I a) { return (D)a; }
  [[gnu::always_inline]] static I set_bits(std::int64_t a) { return I{} + a; }
  [[gnu::always_inline]] static I multiply_low(I a, I b) { return (I)_mm256_mul_epu32((__m256i)a, (__m256i)b); }
  [[gnu::always_inline]] static D load_floats(const float* p) { return _mm256_cvtps_pd(_mm_loadu_ps(p)); }
  [[gnu::always_inline]] static void store_floats(float* p, D v) { _mm_storeu_ps(p, _mm256_cvtpd_ps(v)); }
  [[gnu::always_inline]] static void store_pairs(double* p, D a, D b) {
    const D low = _mm256_unpacklo_pd(a, b), high = _mm256_unpackhi_pd(a, b);
    store(p, _mm256_permute2f128_pd(low, high, 0x20));
    store(p + width, _mm256_permute2f128_pd(low, high, 0x31));
  }
  [[gnu::always_inline]] static D gather(const double* const* p, std::ptrdiff_t offset) {
    return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadh_pd(_mm_load_sd(p[0] + offset), p[1] + offset)),
                                _mm_loadh_pd(_mm_load_sd(p[2] + offset), p[3] + offset), 1);
  }
  [[gnu::always_inline]] static void scatter(double* const* p, std::ptrdiff_t offset, D v) {
    double values[width];
    store(values, v);
    for (int lane = 0; lane < width; ++lane) p[lane][offset] = values[lane];
  }
};

#elif defined(__x86_64__)

struct Native {
  using D = __m128d;
  using I = std::int64_t __attribute__((vector_size(16)));
  static constexpr int width = 2;
  [[gnu::always_inline]] static D set(double a) { return _mm_set1_pd(a); }
  [[gnu::always_inline]] static D load(const double* p) { return _mm_loadu_pd(p); }
  [[gnu::always_inline]] static void store(double* p, D v) { _mm_storeu_pd(p, v); }
  /// SSE2 lacks it: the C library's, exactly rounded as in IEEE 754.
  [[gnu::always_inline]] static D fma(D a, D b, D c) {
    return D{__builtin_fma(a[0], b[0], c[0]), __builtin_fma(a[1], b[1], c[1])};
  }
  [[gnu::always_inline]] static D min(D a, D b) { return _mm_min_pd(a, b); }
  [[gnu::always_inline]] static D max(D a, D b) { return _mm_max_pd(a, b); }
  [[gnu::always_inline]] static D abs(D a) { return _mm_andnot_pd(_mm_set1_pd(-0.0), a); }
  [[gnu::always_inline]] static D sqrt(D a) { return _mm_sqrt_pd(a); }
  [[gnu::always_inline]] static bool all_within(D a, double limit) {
    return _mm_movemask_pd(_mm_cmpnle_pd(a, _mm_set1_pd(limit))) == 0;
  }
  [[gnu::always_inline]] static I bits(D a) { return (I)a; }
  [[gnu::always_inline]] static D from_bits(I a) { return (D)a; }
  [[gnu::always_inline]] static I set_bits(std::int64_t a) { return I{} + a; }
  [[gnu::always_inline]] static I multiply_low(I a, I b) { return (I)_mm_mul_epu32((__m128i)a, (__m128i)b); }
  [[gnu::always_inline]] static D load_floats(const float* p) {
    return _mm_cvtps_pd(_mm_castsi128_ps(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(p))));
  }
  [[gnu::always_inline]] static void store_floats(float* p, D v) {
    _mm_storel_pi(reinterpret_cast<__m64*>(p), _mm_cvtpd_ps(v));
  }
  [[gnu::always_inline]] static void store_pairs(double* p, D a, D b) {
    store(p, _mm_unpacklo_pd(a, b));
    store(p + width, _mm_unpackhi_pd(a, b));
  }
  [[gnu::always_inline]] static D gather(const double* const* p, std::ptrdiff_t offset) {
    return _mm_loadh_pd(_mm_load_sd(p[0] + offset), p[1] + offset);
  }
  [[gnu::always_inline]] static void scatter(double* const* p, std::ptrdiff_t offset, D v) {
    p[0][offset] = v[0];
    p[1][offset] = v[1];
  }
};

#elif defined(__aarch64__)

struct Native {
  using D = float64x2_t;
  using I = std::int64_t __attribute__((vector_size(16)));
  static constexpr int width = 2;
  [[gnu::always_inline]] static D set(double a) { return vdupq_n_f64(a); }
  [[gnu::always_inline]] static D load(const double* p) { return vld1q_f64(p); }
  [[gnu::always_inline]] static void store(double* p, D v) { vst1q_f64(p, v); }
  [[gnu::always_inline]] static D fma(D a, D b, D c) { return vfmaq_f64(c, a, b); }
  [[gnu::always_inline]] static D min(D a, D b) { return vbslq_f64(vcltq_f64(a, b), a, b); }
  [[gnu::always_inline]] static D max(D a, D b) { return vbslq_f64(vcgtq_f64(a, b), a, b); }
  [[gnu::always_inline]] static D abs(D a) { return vabsq_f64(a); }
  [[gnu::always_inline]] static D sqrt(D a) { return vsqrtq_f64(a); }
  [[gnu::always_inline]] static bool all_within(D a, double limit) {
    const uint64x2_t within = vcleq_f64(a, vdupq_n_f64(limit));
    return (vgetq_lane_u64(within, 0) & vgetq_lane_u64(within, 1)) != 0;
  }
  [[gnu::always_inline]] static I bits(D a) { return (I)a; }
  [[gnu::always_inline]] static D from_bits(I a) { return (D)a; }
  [[gnu::always_inline]] static I set_bits(std::int64_t a) { return I{} + a; }
  [[gnu::always_inline]] static I multiply_low(I a, I b) {
    return (I)vmull_u32(vmovn_u64((uint64x2_t)a), vmovn_u64((uint64x2_t)b));
  }
  [[gnu::always_inline]] static D load_floats(const float* p) { return vcvt_f64_f32(vld1_f32(p)); }
  [[gnu::always_inline]] static void store_floats(float* p, D v) { vst1_f32(p, vcvt_f32_f64(v)); }
  [[gnu::always_inline]] static void store_pairs(double* p, D a, D b) {
    store(p, vzip1q_f64(a, b));
    store(p + width, vzip2q_f64(a, b));
  }
  [[gnu::always_inline]] static D gather(const double* const* p, std::ptrdiff_t offset) {
    return D{p[0][offset], p[1][offset]};
  }
  [[gnu::always_inline]] static void scatter(double* const* p, std::ptrdiff_t offset, D v) {
    p[0][offset] = v[0];
    p[1][offset] = v[1];
  }
};

#elif defined(__wasm__)

struct Native {
  using D = double __attribute__((vector_size(16)));
  using I = std::int64_t __attribute__((vector_size(16)));
  static constexpr int width = 2;
  [[gnu::always_inline]] static D set(double a) { return (D)wasm_f64x2_splat(a); }
  [[gnu::always_inline]] static D load(const double* p) { return (D)wasm_v128_load(p); }
  [[gnu::always_inline]] static void store(double* p, D v) { wasm_v128_store(p, (v128_t)v); }
#if defined(__wasm_relaxed_simd__)
  [[gnu::always_inline]] static D fma(D a, D b, D c) {
    return (D)wasm_f64x2_relaxed_madd((v128_t)a, (v128_t)b, (v128_t)c);
  }
#else
  [[gnu::always_inline]] static D fma(D a, D b, D c) {
    return exact_fma(a, b, c);
  }
#endif
  [[gnu::always_inline]] static D min(D a, D b) {
    return (D)wasm_f64x2_pmin((v128_t)b, (v128_t)a);
  }
  [[gnu::always_inline]] static D max(D a, D b) {
    return (D)wasm_f64x2_pmax((v128_t)b, (v128_t)a);
  }
  [[gnu::always_inline]] static D abs(D a) {
    return (D)wasm_f64x2_abs((v128_t)a);
  }
  [[gnu::always_inline]] static D sqrt(D a) {
    return (D)wasm_f64x2_sqrt((v128_t)a);
  }
  [[gnu::always_inline]] static bool all_within(D a, double limit) {
    return wasm_i64x2_all_true(wasm_f64x2_le((v128_t)a, wasm_f64x2_splat(limit)));
  }
  [[gnu::always_inline]] static I bits(D a) {
    return (I)a;
  }
  [[gnu::always_inline]] static D from_bits(I a) {
    return (D)a;
  }
  [[gnu::always_inline]] static I set_bits(std::int64_t a) {
    return I{} + a;
  }
  [[gnu::always_inline]] static I multiply_low(I a, I b) {
    const v128_t x = (v128_t)a, y = (v128_t)b;
    return (I)wasm_u64x2_extmul_low_u32x4(wasm_i32x4_shuffle(x, x, 0, 2, 0, 2), wasm_i32x4_shuffle(y, y, 0, 2, 0, 2));
  }
  [[gnu::always_inline]] static D load_floats(const float* p) {
    return (D)wasm_f64x2_promote_low_f32x4(wasm_v128_load64_zero(p));
  }
  [[gnu::always_inline]] static void store_floats(float* p, D v) {
    wasm_v128_store64_lane(p, wasm_f32x4_demote_f64x2_zero((v128_t)v), 0);
  }
  [[gnu::always_inline]] static void store_pairs(double* p, D a, D b) {
    store(p, (D)wasm_i64x2_shuffle((v128_t)a, (v128_t)b, 0, 2));
    store(p + width, (D)wasm_i64x2_shuffle((v128_t)a, (v128_t)b, 1, 3));
  }
  [[gnu::always_inline]] static D gather(const double* const* p, std::ptrdiff_t offset) {
    return D{p[0][offset], p[1][offset]};
  }
  [[gnu::always_inline]] static void scatter(double* const* p, std::ptrdiff_t offset, D v) {
    p[0][offset] = v[0];
    p[1][offset] = v[1];
  }
};

#endif

}  // namespace
}  // namespace decid
