// Random numbers, written once on a vector type V (base/math/doubles.hpp) and compiled once per instruction set.
#pragma once

#include "base/kernels/kernels.hpp"
#include "base/math/math_lanes.hpp"

namespace decid {
namespace {

/// The chunk of uniform numbers that becomes normal deviates at once.
constexpr int chunk_blocks = 256, chunk_values = 2 * chunk_blocks;

/// Computes out[i], the normal deviate of uniform[i]; both need space for a whole register after `count`. One value in
/// seven is in a tail, whose logarithm and square root cost more than everything else. Tail values are gathered, so
/// that few lanes are idle.
template <class V>
void to_normals(const double* uniform, int count, double* out) {
  int tails[chunk_values + V::width] = {}, found = 0;
  for (int i = 0; i < count; i += V::width) V::store(out + i, central_normal_lanes<V>(V::load(uniform + i)));
  for (int i = 0; i < count; ++i) {
    tails[found] = i;
    found += One::abs(uniform[i] - 0.5) > central_half ? 1 : 0;
  }
  for (int first = 0; first < found; first += V::width) {
    double values[V::width];
    for (int lane = 0; lane < V::width; ++lane) values[lane] = uniform[tails[first + lane]];
    V::store(values, tail_normal_lanes<V>(V::load(values)));
    const int here = found - first < V::width ? found - first : V::width;
    for (int lane = 0; lane < here; ++lane) out[tails[first + lane]] = values[lane];
  }
}

template <class V>
void normals(const NormalsRequest& request, std::int64_t blocks, double* out) {
  using I = typename V::I;
  static_assert(chunk_blocks % V::width == 0);
  double counting[V::width], uniform[chunk_values], values[chunk_values];
  for (int lane = 0; lane < V::width; ++lane) counting[lane] = __builtin_bit_cast(double, std::int64_t{lane});
  const I lane_numbers = V::bits(V::load(counting)), low = V::set_bits(0xffffffff);
  for (std::int64_t done = 0; done < blocks; done += chunk_blocks) {
    const int here = static_cast<int>(blocks - done < chunk_blocks ? blocks - done : chunk_blocks);
    for (int block = 0; block < here; block += V::width) {
      const I number = lane_numbers + V::set_bits(static_cast<std::int64_t>(request.first_block) + done + block);
      // The stream occupies 8 bits, which leaves 56 for the block's number.
      const I words3 = V::set_bits(request.stream) | (((number >> 32) & low) << 8);
      const PhiloxWords<V> words =
          philox_lanes<V>({{number & low, V::set_bits(static_cast<std::int64_t>(request.item & 0xffffffff)),
                            V::set_bits(static_cast<std::int64_t>(request.item >> 32)), words3}},
                          request.key[0], request.key[1]);
      V::store_pairs(uniform + std::ptrdiff_t{2} * block, to_unit_interval<V>(words.word[0] | (words.word[1] << 32)),
                     to_unit_interval<V>(words.word[2] | (words.word[3] << 32)));
    }
    to_normals<V>(uniform, 2 * here, values);
    __builtin_memcpy(out + 2 * done, values, sizeof(double) * 2 * static_cast<std::size_t>(here));
  }
}

template <class V>
constexpr RandomKernels random_table{normals<V>};

}  // namespace
}  // namespace decid
