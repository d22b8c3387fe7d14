// Random numbers, written once on a vector type V (base/doubles.hpp) and compiled once per instruction set.
#pragma once

#include "base/kernels/kernels.hpp"
#include "base/math_lanes.hpp"

namespace decid {
namespace {

template <class V>
void normals(const NormalsRequest& request, std::int64_t blocks, double* out) {
  using I = typename V::I;
  double counting[V::width], even[V::width], odd[V::width];
  for (int lane = 0; lane < V::width; ++lane) counting[lane] = __builtin_bit_cast(double, std::int64_t{lane});
  const I lane_numbers = V::bits(V::load(counting)), low = V::set_bits(0xffffffff);
  for (std::int64_t done = 0; done < blocks; done += V::width) {
    const I number = lane_numbers + V::set_bits(static_cast<std::int64_t>(request.first_block) + done);
    // The stream fills 8 bits, so the block's number has 56.
    const I words3 = V::set_bits(request.stream) | (((number >> 32) & low) << 8);
    const PhiloxWords<V> words =
        philox_lanes<V>({{number & low, V::set_bits(static_cast<std::int64_t>(request.item & 0xffffffff)),
                          V::set_bits(static_cast<std::int64_t>(request.item >> 32)), words3}},
                        request.key[0], request.key[1]);
    V::store(even, inverse_normal_lanes<V>(to_unit_interval<V>(words.word[0] | (words.word[1] << 32))));
    V::store(odd, inverse_normal_lanes<V>(to_unit_interval<V>(words.word[2] | (words.word[3] << 32))));
    const std::int64_t here = blocks - done < V::width ? blocks - done : V::width;
    for (std::int64_t lane = 0; lane < here; ++lane) {
      out[2 * (done + lane)] = even[lane];
      out[2 * (done + lane) + 1] = odd[lane];
    }
  }
}

template <class V>
constexpr RandomKernels random_table{normals<V>};

}  // namespace
}  // namespace decid
