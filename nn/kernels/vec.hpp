// Vec: the vector of floats of the instruction set that a translation unit is compiled for.
#pragma once

#if defined(__AVX512F__)
#include "nn/kernels/vec_avx512.hpp"
#elif defined(__AVX2__)
#include "nn/kernels/vec_avx2.hpp"
#elif defined(__x86_64__)
#include "nn/kernels/vec_baseline.hpp"
#elif defined(__aarch64__)
#include "nn/kernels/vec_neon.hpp"
#elif defined(__wasm__)
#include "nn/kernels/vec_wasm.hpp"
#endif

namespace decid::nn {
namespace {

#if defined(__AVX512F__)
using Vec = Avx512;
#elif defined(__AVX2__)
using Vec = Avx2;
#elif defined(__x86_64__)
using Vec = Baseline;
#elif defined(__aarch64__)
using Vec = Neon;
#elif defined(__wasm__)
using Vec = Wasm;
#endif

}  // namespace
}  // namespace decid::nn
