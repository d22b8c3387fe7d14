// Ranges of samples.
#include "base/sample_range.hpp"

#include "tests/helpers.hpp"

using namespace decid;

TEST_CASE("joined_ranges: ascending, joined where they touch, overlap or contain another") {
  using Ranges = std::vector<SampleRange>;
  CHECK(joined_ranges({{8, 9}, {1, 3}, {3, 4}, {2, 3}}) == Ranges{{1, 4}, {8, 9}});
  CHECK(joined_ranges({{5, 6}, {0, 10}, {9, 12}}) == Ranges{{0, 12}});
  CHECK(joined_ranges({}).empty());
}

TEST_CASE("bridge: a line between neighbours, the nearest value at an end, 0 without any other value") {
  const auto bridged = [](std::vector<float> values, SampleRange range) {
    bridge(values, range);
    return values;
  };
  CHECK(bridged({1, 9, 9, 9, 5}, {1, 4}) == std::vector<float>{1, 2, 3, 4, 5});
  CHECK(bridged({9, 9, 3, 4}, {0, 2}) == std::vector<float>{3, 3, 3, 4});
  CHECK(bridged({3, 4, 9}, {2, 3}) == std::vector<float>{3, 4, 4});
  CHECK(bridged({9, 9}, {0, 2}) == std::vector<float>{0, 0});
  std::vector<double> in_double{1, 9, 2};
  bridge(in_double, {1, 2});
  CHECK(in_double == std::vector<double>{1, 1.5, 2});
}
