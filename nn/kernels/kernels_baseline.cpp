// The kernels for x86-64 as every such processor has it (SSE2).
#include "nn/kernels/generic.hpp"
#include "nn/kernels/isa.hpp"
#include "nn/kernels/vec_baseline.hpp"

namespace decid::nn {

const Kernels<float>& FloatTables::baseline() {
  static constexpr Kernels<float> table = kernel_table<Baseline>("baseline");
  return table;
}

void baseline_fma(const float a[4], const float b[4], const float c[4], float result[4]) {
  Baseline::store(result, Baseline::fma(Baseline::load(a), Baseline::load(b), Baseline::load(c)));
}

}  // namespace decid::nn
