// The kernels for AArch64.
#include "nn/kernels/generic.hpp"
#include "nn/kernels/isa.hpp"
#include "nn/kernels/vec_neon.hpp"

namespace decid::nn {

const Kernels<float>& FloatTables::neon() {
  static constexpr Kernels<float> table = kernel_table<Neon>("neon");
  return table;
}

}  // namespace decid::nn
