// The kernels for WebAssembly's relaxed vectors.
#include "nn/kernels/generic.hpp"
#include "nn/kernels/isa.hpp"
#include "nn/kernels/vec_wasm.hpp"

namespace decid::nn {

const Kernels<float>& FloatTables::relaxed() {
  static constexpr Kernels<float> table = kernel_table<Wasm>("relaxed");
  return table;
}

}  // namespace decid::nn
