// A quarter of the 16 lanes with AArch64's NEON, and the tile of accumulators that suits it.
// Everything here is inlined and of internal linkage, as in the other instruction sets.
#pragma once

#include <arm_neon.h>

namespace decid::nn {
namespace {

struct Neon {
  using Float = float32x4_t;
  static constexpr int width = 4;
  // 24 accumulators + 6 values + 1 broadcast weight of 32 registers.
  static constexpr int tile_channels = 4, tile_columns = 6;
  static constexpr int gradient_channels = 4, gradient_columns = 6;
  static constexpr int block_bytes() { return 24 * 1024; }
  static constexpr int gradient_bytes(bool) { return 36 * 1024; }
  static constexpr int block_taps = 256;

  [[gnu::always_inline]] static Float load(const float* p) { return vld1q_f32(p); }
  [[gnu::always_inline]] static void store(float* p, Float v) { vst1q_f32(p, v); }
  /// v, in a register: keeps the compiler from loading it again at each use.
  [[gnu::always_inline]] static Float keep(Float v) {
    asm("" : "+w"(v));
    return v;
  }
  [[gnu::always_inline]] static Float broadcast(float v) { return vdupq_n_f32(v); }
  [[gnu::always_inline]] static Float add(Float a, Float b) { return vaddq_f32(a, b); }
  [[gnu::always_inline]] static Float sub(Float a, Float b) { return vsubq_f32(a, b); }
  [[gnu::always_inline]] static Float mul(Float a, Float b) { return vmulq_f32(a, b); }
  [[gnu::always_inline]] static Float fma(Float a, Float b, Float c) { return vfmaq_f32(c, a, b); }
  /// a > b ? x : y, false for NaN.
  [[gnu::always_inline]] static Float if_greater(Float a, Float b, Float x, Float y) {
    return vbslq_f32(vcgtq_f32(a, b), x, y);
  }
  /// a > b ? x : y, true if a is NaN, false if only b is NaN.
  [[gnu::always_inline]] static Float if_greater_or_nan(Float a, Float b, Float x, Float y) {
    return vbslq_f32(vornq_u32(vcgtq_f32(a, b), vceqq_f32(a, a)), x, y);
  }
};

}  // namespace
}  // namespace decid::nn
