// The kernels of the posterior density for WebAssembly's relaxed vectors.
#include "posterior/kernels/generic.hpp"

namespace decid::posterior {

const Kernels& Tables::relaxed() {
  return kernel_table<Native>;
}

}  // namespace decid::posterior
