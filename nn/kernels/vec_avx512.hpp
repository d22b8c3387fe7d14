// One register of 16 lanes with AVX-512 F, and the tile of accumulators that suits it.
// Everything here is inlined and of internal linkage: nothing compiled for AVX-512 can be linked into other code.
#pragma once

#include <immintrin.h>

#include "base/isa.hpp"

namespace decid::nn {
namespace {

struct Avx512 {
  using Float = __m512;
  static constexpr int width = 16;
  // 24 accumulators + 6 values + 1 broadcast weight of 32 registers; 10 loads for 24 multiply-adds, where the two load
  // ports could serve 24, and far more chains than 2 FMA ports x 4 cycles of latency need.
  static constexpr int tile_channels = 4, tile_columns = 6;
  static constexpr int gradient_channels = 4, gradient_columns = 6;
  // Bytes used of a 48 KB first-level cache. Where registers are computed by halves, a tile's loads are some 25 bytes a
  // cycle at most, which a second-level cache of 1 MB delivers too (docs/research/benchmarks.md, On a Zen 4).
  static int block_bytes() { return halves_512_bits() ? 160 * 1024 : 24 * 1024; }
  static int gradient_bytes(bool strided) { return (!halves_512_bits() ? 36 : strided ? 72 : 144) * 1024; }
  static constexpr int block_taps = 1152;

  [[gnu::always_inline]] static Float load(const float* p) { return _mm512_loadu_ps(p); }
  [[gnu::always_inline]] static void store(float* p, Float v) { _mm512_storeu_ps(p, v); }
  /// v, in a register: keeps the compiler from loading it again at each use.
  [[gnu::always_inline]] static Float keep(Float v) {
    asm("" : "+v"(v));
    return v;
  }
  [[gnu::always_inline]] static Float broadcast(float v) { return _mm512_set1_ps(v); }
  [[gnu::always_inline]] static Float add(Float a, Float b) { return _mm512_add_ps(a, b); }
  [[gnu::always_inline]] static Float sub(Float a, Float b) { return _mm512_sub_ps(a, b); }
  [[gnu::always_inline]] static Float mul(Float a, Float b) { return _mm512_mul_ps(a, b); }
  [[gnu::always_inline]] static Float fma(Float a, Float b, Float c) { return _mm512_fmadd_ps(a, b, c); }
  /// a > b ? x : y, false for NaN.
  [[gnu::always_inline]] static Float if_greater(Float a, Float b, Float x, Float y) {
    return _mm512_mask_blend_ps(_mm512_cmp_ps_mask(a, b, _CMP_GT_OQ), y, x);
  }
  /// a > b ? x : y, true if a is NaN, false if only b is NaN.
  [[gnu::always_inline]] static Float if_greater_or_nan(Float a, Float b, Float x, Float y) {
    // y where a is a number and not greater: a comparison less than an "or" of two masks takes.
    const __mmask16 number = _mm512_cmp_ps_mask(a, a, _CMP_ORD_Q);
    return _mm512_mask_blend_ps(_mm512_mask_cmp_ps_mask(number, a, b, _CMP_NGT_UQ), x, y);
  }
};

}  // namespace
}  // namespace decid::nn
