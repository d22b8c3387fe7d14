// Tests the relaxed vectors' multiply-add at run time: see relaxed.hpp.
#include "base/math/relaxed.hpp"

#include <wasm_simd128.h>

namespace decid {
namespace {

/// (1 + e)(1 - e) - 1 is -e^2, and 0 if the product is rounded. volatile: the machine computes it, not the compiler.
bool fuses_doubles() {
  volatile double e = 0x1p-30;
  const v128_t found = wasm_f64x2_relaxed_madd(wasm_f64x2_make(1.0 + e, 1.0 - e), wasm_f64x2_make(1.0 - e, 1.0 + e),
                                               wasm_f64x2_splat(-1.0));
  return wasm_f64x2_extract_lane(found, 0) == -0x1p-60 && wasm_f64x2_extract_lane(found, 1) == -0x1p-60;
}

bool fuses_floats() {
  volatile float e = 0x1p-13F;
  const v128_t found =
      wasm_f32x4_relaxed_madd(wasm_f32x4_splat(1.0F + e), wasm_f32x4_splat(1.0F - e), wasm_f32x4_splat(-1.0F));
  return wasm_f32x4_extract_lane(found, 0) == -0x1p-26F && wasm_f32x4_extract_lane(found, 3) == -0x1p-26F;
}

}  // namespace

bool relaxed_fuses() {
  static const bool fuses = fuses_doubles() && fuses_floats();
  return fuses;
}

double relaxed_fma(double a, double b, double c) {
  return wasm_f64x2_extract_lane(wasm_f64x2_relaxed_madd(wasm_f64x2_splat(a), wasm_f64x2_splat(b), wasm_f64x2_splat(c)),
                                 0);
}

}  // namespace decid
