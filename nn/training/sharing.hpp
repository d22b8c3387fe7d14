// Division of a batch among threads: blocks of 16 samples times groups of channels, each computed on its own.
#pragma once

#include <algorithm>

#include "base/parallel.hpp"

namespace decid::nn {

/// Calls body(block, first, last) for every block and every group of `group` channels. The groups do not affect the
/// bits; they are small enough to keep two threads busy with a batch of one block, large enough to reuse what a kernel
/// loads.
template <class Body>
void for_each_group(int blocks, int channels, int group, const Body& body) {
  const int groups = (channels + group - 1) / group;
  parallel_for(blocks * groups, [&](int item) {
    const int first = item % groups * group;
    body(item / groups, first, std::min(first + group, channels));
  });
}

/// Values of a parameter that a thread takes at a time: 32 KB of floats.
inline constexpr int value_group = 8192;
/// Channels of a convolution, outputs of a fully connected layer, and channels of layers that work plane by plane.
inline constexpr int conv_group = 16;
inline constexpr int output_group = 64;
inline constexpr int plane_group = 8;

/// Calls body(block, channel) for every plane of a batch.
template <class Body>
void for_each_plane(int blocks, int channels, const Body& body) {
  for_each_group(blocks, channels, plane_group, [&](int block, int first, int last) {
    for (int c = first; c < last; ++c) body(block, c);
  });
}

}  // namespace decid::nn
