// Tests of base/math/random.hpp: known answers, addressing, and the shape of the distributions.
// Everything is a fixed function of the seed, so a statistical test either always passes or always fails; bounds are
// multiples of the statistic's own standard error.
#include "base/math/random.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

using decid::inverse_normal;
using decid::Random;
using decid::Stream;

TEST_CASE("philox4x32: known answers of Random123") {
  using Words = std::array<std::uint32_t, 4>;
  CHECK(decid::philox4x32({0, 0, 0, 0}, {0, 0}) == Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
  CHECK(decid::philox4x32({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}) ==
        Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  CHECK(decid::philox4x32({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}) ==
        Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

TEST_CASE("Random: numbers are where the layout of counter and key says") {
  const Random random(0x0123456789abcdef, Stream{5}, 0xfedcba9876543210);
  for (const std::uint64_t block : {0ull, 1ull, 12345ull, (1ull << 32) + 7, (1ull << 56) - 1}) {
    const auto low = static_cast<std::uint32_t>(block), high = static_cast<std::uint32_t>(block >> 32);
    const auto words = decid::philox4x32({low, 0x76543210, 0xfedcba98, 5 | high << 8}, {0x89abcdef, 0x01234567});
    CHECK(random.bits(2 * block) == (words[0] | std::uint64_t{words[1]} << 32));
    CHECK(random.bits(2 * block + 1) == (words[2] | std::uint64_t{words[3]} << 32));
  }
}

TEST_CASE("Random: uniform numbers") {
  const Random random(11, Stream{1}, 0);
  constexpr int count = 400'000, cells = 64;
  std::vector<int> histogram(cells);
  double sum = 0.0, lowest = 1.0, highest = 0.0;
  bool on_grid = true;
  for (int i = 0; i < count; ++i) {
    const double u = random.uniform(static_cast<std::uint64_t>(i));
    const double cell = u * 0x1p52 - 0.5;
    on_grid = on_grid && cell == std::floor(cell);
    ++histogram[static_cast<std::size_t>(u * cells)];
    sum += u;
    lowest = std::min(lowest, u);
    highest = std::max(highest, u);
  }
  CHECK(on_grid);
  CHECK(lowest > 0.0);
  CHECK(highest < 1.0);
  CHECK(std::abs(sum / count - 0.5) < 4.0 * std::sqrt(1.0 / 12 / count));
  double chi_square = 0.0;
  constexpr double expected = static_cast<double>(count) / cells;
  for (const int n : histogram) chi_square += (n - expected) * (n - expected) / expected;
  CHECK(std::abs(chi_square - (cells - 1)) < 4.0 * std::sqrt(2.0 * (cells - 1)));
  CHECK(random.uniform(5, -3.0, 7.0) == -3.0 + 10.0 * random.uniform(5));
  CHECK(random.normal(5) == inverse_normal(random.uniform(5)));
}

TEST_CASE("Random: integers below a bound") {
  __extension__ using Wide = unsigned __int128;
  const Random random(5, Stream::shuffle, 2);
  for (const std::uint64_t bound : {1ull, 2ull, 3ull, 12766ull, (1ull << 32) - 1, (1ull << 32) + 1, ~0ull}) {
    for (std::uint64_t index = 0; index < 1000; ++index) {
      const auto exact = static_cast<std::uint64_t>(Wide{random.bits(index)} * bound >> 64);
      REQUIRE(random.below(index, bound) == exact);
    }
  }
}

TEST_CASE("inverse_normal: inverts the distribution function") {
  // One Newton step from x, in long double, shows how far x is from the quantile.
  const auto relative_error = [](double p) {
    const auto x = static_cast<long double>(inverse_normal(p));
    const long double root_half = std::sqrt(0.5L);
    long double excess;  // distribution function of x, minus p
    if (std::abs(p - 0.5) < 0.25) {
      excess = 0.5L * std::erf(x * root_half) - (static_cast<long double>(p) - 0.5L);
    } else if (p < 0.5) {
      excess = 0.5L * std::erfc(-x * root_half) - static_cast<long double>(p);
    } else {
      excess = (1.0L - static_cast<long double>(p)) - 0.5L * std::erfc(x * root_half);
    }
    const long double density = std::exp(-0.5L * x * x) / std::sqrt(2.0L * 3.14159265358979323846264338327950288L);
    return static_cast<double>(std::abs(excess / density / x));
  };
  double worst = 0.0;
  for (int i = 1; i < 100'000; ++i) {
    if (i != 50'000) worst = std::max(worst, relative_error(i * 1e-5));
  }
  for (double p = 0.1; p > 0x1p-53; p *= 0.99) worst = std::max({worst, relative_error(p), relative_error(1.0 - p)});
  for (double q = 0.4; q > 1e-12; q *= 0.9) worst = std::max(worst, relative_error(0.5 + q));
  CHECK(worst < 1e-15);
  CHECK(inverse_normal(0.3) == -inverse_normal(1.0 - 0.3));
  CHECK(inverse_normal(0.5) == 0.0);
}

TEST_CASE("Random::fill_normal: the numbers of normal(), with every instruction set") {
  const Random random(5, Stream{5}, 0x1234567890ULL);
  for (const decid::Isa isa : decid::available_isas()) {
    CAPTURE(name(isa));
    // Odd starts, odd lengths, blocks whose number has more than 32 bits.
    for (const std::uint64_t first : {0ULL, 1ULL, 17ULL, (1ULL << 33) - 5}) {
      for (const std::size_t count : {0u, 1u, 2u, 15u, 33u, 20'000u}) {
        std::vector<double> values(count);
        random.fill_normal(values, first, isa);
        bool equal = true;
        for (std::size_t i = 0; i < count; ++i) equal = equal && values[i] == random.normal(first + i);
        CHECK(equal);
      }
    }
  }
}
