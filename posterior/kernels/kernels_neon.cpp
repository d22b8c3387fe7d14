// The kernels of the posterior density for AArch64.
#include "posterior/kernels/generic.hpp"

namespace decid::posterior {

const Kernels& Tables::neon() {
  return kernel_table<Native>;
}

}  // namespace decid::posterior
