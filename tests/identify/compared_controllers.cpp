// Sums of comparisons of controllers over recordings, against sums by hand.
#include "identify/compared_controllers.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/result.hpp"
#include "sim/body_model.hpp"
#include "tests/helpers.hpp"
#include "tests/near.hpp"

using namespace decid;
using test::check_error;
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

/// 100 blocks, each predicted by this many nats plus a varying part that all controllers share.
posterior::LeaveOneOut of_blocks(double nats) {
  posterior::LeaveOneOut made;
  for (int i = 0; i < 100; ++i) {
    made.pointwise.push_back(nats * (i % 2 == 0 ? 0.5 : 1.5) - 0.01 * (i % 7));
    made.shapes.push_back(0.2);
  }
  return made;
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

TEST_CASE("controllers: recordings that are not usable or not comparable count and are numbered; others are left out") {
  Report report;
  add(report, best(-10.0), {{"ic", worse(-11.0, -1.0, 1.0)}}).fit->others[0].comparable = false;
  RecordingResult& odd = add(report, best(-20.0), {{"ic", worse(-22.0, -2.0, 1.0)}});
  add_invalid(odd.warnings, "at_edge", "at the edge");
  odd.fit->comparable = false;
  add(report, best(-5.0), {{"ic", worse(-7.0, -2.0, 1.0)}});
  add(report, best(-30.0), {{"dec2015", worse(-33.0, -3.0, 1.0)}});
  const std::optional<ControllerSums> sums = sum_controllers(report);
  REQUIRE(sums);
  CHECK(sums->recordings == 3);
  CHECK(sums->not_usable == 1);
  CHECK(sums->not_comparable == 2);
  CHECK(sums->controllers[1].difference == -5.0);
  CHECK_FALSE(sum_controllers({}));
}

TEST_CASE("controllers: a list names each once, in its order") {
  using Controllers = std::vector<const sim::BodyModel*>;
  sim::Protocol protocol = sim::short_protocol();
  const auto find = [&](const char* names) { return controllers_to_fit(names, protocol, "list"); };
  CHECK(find("") == Controllers{&sim::single_pendulum()});
  CHECK(find("ic,dec") == Controllers{&sim::independent_channels(), &sim::single_pendulum()});
  for (const char* names : {"dec,pid", "dec,,ic", "ic,"})
    check_error([&] { find(names); }, Code::setting_unknown, "list");
  check_error([&] { find("dec,ic,dec"); }, Code::setting_conflict, "list");
  // A controller that the protocol names must be among them.
  CHECK(find("ic").size() == 1);
  protocol.names_controller = true;
  check_error([&] { find("ic"); }, Code::setting_conflict, "list");
}

TEST_CASE("controllers: a prior acts on the controllers that have its parameter") {
  const std::vector<const sim::BodyModel*> all{&sim::single_pendulum(), &sim::independent_channels()};
  CHECK(is_of_another("W", *all[0], all));
  CHECK_FALSE(is_of_another("W", *all[1], all));
  CHECK_FALSE(is_of_another("Kp", *all[0], all));
  CHECK_FALSE(is_of_another("pid", *all[0], all));  // which another check refuses
}

TEST_CASE("controllers: chains that do not agree are not compared") {
  CHECK(chains_allow_comparison(1.2, {}));
  CHECK_FALSE(chains_allow_comparison(1.86, {}));
  CHECK_FALSE(chains_allow_comparison(std::numeric_limits<double>::infinity(), {}));
  CHECK_FALSE(chains_allow_comparison(std::numeric_limits<double>::quiet_NaN(), {}));
  Warnings warnings;
  add_caution(warnings, "divergences", "text");
  CHECK_FALSE(chains_allow_comparison(1.0, warnings));
  Warnings others;
  add_caution(others, "at_edge", "text");
  CHECK(chains_allow_comparison(1.0, others));
}

TEST_CASE("controllers: the best comparable one of those that predict far better is named") {
  const posterior::LeaveOneOut own = of_blocks(0.0), better = of_blocks(0.2), best = of_blocks(0.5);
  const std::vector three{own, better, best};
  const auto warned = [](const std::vector<posterior::LeaveOneOut>& left_out, const std::vector<bool>& comparable) {
    return better_controller_warning(left_out, comparable, {"dec", "dec2015", "ic"});
  };
  const std::optional<Warning> found = warned(three, {true, true, true});
  REQUIRE(found);
  CHECK(found->code == "other_controller");
  CHECK(found->severity == Severity::caution);
  CHECK(found->text.starts_with("controller ic predicts this recording better than dec, by 50 +- "));
  // Without the best one's chains, the other one; without their own, none.
  const std::optional<Warning> second = warned(three, {true, true, false});
  REQUIRE(second);
  CHECK(second->text.starts_with("controller dec2015 predicts this recording better than dec, by 20 +- "));
  CHECK_FALSE(warned(three, {false, true, true}));
  CHECK_FALSE(warned(three, {true, false, false}));
  CHECK_FALSE(warned({best, own, better}, {true, true, true}));
  CHECK_FALSE(warned({own, of_blocks(0.03)}, {true, true}));  // 3 nats
  // Blocks that rest on few draws do not make a controller better.
  posterior::LeaveOneOut other = own;
  for (std::size_t i = 0; i < 60; ++i) {
    other.pointwise[i] += 1.0;
    other.shapes[i] = 0.9;
  }
  CHECK_FALSE(warned({own, other}, {true, true}));
  std::ranges::fill(other.shapes, 0.3);
  CHECK(warned({own, other}, {true, true}));
  std::ranges::fill(other.shapes, 0.9);
  CHECK_FALSE(warned({own, other}, {true, true}));
}
