// Half of the 16 lanes with AVX2 and FMA, and the tile of accumulators that suits it.
// Everything here is inlined and of internal linkage: nothing compiled for AVX2 can be linked into other code.
#pragma once

#include <immintrin.h>

namespace decid::nn {
namespace {

struct Avx2 {
  using Float = __m256;
  static constexpr int width = 8;
  // 12 accumulators + 3 values + 1 broadcast weight: all 16 registers. 7 loads for 12 multiply-adds, and blocks of 16
  // channels are whole tiles.
  static constexpr int tile_channels = 4, tile_columns = 3;
  // 2 x 6 for weight gradients: two channels of diff_dst, so that more positions fit the cache.
  static constexpr int gradient_channels = 2, gradient_columns = 6;
  // Bytes used of the first-level cache, 32 KB in most processors without AVX-512; measured on a Zen 3
  // (docs/research/benchmarks.md).
  static constexpr int block_bytes() { return 8 * 1024; }
  static constexpr int gradient_bytes(bool strided) { return (strided ? 24 : 18) * 1024; }
  static constexpr int block_taps = 256;

  [[gnu::always_inline]] static Float load(const float* p) { return _mm256_loadu_ps(p); }
  [[gnu::always_inline]] static void store(float* p, Float v) { _mm256_storeu_ps(p, v); }
  /// v, in a register: keeps the compiler from loading it again at each use.
  [[gnu::always_inline]] static Float keep(Float v) {
    asm("" : "+x"(v));
    return v;
  }
  [[gnu::always_inline]] static Float broadcast(float v) { return _mm256_set1_ps(v); }
  [[gnu::always_inline]] static Float add(Float a, Float b) { return _mm256_add_ps(a, b); }
  [[gnu::always_inline]] static Float sub(Float a, Float b) { return _mm256_sub_ps(a, b); }
  [[gnu::always_inline]] static Float mul(Float a, Float b) { return _mm256_mul_ps(a, b); }
  [[gnu::always_inline]] static Float fma(Float a, Float b, Float c) { return _mm256_fmadd_ps(a, b, c); }
  /// a > b ? x : y, false for NaN.
  [[gnu::always_inline]] static Float if_greater(Float a, Float b, Float x, Float y) {
    return _mm256_blendv_ps(y, x, _mm256_cmp_ps(a, b, _CMP_GT_OQ));
  }
  /// a > b ? x : y, true if a is NaN, false if only b is NaN.
  [[gnu::always_inline]] static Float if_greater_or_nan(Float a, Float b, Float x, Float y) {
    return _mm256_blendv_ps(y, x, _mm256_or_ps(_mm256_cmp_ps(a, b, _CMP_GT_OQ), _mm256_cmp_ps(a, a, _CMP_UNORD_Q)));
  }
};

}  // namespace
}  // namespace decid::nn
