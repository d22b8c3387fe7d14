// Explanations: what trials simulated from the parameters say of a recording, alone and in company.
#include "identify/explanation.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "base/random.hpp"
#include "tests/near.hpp"

namespace decid {
namespace {

using test::near;
using test::within;

const sim::Simulator& simulator() {
  static const sim::Simulator one(sim::short_protocol());
  return one;
}
const Explainer& explainer() {
  static const Explainer one(simulator());
  return one;
}

sim::Parameters controller(double nv) {
  sim::Parameters parameters = sim::middle_parameters();
  parameters[sim::Nv] = nv;
  return parameters;
}

dataset::Trial trial(const sim::Parameters& parameters, std::uint64_t item) {
  std::vector<double> sway(static_cast<std::size_t>(simulator().samples()));
  REQUIRE(simulator().run(parameters, Random(5, Stream::vestibular_noise, item), sway).valid);
  dataset::Trial made;
  made.sway_rad.assign(sway.begin(), sway.end());
  return made;
}

bool warns(const Explanation& explanation, const std::string& text) {
  return std::ranges::any_of(explanation.warnings, [&](const std::string& w) { return w.find(text) != w.npos; });
}

}  // namespace

TEST_CASE("explanation: without noise the controller explains its own trial wholly") {
  const sim::Parameters parameters = controller(0.0);
  const dataset::Trial own = trial(parameters, 0);
  const Explanation found = explainer().explain({parameters, own});
  CHECK(found.fitted_rad == own.sway_rad);
  CHECK(found.rms_residual_deg == 0.0);
  CHECK(found.variance_accounted_for == 1.0);
  CHECK(near(found.following, 1.0, 1e-9));
  CHECK(found.warnings.empty());
  REQUIRE(found.frf.has_value());
  CHECK(found.frf->cycles == 2);  // of three the first is left out
  REQUIRE(found.frf->recorded.size() == found.frf->model.size());
  for (std::size_t i = 0; i < found.frf->recorded.size(); ++i)
    CHECK(found.frf->recorded[i].response == found.frf->model[i].response);
}

TEST_CASE("explanation: the residual is what the recording has besides") {
  const sim::Parameters parameters = controller(0.0);
  dataset::Trial disturbed = trial(parameters, 0);
  // A sine of 0.1 degrees: rms 0.1 / sqrt(2), but for what floats round.
  const auto count = static_cast<double>(disturbed.sway_rad.size());
  for (std::size_t k = 0; k < disturbed.sway_rad.size(); ++k)
    disturbed.sway_rad[k] +=
        static_cast<float>(0.1 * sim::rad_per_deg * std::sin(2 * sim::pi * 700 * static_cast<double>(k) / count));
  const Explanation found = explainer().explain({parameters, disturbed});
  CHECK(near(found.rms_residual_deg, 0.1 / std::sqrt(2.0), 1e-5));
  CHECK(found.variance_accounted_for < 1.0);
}

TEST_CASE("explanation: one of many is the same as alone") {
  std::vector<sim::Parameters> parameters;
  std::vector<dataset::Trial> trials;
  for (int i = 0; i < 11; ++i) {  // more than are simulated together
    parameters.push_back(controller(0.05 * i));
    trials.push_back(trial(parameters.back(), static_cast<std::uint64_t>(i)));
  }
  std::vector<Answer> answers;
  for (std::size_t i = 0; i < trials.size(); ++i) answers.push_back({parameters[i], trials[i]});
  const std::vector<Explanation> all = explainer().explain(answers);
  REQUIRE(all.size() == trials.size());
  for (std::size_t i = 0; i < trials.size(); ++i) {
    const Explanation alone = explainer().explain(answers[i]);
    CHECK(alone.fitted_rad == all[i].fitted_rad);
    CHECK(alone.rms_residual_deg == all[i].rms_residual_deg);
    CHECK(alone.following == all[i].following);
    CHECK(alone.warnings == all[i].warnings);
  }
}

TEST_CASE("explanation: a controller that does not stand, and sway that is not its own, are warned of") {
  const sim::Parameters stands = controller(0.1);
  const dataset::Trial own = trial(stands, 0);
  sim::Parameters falls = stands;
  falls[sim::Kp] = 100.0;
  const Explanation fallen = explainer().explain({falls, own});
  CHECK(fallen.fitted_rad.size() < own.sway_rad.size());
  CHECK(std::isnan(fallen.rms_residual_deg));
  CHECK(std::isnan(fallen.variance_accounted_for));
  CHECK(std::isnan(fallen.following));
  CHECK(warns(fallen, "does not stand"));
  REQUIRE(fallen.frf.has_value());
  CHECK(fallen.frf->model.empty());

  dataset::Trial reversed = own;
  for (float& value : reversed.sway_rad) value = -value;
  Explanation other = explainer().explain({stands, reversed});
  CHECK(other.following < 0.0);
  CHECK(warns(other, "explains"));
  CHECK(!warns(other, "hardly follows"));
  warn_unless_following(other);
  CHECK(warns(other, "hardly follows"));
}

TEST_CASE("explanation: a stimulus without a frequency response says so once") {
  sim::Protocol step = sim::short_protocol();
  step.experiment.stimulus = sim::RaisedCosines{
      .moves = {{.shape = sim::Move::Shape::step, .start_s = 1.0, .duration_s = 1.0, .amplitude_deg = 1.0}},
      .cycle_s = 20.0};
  const sim::Simulator stepped(step);
  const Explainer explains(stepped);
  std::vector<double> sway(static_cast<std::size_t>(stepped.samples()));
  const sim::Parameters parameters = controller(0.0);
  REQUIRE(stepped.run(parameters, Random(5, Stream::vestibular_noise, 0), sway).valid);
  dataset::Trial own;
  own.sway_rad.assign(sway.begin(), sway.end());
  const Explanation found = explains.explain({parameters, own});
  CHECK(!found.frf.has_value());
  CHECK(std::ranges::count_if(found.warnings,
                              [](const std::string& w) { return w.starts_with("no frequency response"); }) == 1);
}

}  // namespace decid
