// What a tensor's memory asks of the system.
#include "nn/tensor.hpp"

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace decid::nn {

void advise_large_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__)
  // Debian's default is pages of 4 KB for all who do not ask. A refusal changes nothing.
  static_cast<void>(madvise(memory, bytes, MADV_HUGEPAGE));
#endif
}

}  // namespace decid::nn
