// CMA-ES finds the minima of functions that are known, within bounds too, and repeats itself.
#include "tools/compare/cmaes.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "base/error.hpp"
#include "tests/near.hpp"

namespace decid::iterative {
namespace {

using test::within;

using Function = std::function<double(std::span<const double>)>;

struct Minimum {
  CmaEs search;
  std::vector<double> best{};
  double best_value = std::numeric_limits<double>::infinity();
};

Minimum minimise(const Function& function, const std::vector<double>& start, int generations) {
  Minimum found{CmaEs(start, 0.3, 0, 1, 0)};
  const auto n = start.size();
  for (int g = 0; g < generations; ++g) {
    const std::vector<double>& points = found.search.ask();
    std::vector<double> values(points.size() / n);
    for (std::size_t k = 0; k < values.size(); ++k) {
      const std::span point = std::span(points).subspan(k * n, n);
      values[k] = function(point);
      if (values[k] >= found.best_value) continue;
      found.best_value = values[k];
      found.best.assign(point.begin(), point.end());
    }
    found.search.tell(values);
  }
  return found;
}

double square(double x) {
  return x * x;
}

}  // namespace

TEST_CASE("cma-es: the centre moves to the better half, by the tutorial's weights") {
  CmaEs search(std::vector<double>{0.5, 0.5}, 0.01, 6, 1, 0);
  const std::vector<double> points = search.ask();
  search.tell(std::vector<double>{5, 1, 4, 2, 3, 6});
  // (ln 3.5 - ln i) over their sum, i = 1, 2, 3.
  const double weights[3] = {0.637042571241217, 0.284570257438033, 0.078387171320750};
  for (std::size_t i = 0; i < 2; ++i)
    CHECK(within(search.mean()[i], weights[0] * points[2 + i] + weights[1] * points[6 + i] + weights[2] * points[8 + i],
                 1e-12));
}

TEST_CASE("cma-es: sphere, ellipsoid and Rosenbrock's valley, inside the box") {
  const Function sphere = [](auto x) {
    double sum = 0;
    for (const double v : x) sum += square(v - 0.3);
    return sum;
  };
  // In 7 dimensions CMA-ES gains a decade of the value in about 20 generations: 300 are 15 decades.
  const Minimum found = minimise(sphere, std::vector<double>(7, 0.5), 300);
  CHECK(found.best_value < 1e-14);
  for (const double x : found.search.mean()) CHECK(within(x, 0.3, 1e-7));  // the root of that
  CHECK(found.search.longest_axis() < 1e-4);

  const Function ellipsoid = [](auto x) {
    double sum = 0;
    for (std::size_t i = 0; i < x.size(); ++i) sum += std::pow(10.0, static_cast<double>(i)) * square(x[i] - 0.6);
    return sum;
  };
  CHECK(minimise(ellipsoid, std::vector<double>(7, 0.5), 600).best_value < 1e-12);

  // [-2, 2] in the box; the minimum, 0, is at (1, 1, 1, 1), that is 3/4.
  const Function rosenbrock = [](auto x) {
    double sum = 0;
    for (std::size_t i = 0; i + 1 < x.size(); ++i) {
      const double a = 4 * x[i] - 2, b = 4 * x[i + 1] - 2;
      sum += 100 * square(b - a * a) + square(1 - a);
    }
    return sum;
  };
  const Minimum valley = minimise(rosenbrock, {0.4, 0.4, 0.4, 0.4}, 700);
  CHECK(valley.best_value < 1e-10);
  // The flattest curvature there is above 0.1, and 4 units are the box: 1/4 sqrt(2e-10 / 0.1) = 1.1e-5.
  for (const double x : valley.best) CHECK(within(x, 0.75, 1.2e-5));
}

TEST_CASE("cma-es: a minimum at an edge and in a corner") {
  const Function edge = [](auto x) { return x[0] + square(x[1] - 0.5) + square(x[2] - 0.25); };
  const Minimum found = minimise(edge, {0.7, 0.2, 0.9}, 200);
  CHECK(found.best[0] >= 0);
  CHECK(found.best[0] < 1e-6);
  CHECK(within(found.best[1], 0.5, 1e-3));
  const Function corner = [](auto x) { return -x[0] - 2 * x[1] + x[2]; };
  const std::vector<double> best = minimise(corner, {0.5, 0.5, 0.5}, 200).best;
  CHECK(within(best[0], 1, 1e-6));
  CHECK(within(best[1], 1, 1e-6));
  CHECK(best[2] < 1e-6);
}

TEST_CASE("cma-es: every point is in the box, the seed decides, NaN is worst") {
  CmaEs search(std::vector<double>{0.0, 1.0}, 2.0, 10, 3, 0);
  for (int g = 0; g < 5; ++g) {
    for (const double x : search.ask()) CHECK((x >= 0 && x <= 1));
    search.tell(std::vector<double>(10, std::numeric_limits<double>::quiet_NaN()));
  }
  const std::vector<double> start{0.5, 0.5};
  CHECK(CmaEs(start, 0.1, 8, 1, 0).ask() == CmaEs(start, 0.1, 8, 1, 0).ask());
  CHECK(CmaEs(start, 0.1, 8, 1, 0).ask() != CmaEs(start, 0.1, 8, 2, 0).ask());
  CHECK(CmaEs(start, 0.1, 8, 1, 0).ask() != CmaEs(start, 0.1, 8, 1, 1).ask());
  CHECK(mirrored(1.25) == 0.75);
  CHECK(mirrored(-0.25) == 0.25);
  CHECK(mirrored(2.25) == 0.25);
}

TEST_CASE("cma-es: invalid searches") {
  const std::vector<double> start{0.5};
  CHECK_THROWS_AS(CmaEs({}, 0.1, 0, 1, 0), Error);
  CHECK_THROWS_AS(CmaEs(std::vector<double>{1.5}, 0.1, 0, 1, 0), Error);
  CHECK_THROWS_AS(CmaEs(start, 0, 0, 1, 0), Error);
  CHECK_THROWS_AS(CmaEs(start, 0.1, 3, 1, 0), Error);
  CmaEs search(start, 0.1, 4, 1, 0);
  CHECK_THROWS_AS(search.tell(std::vector<double>(4)), Error);  // not asked for
  search.ask();
  CHECK_THROWS_AS(search.tell(std::vector<double>(3)), Error);
}

}  // namespace decid::iterative
