// The kernels of the posterior density for x86-64 with AVX2.
#include "posterior/kernels/generic.hpp"

namespace decid::posterior {

const Kernels& Tables::avx2() {
  return kernel_table<Native>;
}

}  // namespace decid::posterior
