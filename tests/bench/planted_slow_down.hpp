// A slow-down planted into the AVX2 kernels for the test of tools/bench-gate: forced in front of kernels_avx2.cpp, it
// gives every load of a vector an instruction more that does nothing. Production code knows nothing of it.
#pragma once

#include <immintrin.h>

namespace {

[[gnu::always_inline]] inline __m256 slow_loadu_ps(const float* p) {
  asm volatile("nop");
  return _mm256_loadu_ps(p);
}

}  // namespace

#define _mm256_loadu_ps slow_loadu_ps
