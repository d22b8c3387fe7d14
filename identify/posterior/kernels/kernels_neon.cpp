// The kernels of the posterior density for AArch64.
#include "identify/posterior/kernels/generic.hpp"

namespace decid::posterior {

const Kernels& Tables::neon() {
  return kernel_table<Native>;
}

}  // namespace decid::posterior
