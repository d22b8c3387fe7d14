// Priors of parameters as quantiles of a standard normal coordinate, and what is refused.
#include "posterior/density/priors.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "base/math/random.hpp"
#include "sim/body_model.hpp"
#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon(), infinity = std::numeric_limits<double>::infinity();
const double not_a_number = std::nan("");

/// By libm, of the normal distribution: whichever tail is the smaller one is right to the last digits.
double probability_below(double x) {
  return 0.5 * std::erfc(-x / std::sqrt(2.0));
}
double probability_above(double x) {
  return 0.5 * std::erfc(x / std::sqrt(2.0));
}

constexpr double low = 0.2, high = 1.7;
Quantile quantile(double mean, double sd) {
  const Priors priors{.parameters = {{.name = "a", .normal = ParameterPrior::Normal{mean, sd}}}};
  return make_quantile(priors, "a", low, high - low);
}

/// In the middle, at the ends, beyond them with little probability within, wide and narrow.
std::vector<Quantile> quantiles() {
  return {make_quantile({}, "a", low, high - low),
          quantile(0.9, 0.3),
          quantile(0.2, 0.4),
          quantile(2.0, 0.2),
          quantile(-0.5, 0.3),
          quantile(0.9, 100.0),
          quantile(1.0, 0.001)};
}

const sim::ParameterTable& table() {
  return sim::single_pendulum().parameters;
}
sim::ParameterTable ranges(std::vector<ParameterPrior> parameters) {
  return ranges_for({.parameters = std::move(parameters)}, table());
}

}  // namespace

TEST_CASE("Quantile: as much of the prior lies below the value as of a normal distribution below the coordinate") {
  for (const Quantile& q : quantiles()) {
    for (double x = -6.0; x <= 6.0; x += 0.25) {
      const double value = q.value(x);
      CHECK(value >= low);
      CHECK(value <= high);
      if (q.sd == 0.0) {
        CHECK(within((value - low) / (high - low), probability_below(x), 4.0 * epsilon * high / (high - low)));
        continue;
      }
      const auto z = [&](double at) { return (at - q.mean) / q.sd; };
      // The tail that has the digits.
      const bool upper = q.mean < low;
      const double inside = upper ? probability_above(z(low)) - probability_above(z(high))
                                  : probability_below(z(high)) - probability_below(z(low));
      const double below = upper ? probability_above(z(low)) - probability_above(z(value))
                                 : probability_below(z(value)) - probability_below(z(low));
      // Rounding of a probability near 1 over what lies inside, and of the value over the deviation.
      const double density = std::exp(-0.5 * z(value) * z(value)) / std::sqrt(2.0 * 3.14159265358979323846);
      const double rounding = 1e-13 / inside + 8.0 * epsilon * high / q.sd * density / inside;
      CHECK(within(below / inside, probability_below(x), rounding));
    }
  }
}

TEST_CASE("Quantile: the slope is that of differences") {
  for (const Quantile& q : quantiles()) {
    const double step = 6e-6;
    for (double x = -3.0; x <= 3.0; x += 0.25) {
      const double difference = (q.value(x + step) - q.value(x - step)) / (2.0 * step);
      CHECK(q.slope(x) > 0.0);
      // Above the mean the probability is near 1 and its last digit is seen.
      const double z = q.sd > 0.0 ? (q.value(x) - q.mean) / q.sd : 0.0;
      const double rounding = q.sd * epsilon * std::exp(0.5 * z * z) * 2.5;
      CHECK(within(q.slope(x), difference, 1e-9 * (high - low) + 1e-7 * difference + 4.0 * rounding / step));
    }
  }
}

TEST_CASE("Quantile: far out the value stays in the range and the slope a number") {
  for (const Quantile& q : quantiles()) {
    for (const double x : {-50.0, -20.0, -9.0, 9.0, 20.0, 50.0}) {
      CHECK(q.value(x) >= low);
      CHECK(q.value(x) <= high);
      CHECK(std::isfinite(q.slope(x)));
      CHECK(q.slope(x) >= 0.0);
    }
  }
}

TEST_CASE("Quantile: values in the tails") {
  for (const Quantile& q : quantiles()) {
    if (q.sd == 0.0) continue;
    for (double x = -5.0; x <= 5.0; x += 0.25) {
      CHECK(within(q.value_in_tails(x), q.value(x), 1e-9 * (high - low)));
      const double step = 1e-5;
      const double difference = (q.value_in_tails(x + step) - q.value_in_tails(x - step)) / (2.0 * step);
      CHECK(within(q.slope_in_tails(x), difference, 1e-6 * difference + 1e-8 * (high - low)));
    }
    for (const double x : {-50.0, -20.0, -9.0, 9.0, 20.0, 50.0}) {
      CHECK(q.value_in_tails(x) >= low);
      CHECK(q.value_in_tails(x) <= high);
      CHECK(std::isfinite(q.slope_in_tails(x)));
    }
  }
  const Quantile narrow = quantile(1.0, 0.01);
  for (const double x : {-30.0, -12.0, 12.0, 30.0}) {
    CHECK(near(narrow.value_in_tails(x), 1.0 + 0.01 * x, 1e-12));
    CHECK(near(narrow.slope_in_tails(x), 0.01, 1e-9));
  }
}

