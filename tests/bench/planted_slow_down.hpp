// A slow-down planted into the AVX2 kernels for the test of tools/bench-gate: forced in front of kernels_avx2.cpp, it
// puts an instruction that does nothing beside every fourth fused multiply-add, 9% more in all of a forward
// convolution. Production code knows nothing of it.
#pragma once

#include <immintrin.h>

asm(".set planted_multiply_adds, 0");

namespace {

[[gnu::always_inline]] inline __m256 slow_fmadd_ps(__m256 a, __m256 b, __m256 c) {
  asm inline volatile(  // inline: its lines do not make the kernel look large
      ".set planted_multiply_adds, planted_multiply_adds + 1\n"
      ".if planted_multiply_adds % 4 == 0\n"
      "nop\n"
      ".endif");
  return _mm256_fmadd_ps(a, b, c);
}

}  // namespace

#define _mm256_fmadd_ps slow_fmadd_ps
