// Tests of base/batches.hpp: batches of every number of samples, and orders of epochs.
#include "base/batches.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>

#include "base/error.hpp"

using decid::EpochBatches;
using decid::Error;

TEST_CASE("the batches of an epoch: as few as the largest allows, of sizes that differ by 1 at most") {
  for (int samples = 1; samples <= 70; ++samples)
    for (int largest = 1; largest <= 72; ++largest) {
      const EpochBatches batches(samples, largest);
      CAPTURE(samples);
      CAPTURE(largest);
      REQUIRE(batches.count() == (samples + largest - 1) / largest);
      REQUIRE(batches.first(0) == 0);
      REQUIRE(batches.first(batches.count()) == samples);
      for (int i = 0; i < batches.count(); ++i) {
        REQUIRE(batches.size(i) <= largest);
        REQUIRE((batches.size(i) == batches.min_size() || batches.size(i) == batches.min_size() + 1));
        REQUIRE((i == 0 || batches.size(i) <= batches.size(i - 1)));
        REQUIRE(batches.beginning_at(batches.first(i)) == i);
        if (samples % largest == 0) REQUIRE(batches.size(i) == largest);
      }
    }
  const EpochBatches tail(300, 299);
  CHECK(tail.size(0) == 150);
  CHECK(tail.size(1) == 150);
  for (const int none : {-1, 1, 299, 300}) CHECK_THROWS_AS(tail.beginning_at(none), Error);
  CHECK_THROWS_AS(EpochBatches(0, 1), Error);
  CHECK_THROWS_AS(EpochBatches(5, 0), Error);
  CHECK(EpochBatches(std::numeric_limits<int>::max(), 2).count() == 1 << 30);
}

TEST_CASE("shuffled: each sample once, in another order for each epoch and seed") {
  const std::vector<int> first = decid::shuffled(100, 1, 0);
  for (const std::vector<int>& order : {first, decid::shuffled(100, 1, 1), decid::shuffled(100, 2, 0)}) {
    std::vector<int> sorted = order;
    std::ranges::sort(sorted);
    for (int i = 0; i < 100; ++i) REQUIRE(sorted[static_cast<std::size_t>(i)] == i);
  }
  CHECK(first == decid::shuffled(100, 1, 0));
  CHECK(first != decid::shuffled(100, 1, 1));
  CHECK(first != decid::shuffled(100, 2, 0));
}
