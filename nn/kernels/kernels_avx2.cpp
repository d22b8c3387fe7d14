// The kernels for x86-64 with AVX2 and FMA (2013 on).
#include "nn/kernels/generic.hpp"
#include "nn/kernels/isa.hpp"
#include "nn/kernels/vec_avx2.hpp"

namespace decid::nn {

const Kernels<float>& FloatTables::avx2() {
  static constexpr Kernels<float> table = kernel_table<Avx2>("avx2");
  return table;
}

}  // namespace decid::nn
