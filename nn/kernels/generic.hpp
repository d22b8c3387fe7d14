// The fast kernels, written once on a vector type V (vec_*.hpp) and compiled once per instruction set.
// All in an unnamed namespace: every function is internal to its translation unit, so the linker cannot pick a copy
// compiled for AVX-512 for a caller on a lesser machine. For the same reason no standard library functions here.
#pragma once

#include "nn/kernels/generic_activation.hpp"
#include "nn/kernels/generic_conv.hpp"
#include "nn/kernels/generic_conv_gradient.hpp"
#include "nn/kernels/generic_dense.hpp"
#include "nn/kernels/generic_plane.hpp"
#include "nn/kernels/generic_pool.hpp"
#include "nn/kernels/generic_sigmoid.hpp"
#include "nn/kernels/generic_single.hpp"
#include "nn/kernels/generic_statistics.hpp"

namespace decid::nn {
namespace {

template <class V>
constexpr Kernels<float> kernel_table(const char* name) {
  return {
      name,
      conv2d_forward<V>,
      conv2d_backward_src<V>,
      conv2d_backward_weight<V>,
      fully_connected_forward<V>,
      fully_connected_backward_src<V>,
      fully_connected_backward_weight<V>,
      conv2d_single<V>,
      batchnorm_sums<V>,
      batchnorm_backward_sums<V>,
      batchnorm_backward_apply<V>,
      activation_forward<V>,
      activation_backward<V>,
      relu_forward<V>,
      relu_backward<V>,
      average_pool_forward<V>,
      average_pool_backward<V>,
      max_pool_forward<V>,
      max_pool_backward<V>,
      statistics_pool_forward<V>,
      statistics_pool_backward<V>,
      sgd_step<V>,
      sigmoid_forward<Native>,
      gelu_backward<Native>,
  };
}

}  // namespace
}  // namespace decid::nn