TEST_CASE("contradicted_priors: values beyond 5 standard deviations of a normal prior") {
  const std::vector<ParameterPrior> priors{{.name = "Kp", .normal = ParameterPrior::Normal{900.0, 20.0}},
                                           {.name = "Kd", .normal = ParameterPrior::Normal{250.0, 10.0}},
                                           {.name = "delay", .fixed = 0.1}};
  std::vector<double> values(table().size(), 0.0);
  values[sim::Kp] = 900.0 + 99.0;
  values[sim::Kd] = 250.0 - 49.0;
  CHECK(contradicted_priors(priors, table(), values).empty());
  values[sim::Kd] = 250.0 - 51.0;
  CHECK(contradicted_priors(priors, table(), values) == "Kd");
  values[sim::Kp] = 900.0 + 101.0;
  CHECK(contradicted_priors(priors, table(), values) == "Kp, Kd");
}

TEST_CASE("Quantile: the coordinate of a value, at most a hundredth of the probability from the ends") {
  const double end = inverse_normal(0.99);
  for (const Quantile& q : quantiles()) {
    for (double x = -2.25; x <= 2.25; x += 0.125) CHECK(within(q.coordinate(q.value(x)), x, 1e-8));
    for (const double beyond : {q.value(-3.0), low, low - 1.0, -1e6})
      CHECK(within(q.coordinate(beyond), -end, 64.0 * epsilon * end));
    for (const double beyond : {q.value(3.0), high, high + 1.0, 1e6})
      CHECK(within(q.coordinate(beyond), end, 64.0 * epsilon * end));
  }
}

TEST_CASE("quantile_of: the prior of that name, if it is normal") {
  const Priors priors{.parameters = {{.name = "a", .range = ParameterPrior::Range{0.0, 1.0}},
                                     {.name = "b", .normal = ParameterPrior::Normal{0.5, 0.1}}}};
  CHECK(make_quantile(priors, "a", 0.0, 1.0).sd == 0.0);
  CHECK(make_quantile(priors, "c", 0.0, 1.0).sd == 0.0);
  const Quantile normal = make_quantile(priors, "b", 0.0, 1.0);
  CHECK(normal.mean == 0.5);
  CHECK(normal.sd == 0.1);
  CHECK(near(normal.probability_range, std::erf(5.0 / std::sqrt(2.0)), 1e-14));
}

TEST_CASE("ranges_of: the ranges that are given, else the table's") {
  const sim::ParameterTable found =
      ranges({{.name = "Kd", .range = ParameterPrior::Range{100.0, 200.0}},
              {.name = "Kp", .normal = ParameterPrior::Normal{800.0, 50.0}},
              {.name = "Nv", .range = ParameterPrior::Range{0.0, 3.0}, .normal = ParameterPrior::Normal{2.5, 0.2}}});
  REQUIRE(found.size() == table().size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::string name = found[i].name;
    CHECK(name == table()[i].name);
    CHECK(found[i].low == (name == "Kd" ? 100.0 : table()[i].low));
    CHECK(found[i].high == (name == "Kd" ? 200.0 : name == "Nv" ? 3.0 : table()[i].high));
  }
}

TEST_CASE("ranges_of: priors of no parameter, or of none that can be, are refused") {
  using Range = ParameterPrior::Range;
  using Normal = ParameterPrior::Normal;
  check_error([] { ranges({{.name = "kp"}}); }, Code::setting_unknown, "kp");
  check_error([] { ranges({{.name = "Kp"}, {.name = "Kd"}, {.name = "Kp"}}); }, Code::setting_conflict);
  for (const Range wrong : {Range{-1.0, 2.0}, Range{2.0, 2.0}, Range{3.0, 2.0}, Range{0.0, infinity},
                            Range{not_a_number, 1.0}, Range{0.0, not_a_number}, Range{0.0, 1e6}, Range{0.5, 1.5}})
    check_error([&] { ranges({{.name = "Kd", .range = wrong}}); }, Code::setting_out_of_range);
  for (const Normal wrong : {Normal{not_a_number, 1.0}, Normal{infinity, 1.0}, Normal{200.0, 0.0}, Normal{200.0, -1.0},
                             Normal{200.0, not_a_number}, Normal{200.0, infinity}})
    check_error([&] { ranges({{.name = "Kd", .normal = wrong}}); }, Code::setting_out_of_range);
  // Five standard deviations beyond the end of the range, and four; below and above, and of a range of its own.
  const Range range{100.0, 200.0};
  for (const double mean : {50.0, 250.0})
    check_error(
        [&] {
          ranges({{.name = "Kd", .range = range, .normal = Normal{mean, 10.0}}});
        },
        Code::setting_out_of_range, "100 to");
  for (const double mean : {60.0, 240.0})
    CHECK_NOTHROW(ranges({{.name = "Kd", .range = range, .normal = Normal{mean, 10.0}}}));
  CHECK_NOTHROW(ranges({{.name = "Kd", .range = Range{1.0, 4.0}}}));
  // A gain below a hundredth of its range's end is meant over m g h; none is none.
  for (const double wrong : {0.3, 1e6, -1.0, infinity, not_a_number})
    check_error([&] { ranges({{.name = "Kd", .fixed = wrong}}); }, Code::setting_out_of_range);
  for (const double right : {0.0, 4.0, 3e4}) CHECK_NOTHROW(ranges({{.name = "Kd", .fixed = right}}));
  CHECK_NOTHROW(ranges({{.name = "Nv", .fixed = 0.001}}));
  // The delay that can be simulated has an end.
  CHECK_THROWS_AS(ranges({{.name = "delay", .range = Range{0.0, 1e3}}}), Error);
}

