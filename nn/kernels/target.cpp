// The kernels of one instruction set, DECID_TARGET: compiled once for each with its flags (decid_kernels in
// cmake/DecidTargets.cmake).
#include "nn/kernels/generic.hpp"
#include "nn/kernels/isa.hpp"
#include "nn/kernels/vec.hpp"

#define DECID_TEXT_OF(name) #name
#define DECID_TEXT(name) DECID_TEXT_OF(name)

namespace decid::nn {

const Kernels<float>& FloatTables::DECID_TARGET() {
  static constexpr Kernels<float> table = kernel_table<Vec>(DECID_TEXT(DECID_TARGET));
  return table;
}

}  // namespace decid::nn
