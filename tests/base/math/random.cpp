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

TEST_CASE("Random: a number depends only on its index") {
  const Random random(7, Stream::weights, 3);
  std::vector<double> forward(101), backward(101);
  for (std::size_t i = 0; i < 101; ++i) forward[i] = random.normal(i);
  for (std::size_t i = 101; i-- > 0;) backward[i] = Random(7, Stream::weights, 3).normal(i);
  CHECK(forward == backward);
  // Blocks hold two numbers: every parity of the first index and of the count.
  for (const std::size_t first : {0u, 1u, 2u, 5u}) {
    for (const std::size_t count : {0u, 1u, 2u, 3u, 40u, 41u}) {
      std::vector<double> filled(count);
      random.fill_normal(filled, first);
      CHECK(std::equal(filled.begin(), filled.end(), forward.begin() + static_cast<std::ptrdiff_t>(first)));
    }
  }
}

TEST_CASE("Random: seeds, streams, items and indices have different numbers") {
  std::vector<std::uint64_t> seen;
  for (const std::uint64_t seed : {1ull, 2ull, 1ull << 32, 1ull << 63}) {
    for (const Stream stream : {Stream{1}, Stream{2}, Stream::shuffle}) {
      for (const std::uint64_t item : {0ull, 1ull, 1ull << 32, 1ull << 63}) {
        for (std::uint64_t index = 0; index < 8; ++index) seen.push_back(Random(seed, stream, item).bits(index));
      }
    }
  }
  const std::size_t count = seen.size();
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  CHECK(seen.size() == count);
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

TEST_CASE("inverse_normal: known quantiles") {
  // Expected values come from 40-digit arithmetic on the doubles written here.
  CHECK(inverse_normal(0.5) == 0.0);
  struct Known {
    double p, quantile;
  };
  for (const Known& known : {Known{0.501, 0.002506630899571766231698791}, Known{0.75, 0.674489750196081743202227},
                             Known{0.925, 1.43953147093845622906332}, Known{0.975, 1.959963984540053855604431},
                             Known{0.0749999, -1.439532177375900586417472}, Known{0.9999, 3.719016485455708386722759},
                             Known{0.01, -2.326347874040841093075096}, Known{1e-10, -6.361340902404056199100397},
                             Known{1e-12, -7.034483825301131932614176}, Known{0x1p-53, -8.209536151601386855630769},
                             Known{1.0 - 0x1p-53, 8.209536151601386855630769}}) {
    CAPTURE(known.p);
    CHECK(std::abs(inverse_normal(known.p) / known.quantile - 1.0) < 1e-15);
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
}

TEST_CASE("Random: normal numbers have the moments and tails of the normal distribution") {
  constexpr int count = 1'000'000;
  std::vector<double> values(count);
  Random(3, Stream{3}, 9).fill_normal(values);
  double moment[5]{};
  int beyond[5]{};
  for (const double x : values) {
    double power = 1.0;
    for (int k = 1; k <= 4; ++k) moment[k] += (power *= x) / count;
    for (int k = 1; k <= 4; ++k) beyond[k] += std::abs(x) > k;
  }
  // The k-th sample moment has the variance (E x^2k - (E x^k)^2) / count: 1, 2, 15, 96.
  const double root = std::sqrt(1.0 / count);
  CHECK(std::abs(moment[1]) < 4.0 * root);
  CHECK(std::abs(moment[2] - 1.0) < 4.0 * root * std::sqrt(2.0));
  CHECK(std::abs(moment[3]) < 4.0 * root * std::sqrt(15.0));
  CHECK(std::abs(moment[4] - 3.0) < 4.0 * root * std::sqrt(96.0));
  for (int k = 1; k <= 4; ++k) {
    const double probability = std::erfc(k / std::sqrt(2.0));
    CHECK(std::abs(beyond[k] - count * probability) < 4.0 * std::sqrt(count * probability));
  }
  double neighbours = 0.0;
  for (std::size_t i = 1; i < values.size(); ++i) neighbours += values[i] * values[i - 1] / count;
  CHECK(std::abs(neighbours) < 4.0 * root);
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
