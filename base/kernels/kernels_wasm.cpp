// Random numbers for WebAssembly's vectors.
#include "base/kernels/generic.hpp"

namespace decid {

const RandomKernels& RandomTables::wasm() {
  return random_table<Native>;
}

}  // namespace decid
