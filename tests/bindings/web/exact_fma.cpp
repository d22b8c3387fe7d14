// Tests of base/math/exact_fma.hpp: the C library's bits, in both lanes.
#include "base/math/exact_fma.hpp"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>

using namespace decid;

namespace {

/// Any bits at all, or a number of everyday size, by `kind`.
double some_double(std::uint64_t bits, int kind) {
  const std::uint64_t mantissa = bits & 0x800fffffffffffff;
  if (kind == 0) return std::bit_cast<double>(bits);
  if (kind == 1) return std::bit_cast<double>(mantissa | std::uint64_t{1000 + (bits >> 52 & 31)} << 52);
  if (kind == 2) return std::bit_cast<double>((bits & 0x8000000000000000) | std::uint64_t{1023 + (bits & 3)} << 52);
  return (bits & 1) != 0 ? 0.0 : -0.0;
}

bool same(double a, double b) {
  return std::isnan(a) ? std::isnan(b) : std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// SplitMix64.
std::uint64_t next(std::uint64_t& state) {
  std::uint64_t z = state += 0x9e3779b97f4a7c15U;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31);
}

}  // namespace

TEST_CASE("exact fused multiply-add: any operands, halfway cases, cancellation" * doctest::test_suite("golden")) {
  std::uint64_t state = 1;
  int wrong = 0, unfused = 0;
  for (int i = 0; i < 2'000'000; ++i) {
    double a[2], b[2], c[2];
    for (int l = 0; l < 2; ++l) {
      const auto kinds = static_cast<int>(next(state) % 64);
      a[l] = some_double(next(state), kinds % 4 == 3 ? 1 : kinds % 4);
      b[l] = some_double(next(state), kinds / 4 % 4 == 3 ? 1 : kinds / 4 % 4);
      c[l] = some_double(next(state), kinds / 16);
      // The product's negative, rounded: what is left is its error. Or half of a last place from a tie.
      if (i % 3 == 0) c[l] = -(a[l] * b[l]);
      if (i % 3 == 1) c[l] = std::ldexp(a[l] * b[l], 53 - static_cast<int>(next(state) % 3));
    }
    const ExactLanes found = exact_fma(ExactLanes{a[0], a[1]}, ExactLanes{b[0], b[1]}, ExactLanes{c[0], c[1]});
    for (int l = 0; l < 2; ++l) {
      const double expected = slow_fma(a[l], b[l], c[l]);
      wrong += same(found[l], expected) && same(std::fma(a[l], b[l], c[l]), expected) ? 0 : 1;
      unfused += same(a[l] * b[l] + c[l], expected) ? 0 : 1;
    }
  }
  CHECK(wrong == 0);
  CHECK(unfused > 500'000);  // of four million: it does matter
}
