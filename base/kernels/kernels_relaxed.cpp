// Random numbers for WebAssembly's relaxed vectors.
#include "base/kernels/generic.hpp"

namespace decid {

const RandomKernels& RandomTables::relaxed() {
  return random_table<Native>;
}

}  // namespace decid
