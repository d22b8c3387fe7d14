// Half of the 16 lanes with AVX2 and FMA, and the tile of accumulators that suits it.
// Everything here is inlined and of internal linkage: nothing compiled for AVX2 can be linked into other code.
#pragma once

#include <immintrin.h>

namespace decid::nn {
namespace {

struct Avx2 {
  using Float = __m256;
  static constexpr int width = 8;
  // 12 accumulators + 2 values + 1 broadcast weight: 15 of the 16 registers, one less than 4 x 3 would take, which the
  // compiler fits in only by spilling. 8 loads for 12 multiply-adds.
  static constexpr int tile_channels = 6, tile_columns = 2;
  // The same for weight gradients; two channels of diff_dst, so that more positions fit the cache.
  static constexpr int gradient_channels = 2, gradient_columns = 6, gradient_bytes = 24 * 1024;

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
};

}  // namespace
}  // namespace decid::nn
