// Shared code of all generic kernels: splitting a range evenly into tiles, and the tree that sums the 16 lanes of a
// block.
#pragma once

#include <type_traits>
#include <utility>

#include "nn/kernels/kernels.hpp"

namespace decid::nn {
namespace {

constexpr int smaller(int a, int b) {
  return a < b ? a : b;
}
constexpr int larger(int a, int b) {
  return a > b ? a : b;
}
constexpr int ceil_div(int a, int b) {
  return (a + b - 1) / b;
}

/// Calls f(begin, end) for as few parts of at most `size` as cover [0, count), as even as possible: 13 columns in tiles
/// of at most 6 are 4 + 4 + 5, where 6 + 6 + 1 would leave the last tile waiting for its single chains.
template <class F>
[[gnu::always_inline]] inline void for_each_part(int count, int size, const F& f) {
  const int parts = ceil_div(count, size);
  for (int k = 0, begin = 0; k < parts; ++k) {
    const int end = begin + (count - begin) / (parts - k);
    f(begin, end);
    begin = end;
  }
}

template <int... I, class F>
[[gnu::always_inline]] inline void call_each(std::integer_sequence<int, I...>, const F& f) {
  (f(std::integral_constant<int, I>{}), ...);
}

/// Calls f(0), ..., f(N - 1) with constants: arrays of registers indexed by them never exist in memory. From plain
/// loops g++ 12 keeps a copy of all accumulators on the stack around the inner loop, 13% of the time of an 18-tap tile.
template <int N, class F>
[[gnu::always_inline]] inline void unroll(const F& f) {
  call_each(std::make_integer_sequence<int, N>{}, f);
}

/// Returns x in a register and hides its value from the compiler: from pointers that move together g++ 12 makes more
/// than there are registers, and loads them from the stack at each use.
template <class T>
[[gnu::always_inline]] inline T in_register(T x) {
  asm("" : "+r"(x));
  return x;
}

/// Four values side by side, in the compiler's own vector type: the same code for SSE2 and NEON.
using Quad = float __attribute__((vector_size(16)));

[[gnu::always_inline]] inline Quad load_quad(const float* p) {
  Quad q;
  __builtin_memcpy(&q, p, sizeof q);
  return q;
}

/// The first two steps of the lane tree, l + (l + 8) and l + (l + 4).
[[gnu::always_inline]] inline Quad fold_lanes(const float* v) {
  return (load_quad(v) + load_quad(v + 8)) + (load_quad(v + 4) + load_quad(v + 12));
}

/// result[k] = lane tree of the 16 lanes at v + 16 k, for four k at once: after a transposition the last two steps,
/// + 2 and + 1, are sums of whole registers.
[[gnu::always_inline]] inline void lane_trees_of_four(const float* v, float* result) {
  const Quad a = fold_lanes(v), b = fold_lanes(v + lanes), c = fold_lanes(v + 2 * lanes), d = fold_lanes(v + 3 * lanes);
  const Quad ab_low = __builtin_shufflevector(a, b, 0, 4, 1, 5), ab_high = __builtin_shufflevector(a, b, 2, 6, 3, 7);
  const Quad cd_low = __builtin_shufflevector(c, d, 0, 4, 1, 5), cd_high = __builtin_shufflevector(c, d, 2, 6, 3, 7);
  const Quad lane0_and_2 =
      __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5) + __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5);
  const Quad lane1_and_3 =
      __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7) + __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7);
  const Quad sum = lane0_and_2 + lane1_and_3;
  __builtin_memcpy(result, &sum, sizeof sum);
}

/// Eight values side by side.
using Oct = float __attribute__((vector_size(32)));

// A template, so that only instruction sets with such registers compile it.
template <class V>
[[gnu::always_inline]] inline Oct load_oct(const float* p) {
  Oct o;
  __builtin_memcpy(&o, p, sizeof o);
  return o;
}

/// The same for eight k at once, in registers of eight: the first step, + 8, needs no shuffle. at(k, half): lanes
/// 8 half to 8 half + 7 of value k.
template <class V, class F>
[[gnu::always_inline]] inline void lane_trees_of_eight(const F& at, float* result) {
  Oct eight[8];
  unroll<8>([&](auto k) { eight[k] = at(k, 0) + at(k, 1); });
  Oct four[4], two[2];
  unroll<4>([&](auto k) {
    const Oct a = eight[k], b = eight[k + 4];
    four[k] = __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11) +
              __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
  });
  // Each half of a register is as lane_trees_of_four would have it: k below 4 left, the others right.
  unroll<2>([&](auto k) {
    const Oct a = four[2 * k], b = four[2 * k + 1];
    two[k] = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13) +
             __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
  });
  const Oct sum = __builtin_shufflevector(two[0], two[1], 0, 2, 8, 10, 4, 6, 12, 14) +
                  __builtin_shufflevector(two[0], two[1], 1, 3, 9, 11, 5, 7, 13, 15);
  __builtin_memcpy(result, &sum, sizeof sum);
}

template <class T>
T lane_tree(T* v) {
  for (int half = lanes / 2; half > 0; half /= 2)
    for (int l = 0; l < half; ++l) v[l] += v[l + half];
  return v[0];
}

/// Lane trees of `count` values; destroys v when some lanes hold no sample.
template <class V>
void lane_trees(float* v, int count, int valid, float* result) {
  for (int k = 0; valid < lanes && k < count; ++k)
    for (int l = valid; l < lanes; ++l) v[k * lanes + l] = 0;
  int k = 0;
  if constexpr (V::width >= 8)
    for (; k + 8 <= count; k += 8)
      lane_trees_of_eight<V>([&](int i, int half) { return load_oct<V>(v + (k + i) * lanes + 8 * half); }, result + k);
  for (; k + 4 <= count; k += 4) lane_trees_of_four(v + k * lanes, result + k);
  for (; k < count; ++k) result[k] = lane_tree(v + k * lanes);
}

}  // namespace
}  // namespace decid::nn
