// The kernels for x86-64 with AVX-512.
#include "nn/kernels/generic.hpp"
#include "nn/kernels/isa.hpp"
#include "nn/kernels/vec_avx512.hpp"

namespace decid::nn {

const Kernels<float>& FloatTables::avx512() {
  static constexpr Kernels<float> table = kernel_table<Avx512>("avx512");
  return table;
}

}  // namespace decid::nn
