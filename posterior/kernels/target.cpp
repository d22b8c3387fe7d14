// The posterior density's kernels of one instruction set, DECID_TARGET: compiled once for each with its flags
// (decid_kernels in cmake/DecidTargets.cmake).
#include "posterior/kernels/generic.hpp"

namespace decid::posterior {

const Kernels& Tables::DECID_TARGET() {
  return kernel_table<Native>;
}

}  // namespace decid::posterior
