/* Multiply-adds of relaxed vectors, for program.js to ask whether they are one rounding. */
#include <wasm_simd128.h>

__attribute__((export_name("doubles"))) double doubles(double a, double b, double c) {
  return wasm_f64x2_extract_lane(wasm_f64x2_relaxed_madd(wasm_f64x2_splat(a), wasm_f64x2_splat(b), wasm_f64x2_splat(c)),
                                 0);
}

__attribute__((export_name("floats"))) float floats(float a, float b, float c) {
  return wasm_f32x4_extract_lane(wasm_f32x4_relaxed_madd(wasm_f32x4_splat(a), wasm_f32x4_splat(b), wasm_f32x4_splat(c)),
                                 0);
}
