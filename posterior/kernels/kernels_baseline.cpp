// The kernels of the posterior density for x86-64 as every such processor has it (SSE2).
#include "posterior/kernels/generic.hpp"

namespace decid::posterior {

const Kernels& Tables::baseline() {
  return kernel_table<Native>;
}

}  // namespace decid::posterior
