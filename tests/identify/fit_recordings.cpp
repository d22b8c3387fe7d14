// Fits of several controllers to one recording: the warning of a better one, priors of each, and a stop between them.
#include "identify/fit_recordings.hpp"

#include <algorithm>

#include "tests/helpers.hpp"
#include "tests/posterior/sampling/quick.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::test;

namespace {

/// A recording of independent channels.
RecordingResult recording_of_channels(sim::Protocol protocol) {
  protocol.experiment.body_model = &sim::independent_channels();
  RecordingResult result;
  result.file = "channels.csv";
  result.trial = recording::trial_of(recorded(protocol, {1250.0, 400.0, 0.4, 0.02, 0.3, 0.15}, 0.02, 0));
  return result;
}

FitRequest with_channels(std::vector<posterior::ParameterPrior> priors = {}) {
  FitRequest request;
  request.settings = quick();
  request.others.push_back({&sim::independent_channels(), std::move(priors)});
  return request;
}

}  // namespace

TEST_CASE("a controller that predicts the recording far better is named, with priors of its own" *
          doctest::test_suite("slow")) {
  // In 20 s of sines the noise that is inferred makes up for the controller.
  RecordingResult result = recording_of_channels(sim::short_protocol());
  Fitter fitter(nullptr, sim::short_protocol(), {}, with_channels({{.name = "W", .fixed = 0.4}}));
  CHECK(fitter.fit(std::span(&result, 1)));
  REQUIRE(!result.error);
  REQUIRE(result.fit->others.size() == 1);
  const ControllerFit& channels = result.fit->others[0];
  CHECK(channels.controller == "ic");
  CHECK(channels.posterior.quantile(2, 0.0) == 0.4);
  CHECK(channels.posterior.quantile(2, 1.0) == 0.4);
  CHECK(channels.compared.difference == 0.0);
  CHECK(result.fit->compared->difference < -4.0);
  CHECK(std::ranges::count(result.warnings, "other_controller", &Warning::code) == 1);
  CHECK(result.trust() != Trust::usable);
}

TEST_CASE("a stop during the second controller keeps the first one's fit, without a comparison") {
  RecordingResult result = recording_of_channels(sines_protocol());
  Fitter fitter(nullptr, sines_protocol(), {}, with_channels());
  CHECK(
      !fitter.fit(std::span(&result, 1), [](std::size_t, const posterior::Progress& here) { return here.done < 0.6; }));
  REQUIRE(!result.error);
  CHECK(result.fit->stopped);
  CHECK(result.fit->posterior.draws_per_chain() == quick().max_draws);
  CHECK(result.fit->others.empty());
  CHECK(!result.fit->compared);
  CHECK(result.fit->block_s > 0.0);
  CHECK(result.fit->edge_s > 0.0);
}

TEST_CASE("priors of parameters that a controller does not have are refused") {
  check_error([] { Fitter(nullptr, sines_protocol(), {}, with_channels({{.name = "theta", .fixed = 0.001}})); },
              Code::setting_unknown, "theta");
  FitRequest request = with_channels();
  request.priors.parameters.push_back({.name = "W", .fixed = 0.4});
  check_error([&] { Fitter(nullptr, sines_protocol(), {}, request); }, Code::setting_unknown, "W");
}
