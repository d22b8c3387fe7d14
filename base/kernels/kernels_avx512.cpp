// Random numbers for x86-64 with AVX-512.
#include "base/kernels/generic.hpp"

namespace decid {

const RandomKernels& RandomTables::avx512() {
  return random_table<Native>;
}

}  // namespace decid
