// Random numbers for x86-64 with AVX2 and FMA (2013 on).
#include "base/kernels/generic.hpp"

namespace decid {

const RandomKernels& RandomTables::avx2() {
  return random_table<Native>;
}

}  // namespace decid