TEST_CASE("require_valid: priors out of their bounds are refused, those at their bounds are not") {
  struct Setting {
    double Priors::*value;
    const char* name;
    std::vector<double> wrong, right;
  };
  const std::vector<Setting> settings{
      {&Priors::sensor_noise_deg, "prior_noise", {0.0, -1.0, infinity, not_a_number}, {1e-9, 10.0}},
      {&Priors::sensor_noise_factor, "sensor_noise_factor", {1.0, -2.0, infinity, not_a_number}, {1.5}},
      {&Priors::slow_ratio, "slow_ratio", {0.0, -1.0, infinity, not_a_number}, {1e-6, 2.0}},
      {&Priors::slow_ratio_factor, "slow_ratio_factor", {1.0, 0.5, infinity, not_a_number}, {1.5}},
      {&Priors::start_s, "prior_start", {-0.1, 1.1, infinity, not_a_number}, {0.0, 1.0}},
      {&Priors::gain, "gain", {-0.1, 1.0, infinity, not_a_number}, {0.0, 0.9}},
      {&Priors::drift_hz, "drift_hz", {-1.0, infinity, not_a_number}, {0.0, 0.1}},
      {&Priors::standing_s, "standing_s", {-1.0, 61.0, infinity, not_a_number}, {0.0, 60.0}}};
  for (const Setting& setting : settings) {
    for (const double value : setting.wrong) {
      Priors priors;
      priors.*setting.value = value;
      check_error([&] { require_valid(priors); }, Code::setting_out_of_range, setting.name);
    }
    for (const double value : setting.right) {
      Priors priors;
      priors.*setting.value = value;
      CHECK(&require_valid(priors) == &priors);
    }
  }
}

TEST_CASE(
    "in_si_units: values over m g h are those of the protocol's body, parameters without such values are refused") {
  sim::Protocol protocol;
  protocol.experiment.body.mass_kg = 60.0;
  const double mgh = protocol.experiment.body.mgh();
  Priors priors{.parameters = {{.name = "Kp", .range = {{0.5, 1000.0}}, .normal = {{1.0, 0.2}}},
                               {.name = "Kd", .fixed = 0.3},
                               {.name = "delay", .normal = {{0.1, 0.02}}}}};
  priors.parameters[0].over_mgh.normal = true;
  priors.parameters[1].over_mgh.fixed = true;
  check_error([&] { static_cast<void>(ranges_for(priors, protocol.ranges())); }, Code::setting_conflict, "Kp");
  const Priors found = in_si_units(priors, protocol);
  CHECK(found.parameters[0].range->low == 0.5);
  CHECK(found.parameters[0].range->high == 1000.0);
  CHECK(found.parameters[0].normal->mean == mgh);
  CHECK(found.parameters[0].normal->sd == 0.2 * mgh);
  CHECK(found.parameters[1].fixed == 0.3 * mgh);
  CHECK(found.parameters[2].normal->mean == 0.1);
  CHECK(in_si_units(found, protocol).parameters[1].fixed == 0.3 * mgh);  // once only
  priors.parameters[0].over_mgh.range = true;
  CHECK(in_si_units(priors, protocol).parameters[0].range->low == 0.5 * mgh);
  priors.parameters[2].over_mgh.normal = true;
  check_error([&] { static_cast<void>(in_si_units(priors, protocol)); }, Code::setting_conflict, "delay");
}

TEST_CASE("PriorName: /mgh behind the name") {
  CHECK(PriorName("Kp").parameter == "Kp");
  CHECK_FALSE(PriorName("Kp").over_mgh);
  CHECK(PriorName("Kp_pass/mgh").parameter == "Kp_pass");
  CHECK(PriorName("Kp_pass/mgh").over_mgh);
  CHECK(PriorName("/mgh").parameter.empty());
  CHECK(PriorName("Kp/m").parameter == "Kp/m");
}
