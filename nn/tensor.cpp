// Tensors: their refusals, and their memory.
#include "nn/tensor.hpp"

#include <string>

#include "base/error.hpp"

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace decid::nn {

void refuse_sample(int sample, int batch, std::size_t values, int size) {
  if (sample < 0 || sample >= batch)
    throw Error(Code::setting_out_of_range, "tensor",
                "has no sample " + std::to_string(sample) + ": the batch has " + std::to_string(batch),
                "count samples from 0");
  throw Error(
      Code::size_mismatch, "tensor",
      "has samples of " + std::to_string(size) + " values where " + std::to_string(values) + " are given or have room",
      "give a span of that size");
}

void advise_large_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t bytes) {
#if defined(__linux__)
  // Debian's default is pages of 4 KB unless a program requests large ones. A refusal changes nothing.
  static_cast<void>(madvise(memory, bytes, MADV_HUGEPAGE));
#endif
}

}  // namespace decid::nn
