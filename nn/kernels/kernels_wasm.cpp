// The kernels for WebAssembly's vectors.
#include "nn/kernels/generic.hpp"
#include "nn/kernels/isa.hpp"
#include "nn/kernels/vec_wasm.hpp"

namespace decid::nn {

const Kernels<float>& FloatTables::wasm() {
  static constexpr Kernels<float> table = kernel_table<Wasm>("wasm");
  return table;
}

void baseline_fma(const float a[4], const float b[4], const float c[4], float result[4]) {
  Wasm::store(result, Wasm::fma(Wasm::load(a), Wasm::load(b), Wasm::load(c)));
}

}  // namespace decid::nn
