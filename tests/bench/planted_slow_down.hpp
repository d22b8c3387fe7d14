// A slow-down planted into the AVX2 kernels for the test of tools/bench-gate: forced in front of kernels/target.cpp for
// AVX2, it puts an instruction that does nothing beside every second broadcast weight, 8% more in all of a forward
// convolution. Production code knows nothing of it.
#pragma once

#include <immintrin.h>

asm(".set planted_broadcasts, 0");

namespace {

/// Tied to the value and not volatile, so that the compiler orders and allocates registers, all 16, as without it.
[[gnu::always_inline]] inline __m256 slow_set1_ps(float value) {
  __m256 result = _mm256_set1_ps(value);
  asm inline(  // inline: its lines do not make the kernel look large
      ".set planted_broadcasts, planted_broadcasts + 1\n"
      ".if planted_broadcasts %% 2 == 0\n"
      "nop\n"
      ".endif"
      : "+x"(result));
  return result;
}

}  // namespace

#define _mm256_set1_ps slow_set1_ps
