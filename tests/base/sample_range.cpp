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
