// The kernels of the posterior density for x86-64 with AVX-512.
#include "posterior/kernels/generic.hpp"

namespace decid::posterior {

const Kernels& Tables::avx512() {
  return kernel_table<Native>;
}

}  // namespace decid::posterior
