// Sums of comparisons of controllers over recordings, against sums by hand.
#include "identify/compared_controllers.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "identify/result.hpp"
#include "sim/body_model.hpp"
#include "tests/near.hpp"

using namespace decid;
using test::near;

namespace {

using posterior::ComparedModel;

/// Adds a recording that was fitted by dec and by these others.
RecordingResult& add(Report& report, const ComparedModel& own,
                     const std::vector<std::pair<std::string, ComparedModel>>& others) {
  RecordingResult& made = report.recordings.emplace_back();
  FitFigures& figures = made.fit.emplace();
  figures.compared = own;
  for (const auto& [name, compared] : others) {
    ControllerFit& fit = figures.others.emplace_back();
    fit.controller = name;
    fit.compared = compared;
  }
  return made;
}

ComparedModel best(double log_density) {
  return {.log_density = log_density};
}
ComparedModel worse(double log_density, double difference, double standard_error) {
  return {.log_density = log_density, .difference = difference, .standard_error = standard_error};
}

}  // namespace

TEST_CASE("controllers: the sum over recordings, its standard error, and in how many each is best") {
  Report report;
  add(report, best(-100.0), {{"dec2015", worse(-110.0, -10.0, 3.0)}});
  CHECK_FALSE(sum_controllers(report));            // one recording
  report.recordings.emplace_back().fit.emplace();  // stopped before it was compared
  report.recordings.emplace_back().error = Error(Code::file_missing, "a.csv", "is missing", "name another");
  CHECK_FALSE(sum_controllers(report));
  add(report, worse(-204.0, -4.0, 2.0), {{"dec2015", best(-200.0)}});
  add(report, best(-50.0), {{"dec2015", worse(-51.0, -1.0, 6.0)}});
  const std::optional<ControllerSums> sums = sum_controllers(report);
  REQUIRE(sums);
  CHECK(sums->recordings == 3);
  CHECK(sums->not_usable == 0);
  REQUIRE(sums->controllers.size() == 2);
  const SummedController &dec = sums->controllers[0], &dec2015 = sums->controllers[1];
  CHECK(dec.name == sim::single_pendulum().name);
  CHECK(dec2015.name == "dec2015");
  CHECK(dec.best_in == 2);
  CHECK(dec2015.best_in == 1);
  CHECK(dec.log_density == -354.0);
  CHECK(dec.difference == 0.0);
  CHECK(dec.standard_error == 0.0);
  CHECK(dec2015.difference == -10.0 + 4.0 - 1.0);
  CHECK(near(dec2015.standard_error, std::sqrt(9.0 + 4.0 + 36.0), 1e-15));
}

TEST_CASE("controllers: where a third one is best, the standard error of two others is the sum of theirs to it") {
  Report report;
  add(report, worse(-104.0, -4.0, 2.0), {{"dec2015", worse(-101.0, -1.0, 1.5)}, {"ic", best(-100.0)}});
  add(report, best(-60.0), {{"dec2015", worse(-90.0, -30.0, 5.0)}, {"ic", worse(-80.0, -20.0, 4.0)}});
  const std::optional<ControllerSums> sums = sum_controllers(report);
  REQUIRE(sums);
  REQUIRE(sums->controllers.size() == 3);  // dec has the largest sum, -164
  CHECK(sums->controllers[0].difference == 0.0);
  CHECK(sums->controllers[1].difference == 3.0 - 30.0);
  CHECK(near(sums->controllers[1].standard_error, std::hypot(2.0 + 1.5, 5.0), 1e-15));
  CHECK(sums->controllers[2].difference == 4.0 - 20.0);
  CHECK(near(sums->controllers[2].standard_error, std::hypot(2.0, 4.0), 1e-15));
  CHECK(sums->controllers[2].best_in == 1);
  CHECK(sums->controllers[1].best_in == 0);
}

TEST_CASE("controllers: recordings that are not usable count and are numbered; other controllers are left out") {
  Report report;
  add(report, best(-10.0), {{"ic", worse(-11.0, -1.0, 1.0)}});
  add_invalid(add(report, best(-20.0), {{"ic", worse(-22.0, -2.0, 1.0)}}).warnings, "at_edge", "at the edge");
  add(report, best(-30.0), {{"dec2015", worse(-33.0, -3.0, 1.0)}});
  const std::optional<ControllerSums> sums = sum_controllers(report);
  REQUIRE(sums);
  CHECK(sums->recordings == 2);
  CHECK(sums->not_usable == 1);
  CHECK(sums->controllers[1].difference == -3.0);
  CHECK_FALSE(sum_controllers({}));
}
