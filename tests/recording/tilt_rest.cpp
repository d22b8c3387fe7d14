// The platform's rests at both ends of a measured tilt.
#include "recording/detail/tilt/tilt_rest.hpp"

#include <cmath>
#include <vector>

#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::recording;

namespace {

std::vector<double> sine_between(std::size_t before, std::size_t moving, std::size_t after) {
  std::vector<double> tilt(before, 0.3);
  for (std::size_t k = 0; k < moving; ++k) tilt.push_back(0.3 + std::sin(0.1 * static_cast<double>(k)));
  tilt.resize(before + moving + after, tilt.back());
  return tilt;
}

}  // namespace

TEST_CASE("the moving samples of a tilt lie between its rests") {
  const SampleRange moving = moving_samples(sine_between(500, 300, 800));
  CHECK(moving.first >= 500);
  CHECK(moving.first < 505);  // sin(0.1 * 3) exceeds a tenth of the range
  CHECK(moving.end > 790);
  CHECK(moving.end <= 800);
  const SampleRange whole = moving_samples(sine_between(0, 300, 0));
  CHECK(whole.first < 5);
  CHECK(whole.end > 290);
  CHECK(moving_samples(std::vector<double>(100, 0.3)).size() == 0);
  CHECK(moving_samples({}).size() == 0);
}
