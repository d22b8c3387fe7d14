// A quarter of the 16 lanes with WebAssembly's vectors. Where these are relaxed, their multiply-add is one instruction
// (base/math/relaxed.hpp tests whether it rounds once); where they are not, it is computed in double and rounded once,
// as in vec_baseline.hpp.
#pragma once

#include <wasm_simd128.h>

namespace decid::nn {
namespace {

struct Wasm {
  using Float = v128_t;
  static constexpr int width = 4;
#if defined(__wasm_relaxed_simd__)
  // As AVX2: engines on x86-64 have 16 registers.
  static constexpr int tile_channels = 6, tile_columns = 2;
  static constexpr int gradient_channels = 2, gradient_columns = 6;
  static constexpr int block_bytes() {
    return 24 * 1024;
  }
  static constexpr int gradient_bytes(bool) {
    return 24 * 1024;
  }
  static constexpr int block_taps = 256;
#else
  // The emulation uses most of the registers.
  static constexpr int tile_channels = 2, tile_columns = 2;
  static constexpr int gradient_channels = 2, gradient_columns = 2;
  static constexpr int block_bytes() {
    return 24 * 1024;
  }
  static constexpr int gradient_bytes(bool) {
    return 24 * 1024;
  }
  static constexpr int block_taps = 256;
#endif

  [[gnu::always_inline]] static Float load(const float* p) {
    return wasm_v128_load(p);
  }
  [[gnu::always_inline]] static void store(float* p, Float v) {
    wasm_v128_store(p, v);
  }
  /// The engine chooses its registers itself.
  [[gnu::always_inline]] static Float keep(Float v) {
    return v;
  }
  [[gnu::always_inline]] static Float broadcast(float v) {
    return wasm_f32x4_splat(v);
  }
  [[gnu::always_inline]] static Float add(Float a, Float b) {
    return wasm_f32x4_add(a, b);
  }
  [[gnu::always_inline]] static Float sub(Float a, Float b) {
    return wasm_f32x4_sub(a, b);
  }
  [[gnu::always_inline]] static Float mul(Float a, Float b) {
    return wasm_f32x4_mul(a, b);
  }
  [[gnu::always_inline]] static Float fma(Float a, Float b, Float c) {
#if defined(__wasm_relaxed_simd__)
    return wasm_f32x4_relaxed_madd(a, b, c);
#else
    const v128_t low = sum_to_odd(wasm_f64x2_mul(lower(a), lower(b)), lower(c));
    const v128_t high = sum_to_odd(wasm_f64x2_mul(upper(a), upper(b)), upper(c));
    return wasm_i64x2_shuffle(wasm_f32x4_demote_f64x2_zero(low), wasm_f32x4_demote_f64x2_zero(high), 0, 2);
#endif
  }
  /// a > b ? x : y, false for NaN.
  [[gnu::always_inline]] static Float if_greater(Float a, Float b, Float x, Float y) {
    return wasm_v128_bitselect(x, y, wasm_f32x4_gt(a, b));
  }
  /// a > b ? x : y, true if a is NaN, false if only b is NaN.
  [[gnu::always_inline]] static Float if_greater_or_nan(Float a, Float b, Float x, Float y) {
    return wasm_v128_bitselect(x, y, wasm_v128_or(wasm_f32x4_gt(a, b), wasm_f32x4_ne(a, a)));
  }

 private:
  [[gnu::always_inline]] static v128_t lower(Float v) {
    return wasm_f64x2_promote_low_f32x4(v);
  }
  [[gnu::always_inline]] static v128_t upper(Float v) {
    return lower(wasm_i64x2_shuffle(v, v, 1, 1));
  }

  /// product + c, rounded to odd: vec_baseline.hpp explains why a float rounded from it is correct.
  [[gnu::always_inline]] static v128_t sum_to_odd(v128_t product, v128_t c) {
    const v128_t sum = wasm_f64x2_add(product, c);
    const v128_t from_c = wasm_f64x2_sub(sum, product);
    // With infinities the error is NaN, which is neither below nor above zero.
    const v128_t error =
        wasm_f64x2_add(wasm_f64x2_sub(product, wasm_f64x2_sub(sum, from_c)), wasm_f64x2_sub(c, from_c));
    const v128_t zero = wasm_f64x2_splat(0.0);
    const v128_t inexact = wasm_v128_or(wasm_f64x2_lt(error, zero), wasm_f64x2_gt(error, zero));
    const v128_t even = wasm_v128_and(wasm_v128_andnot(wasm_i64x2_splat(1), sum), inexact);
    const v128_t opposed = wasm_i64x2_shr(wasm_v128_xor(sum, error), 63);  // all ones or zero
    return wasm_i64x2_add(sum, wasm_i64x2_sub(wasm_v128_xor(even, opposed), opposed));
  }
};

}  // namespace
}  // namespace decid::nn
