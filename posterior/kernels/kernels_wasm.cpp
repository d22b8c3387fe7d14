// The kernels of the posterior density for WebAssembly's vectors.
#include "posterior/kernels/generic.hpp"

namespace decid::posterior {

const Kernels& Tables::wasm() {
  return kernel_table<Native>;
}

}  // namespace decid::posterior
