// The kernels that work on planes and are bound by memory: what each does to one channel of a block, and the bytes that
// it moves.
#pragma once

#include "bench/nn/convolutions.hpp"

namespace decid::bench {

/// A kernel bound by memory: what it does to one channel of a block, and the bytes it moves a value of src.
struct PlaneKernel {
  const char* name;
  double bytes;
  void (*run)(const Kernels<float>&, const Batch& x, const Batch& dy, const Batch& pooled, int block, int channel);
};

inline PoolShape pool_of_one(const Batch& x) {
  const Shape s = x.tensor.shape();
  return {1, s.rows, s.columns, s.rows / 2, s.columns / 2, 2, 2, 2, 2};
}

template <class V>
V from(V view, int channel) {
  view.data += channel * view.channel;
  return view;
}

inline constexpr PlaneKernel plane_kernels[] = {
    {"batchnorm_sums", 4,
     [](const Kernels<float>& k, const Batch& x, const Batch&, const Batch&, int b, int c) {
       double sums[2 * lanes] = {};
       k.batchnorm_sums(x.const_plane(b, c), 0.1F, sums);
       asm volatile("" : : "r"(sums) : "memory");
     }},
    {"activation_forward", 8,
     [](const Kernels<float>& k, const Batch& x, const Batch& dy, const Batch&, int b, int c) {
       k.activation_forward({1.1F, 0.1F, true, Pooling::none}, {}, x.const_plane(b, c), dy.plane(b, c));
     }},
    {"activation_forward_max_2x2", 5,
     [](const Kernels<float>& k, const Batch& x, const Batch&, const Batch& p, int b, int c) {
       k.activation_forward({1.1F, 0.1F, true, Pooling::max}, pool_of_one(x), x.const_plane(b, c), p.plane(b, c));
     }},
    {"activation_backward_max_2x2", 9,
     [](const Kernels<float>& k, const Batch& x, const Batch& dy, const Batch& p, int b, int c) {
       k.activation_backward({1.1F, 0.1F, true, Pooling::max}, pool_of_one(x), x.const_plane(b, c), p.const_plane(b, c),
                             dy.plane(b, c));
     }},
    {"batchnorm_backward_sums", 8,
     [](const Kernels<float>& k, const Batch& x, const Batch& dy, const Batch&, int b, int c) {
       double sums[2 * lanes] = {};
       k.batchnorm_backward_sums(x.const_plane(b, c), dy.const_plane(b, c), 0.1F, sums);
       asm volatile("" : : "r"(sums) : "memory");
     }},
    {"batchnorm_backward_apply", 12,
     [](const Kernels<float>& k, const Batch& x, const Batch& dy, const Batch&, int b, int c) {
       k.batchnorm_backward_apply(x.const_plane(b, c), dy.const_plane(b, c), 0.99F, 1e-3F, 1e-4F, dy.plane(b, c));
     }},
    {"relu_forward", 8,
     [](const Kernels<float>& k, const Batch& x, const Batch&, const Batch&, int b, int c) {
       k.relu_forward(x.plane(b, c));
     }},
    {"relu_backward", 12,
     [](const Kernels<float>& k, const Batch& x, const Batch& dy, const Batch&, int b, int c) {
       k.relu_backward(x.const_plane(b, c), dy.plane(b, c));
     }},
    {"average_pool_forward_2x2", 5,
     [](const Kernels<float>& k, const Batch& x, const Batch&, const Batch& p, int b, int c) {
       k.average_pool_forward(pool_of_one(x), from(x.const_block(b), c), from(p.block(b), c));
     }},
    {"average_pool_backward_2x2", 5,
     [](const Kernels<float>& k, const Batch& x, const Batch&, const Batch& p, int b, int c) {
       k.average_pool_backward(pool_of_one(x), from(p.const_block(b), c), from(x.block(b), c));
     }},
    {"max_pool_forward_2x2", 5,
     [](const Kernels<float>& k, const Batch& x, const Batch&, const Batch& p, int b, int c) {
       k.max_pool_forward(pool_of_one(x), from(x.const_block(b), c), from(p.block(b), c));
     }},
    {"max_pool_backward_2x2", 9,
     [](const Kernels<float>& k, const Batch& x, const Batch& dy, const Batch& p, int b, int c) {
       k.max_pool_backward(pool_of_one(x), from(x.const_block(b), c), from(p.const_block(b), c), from(dy.block(b), c));
     }},
};

}  // namespace decid::bench
