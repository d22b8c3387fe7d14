// Leave-one-out cross-validation against the exact one: means of groups of normal values, of which all is known.
#include "posterior/sampling/leave_one_out.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/math/random.hpp"
#include "posterior/streams.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

namespace {

double log_normal(double x, double mean, double variance) {
  return -0.5 * (std::log(2.0 * 3.14159265358979323846 * variance) + (x - mean) * (x - mean) / variance);
}

/// `groups` of `each` values about means of their own, variance 1, flat prior: the mean's posterior is N(mean, 1/each).
struct Groups {
  int groups, each;
  std::vector<double> values, means;

  Groups(int groups_, int each_, double outlier = 0.0) : groups(groups_), each(each_) {
    const Random random(1, sim::streams::base_parameters, static_cast<std::uint64_t>(each));
    for (int i = 0; i < groups * each; ++i) values.push_back(random.normal(static_cast<std::uint64_t>(i)));
    values[0] += outlier;
    for (int g = 0; g < groups; ++g) {
      double sum = 0.0;
      for (int i = 0; i < each; ++i) sum += values[static_cast<std::size_t>(g * each + i)];
      means.push_back(sum / each);
    }
  }

  std::vector<double> log_likelihood(int draws) const {
    std::vector<double> result;
    for (int draw = 0; draw < draws; ++draw) {
      const Random random(2, posterior::streams::chains, static_cast<std::uint64_t>(draw));
      for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t g = i / static_cast<std::size_t>(each);
        result.push_back(log_normal(values[i], means[g] + random.normal(g) / std::sqrt(double(each)), 1.0));
      }
    }
    return result;
  }

  struct Exact {
    double left_out, seen;
  };
  Exact exact() const {
    Exact sum{0.0, 0.0};
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double mean = means[i / static_cast<std::size_t>(each)];
      const double others = (mean * each - values[i]) / (each - 1);
      sum.left_out += log_normal(values[i], others, 1.0 + 1.0 / (each - 1));
      sum.seen += log_normal(values[i], mean, 1.0 + 1.0 / each);
    }
    return sum;
  }
};

}  // namespace

// The tolerance: 2000 draws leave 0.02 of a value's logarithm to chance, and the draws of a group are shared by its
// values: 0.02 sqrt(200 * 5) in all.
TEST_CASE("leave_one_out: the exact density, and as many parameters as there are") {
  const Groups data(40, 5);
  const LeaveOneOut found = leave_one_out(data.log_likelihood(2000), 200);
  REQUIRE(found.shapes.size() == 200);
  CHECK(*std::ranges::max_element(found.shapes) == found.max_shape);
  CHECK(std::ranges::count_if(found.shapes, [&](double shape) { return shape > found.max_reliable_shape; }) ==
        found.unreliable);
  CHECK(near(found.max_reliable_shape, 1.0 - 1.0 / std::log10(2000.0), 1e-12));
  const auto [left_out, seen] = data.exact();
  CHECK(within(found.log_density, left_out, 0.65));
  CHECK(within(found.effective_parameters, seen - left_out, 0.65));
  CHECK(seen - left_out > 30.0);  // of 40 means
  CHECK(found.unreliable == 0);
  CHECK(found.max_shape < 0.7);
  // Each is about -1.5 with a deviation of 0.8.
  CHECK((found.standard_error > 9.0 && found.standard_error < 14.0));
}

// A posterior keeps 130 to 256 whole draws: chance errors are 0.06 per value and 2 in all.
TEST_CASE("leave_one_out: two hundred draws do") {
  const Groups data(40, 5);
  const LeaveOneOut found = leave_one_out(data.log_likelihood(200), 200);
  const auto [left_out, seen] = data.exact();
  CHECK(within(found.log_density, left_out, 2.0));
  CHECK(within(found.effective_parameters, seen - left_out, 2.0));
}

TEST_CASE("leave_one_out: values that alone determine a parameter are marked") {
  const LeaveOneOut usual = leave_one_out(Groups(100, 2).log_likelihood(500), 200);
  const LeaveOneOut odd = leave_one_out(Groups(100, 2, 9.0).log_likelihood(500), 200);
  CHECK(odd.max_shape > 0.7);
  CHECK(odd.unreliable > usual.unreliable);
}

// A rejected transition stores its point again: of a pair about the tail's cut one lies in the tail, at 0.
TEST_CASE("leave_one_out: draws that occur twice hide no tail") {
  const std::vector<double> once = Groups(100, 2, 9.0).log_likelihood(500);
  std::vector<double> twice;
  for (std::size_t draw = 0; draw < 500; ++draw)
    for (int copy = 0; copy < 2; ++copy)
      twice.insert(twice.end(), once.begin() + static_cast<std::ptrdiff_t>(draw * 200),
                   once.begin() + static_cast<std::ptrdiff_t>((draw + 1) * 200));
  CHECK(leave_one_out(twice, 200).max_shape > 0.7);
}

// The weights of the first value grow by e^3 from draw to draw: the last draw has 95% of the sum, and most of the tail
// less than 1e-12 of it. The weights of the second value grow by 10% in all.
TEST_CASE("leave_one_out: a value whose weights are a single draw's is marked") {
  constexpr int draws = 100;
  std::vector<double> values;
  for (int draw = 0; draw < draws; ++draw) {
    values.push_back(-3.0 * draw);
    values.push_back(-0.001 * draw);
  }
  const LeaveOneOut found = leave_one_out(values, 2);
  REQUIRE(found.shapes.size() == 2);
  CHECK(found.shapes[0] == std::numeric_limits<double>::infinity());
  CHECK(found.shapes[1] < found.max_reliable_shape);
  CHECK(found.max_shape == found.shapes[0]);
  CHECK(found.unreliable == 1);
}

TEST_CASE("leave_one_out: weights that differ by rounding have no tail, and are not marked") {
  std::vector<double> values;
  for (int draw = 0; draw < 100; ++draw) {
    values.push_back(draw < 90 ? -1.0 : -1.0 - 1e-9);  // ten larger weights, ties at the tail's begin
    values.push_back(-2.0);
  }
  const LeaveOneOut found = leave_one_out(values, 2);
  CHECK(found.shapes == std::vector{0.0, 0.0});
  CHECK(found.unreliable == 0);
}

TEST_CASE("leave_one_out: draws that say the same need no weights") {
  std::vector<double> same;
  for (int draw = 0; draw < 25; ++draw) same.insert(same.end(), {-1.0, -2.0, -4.0});
  const LeaveOneOut found = leave_one_out(same, 3);
  CHECK(near(found.log_density, -7.0, 1e-14));
  CHECK(within(found.effective_parameters, 0.0, 1e-13));
  CHECK(near(found.standard_error, std::sqrt(7.0), 1e-13));  // deviation sqrt(7 / 3) of three
  CHECK(found.unreliable == 0);
}

TEST_CASE("leave_one_out: invalid input is refused") {
  const std::vector<double> values(75, -1.0);
  check_error([&] { leave_one_out(values, 1); }, Code::size_mismatch, "75 values");
  check_error([&] { leave_one_out(values, 4); }, Code::size_mismatch, "75 values");
  check_error([&] { leave_one_out(std::vector<double>(77, -1.0), 3); }, Code::size_mismatch, "77 values");
  check_error([&] { leave_one_out({}, 0); }, Code::size_mismatch, "0 values");
  std::vector<double> odd = values;
  odd[3] = std::nan("");
  check_error([&] { leave_one_out(odd, 3); }, Code::value_invalid);
}
