#include "posterior/frf/optimum.hpp"

#include <limits>

#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::test;

namespace {

/// Half the squares of r = {x - 0.3, 10 (y - x^2)} and, in the third coordinate, of z - 1.
void valley(std::span<const double> x, frf::Local& local) {
  const double first = x[0] - 0.3, second = 10.0 * (x[1] - x[0] * x[0]), third = x[2] - 1.0;
  local.misfit = 0.5 * (first * first + second * second + third * third);
  local.gradient = {first - 20.0 * x[0] * second, 10.0 * second, third};
  local.information = {1.0 + 400.0 * x[0] * x[0], -200.0 * x[0], 100.0, 0.0, 0.0, 1.0};
}

}  // namespace

TEST_CASE("the least misfit is found, with half the squares of normal coordinates") {
  const frf::Optimum found = frf::minimise(3, 2, valley, {});
  CHECK(near(found.x[0], 0.3, 1e-6));
  CHECK(near(found.x[1], 0.09, 1e-6));
  CHECK(near(found.x[2], 0.5, 1e-6));
  CHECK(near(found.misfit, 0.25, 1e-9));
  CHECK(found.agreeing == 24);
}

TEST_CASE("uniform coordinates stay in their bounds") {
  const auto outside = [](std::span<const double> x, frf::Local& local) {
    const double first = x[0] + 0.5, second = x[1] - 2.0, both = x[0] + x[1] - 0.5;
    local.misfit = 0.5 * (first * first + second * second + both * both);
    local.gradient = {first + both, second + both};
    local.information = {2.0, 1.0, 2.0};
  };
  const frf::Optimum found = frf::minimise(2, 2, outside, {});
  CHECK(found.x[0] == 0.0);
  CHECK(found.x[1] == 1.0);
  CHECK(near(found.misfit, 0.5 * (0.25 + 1.0 + 0.25), 1e-12));
}

TEST_CASE("of several least misfits the smallest is returned, and how many starts found it") {
  const auto two = [](std::span<const double> x, frf::Local& local) {
    const double at = x[0] < 0.7 ? 0.3 : 0.9, off = x[0] - at;
    local.misfit = 0.5 * off * off + (x[0] < 0.7 ? 0.1 : 0.0);
    local.gradient = {off};
    local.information = {1.0};
  };
  const frf::Optimum found = frf::minimise(1, 1, two, {});
  CHECK(near(found.x[0], 0.9, 1e-6));
  CHECK(found.agreeing > 2);
  CHECK(found.agreeing < 16);
}

TEST_CASE("optimum: errors") {
  check_error([] { frf::minimise(3, 2, valley, {.starts = 0}); }, Code::setting_out_of_range, "0 starts");
  check_error([] { frf::minimise(3, 2, valley, {.max_steps = 0}); }, Code::setting_out_of_range, "0 steps");
  const auto never = [](std::span<const double>, frf::Local& local) {
    local.misfit = std::numeric_limits<double>::infinity();
  };
  check_error([&] { frf::minimise(1, 1, never, {}); }, Code::setting_out_of_range, "optimum");
}
