// The float tables compiled for one instruction set each, as dispatch.cpp sees them. Which exist depends on the
// processor family; whether one may run is decided at run time.
#pragma once

#include "nn/kernels/kernels.hpp"

namespace decid::nn {

/// For table_of.
struct FloatTables {
  static const Kernels<float>& reference() { return reference_kernels<float>(); }
  static const Kernels<float>& baseline();
  static const Kernels<float>& avx2();
  static const Kernels<float>& avx512();
  static const Kernels<float>& neon();
  static const Kernels<float>& wasm();
  static const Kernels<float>& relaxed();
};

/// The baseline's exact fused multiply-add of 4 lanes, for its test: result = fma(a, b, c) rounded once.
#if defined(__x86_64__) || defined(__wasm__)
void baseline_fma(const float a[4], const float b[4], const float c[4], float result[4]);
#endif

}  // namespace decid::nn
