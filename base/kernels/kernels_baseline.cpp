// Random numbers for x86-64 as every such processor has it (SSE2).
#include "base/kernels/generic.hpp"

namespace decid {

const RandomKernels& RandomTables::baseline() {
  return random_table<Native>;
}

}  // namespace decid
