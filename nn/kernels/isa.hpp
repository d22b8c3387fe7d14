// The float tables compiled for one instruction set each, as dispatch.cpp sees them. Which exist depends on the
// processor family; whether one may run is decided at run time.
#pragma once

#include "nn/kernels/kernels.hpp"

namespace decid::nn {

/// For table_for.
struct FloatTables {
  static const Kernels<float>& reference() { return reference_kernels<float>(); }
  static const Kernels<float>& baseline();
  static const Kernels<float>& avx2();
  static const Kernels<float>& avx512();
  static const Kernels<float>& neon();
  static const Kernels<float>& wasm();
  static const Kernels<float>& relaxed();
};

}  // namespace decid::nn
