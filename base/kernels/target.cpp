// Random numbers of one instruction set, DECID_TARGET: compiled once for each with its flags (decid_kernels in
// cmake/DecidTargets.cmake).
#include "base/kernels/generic.hpp"

namespace decid {

const RandomKernels& RandomTables::DECID_TARGET() {
  return random_table<Native>;
}

}  // namespace decid
