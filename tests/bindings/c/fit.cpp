// Fits through C: the draws of the library, progress, and stopping. test_package.py compares each option with the
// program's.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/files/json_object.hpp"
#include "identify/fit_recordings.hpp"
#include "sim/body_model.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tests/bindings/c/owned.hpp"
#include "tests/near.hpp"
#include "tools/report/json/report_json.hpp"

namespace decid {
namespace {

using namespace test;

decid_fit_options brief() {
  decid_fit_options options;
  decid_fit_defaults(&options, sizeof options);
  options.max_draws = 8;
  return options;
}

/// A trial of 4 s at 20 Hz, and the small network of such trials, in C too.
struct Trial4s {
  static constexpr const char* file = DECID_SOURCE_DIR "/tests/golden/0.2.0/net.safetensors";
  Model model = load_model(file);
  OwnedModel same = make<OwnedModel>([](decid_model** place) { return decid_model_load(file, place); });
  double rate_hz = model.protocol.experiment.sample_rate_hz;
  std::vector<double> sway_rad = simulate();
  OwnedRecording recording = make<OwnedRecording>([&](decid_recording** place) {
    return decid_recording_of(sway_rad.data(), sway_rad.size(), rate_hz, DECID_RADIANS, place);
  });

 private:
  std::vector<double> simulate() const {
    std::vector<double> sway(static_cast<std::size_t>(model.protocol.samples()));
    sim::Simulator(model.protocol).run(model.parameters().middle(), Random(7, sim::streams::vestibular_noise, 0), sway);
    return sway;
  }
};

}  // namespace

TEST_CASE("a fit has the draws of the library's") {
  const Trial4s trial;
  const Model& model = trial.model;
  decid_fit_options options = brief();
  options.moved_before = 1;
  options.seed = 10;  // whose chains are far apart
  std::vector<double> reported;
  options.user = &reported;
  options.progress = [](void* user, double done, const char* stage) {
    static_cast<std::vector<double>*>(user)->push_back(stage != nullptr ? done : -1.0);
    return 0;
  };
  const OwnedResult result = make<OwnedResult>(
      [&](decid_result** place) { return decid_fit(trial.same.get(), trial.recording.get(), &options, place); });
  CHECK(reported.size() > 5);
  CHECK(std::ranges::is_sorted(reported));
  CHECK(reported.front() >= 0.0);
  CHECK(reported.back() <= 1.0);

  RecordingResult expected =
      bring(recording::make_recording(trial.sway_rad, trial.rate_hz), recording::ProtocolPlan(model.protocol), {});
  FitRequest request;
  request.settings.max_draws = request.settings.min_draws = 8;
  request.priors.moved_before = true;
  request.settings.seed = options.seed;
  Fitter(&model, model.protocol, {}, request).fit(std::span(&expected, 1));
  REQUIRE(expected.fit);
  const posterior::Posterior& found = expected.fit->posterior;

  const decid_sampling* sampling = decid_result_sampling(result.get());
  REQUIRE(sampling != nullptr);
  CHECK(sampling->draws == found.draws());
  CHECK(sampling->chains == found.chains());
  CHECK(sampling->agreed == (found.agreed() ? 1 : 0));
  CHECK(sampling->divergences == found.divergences());
  CHECK(sampling->samples_noise_deg == expected.fit->samples_noise_deg);
  REQUIRE(decid_result_quantities(result.get()) == 10);
  // These chains are far apart: values and intervals of the parameters are the network's.
  const Estimate& estimate = expected.estimate;
  REQUIRE(expected.fit->answer == FitFigures::Answer::network);
  REQUIRE(estimate.distribution);
  for (std::size_t q = 0; q < 10; ++q) {
    const int quantity = found.quantity(q);
    const double* draws = decid_result_draws(result.get(), q);
    const decid_parameter& parameter = *decid_result_parameter(result.get(), q);
    CHECK(std::vector<double>(draws, draws + sampling->draws) == found.draws_for(quantity));
    const double low = 0.5 * (1.0 - 0.9);
    CHECK(parameter.interval90[0] ==
          (q < 7 ? estimate.distribution->quantile(quantity, low) : found.quantile(quantity, low)));
    CHECK(parameter.rhat == found.rhat()[q]);
    CHECK(parameter.effective_draws == found.effective_draws()[q]);
  }
  CHECK(decid_result_parameter(result.get(), 0)->value == estimate.parameters[0]);
  CHECK(std::string(decid_result_parameter(result.get(), 7)->name) == "sensor_noise_deg");
  CHECK(std::isnan(decid_result_parameter(result.get(), 9)->normalized));
  CHECK(decid_result_correlation(result.get(), 0, 9) == found.correlation(0, found.quantity(9)));
  CHECK(decid_result_correlation(result.get(), 0, 1) == estimate.distribution->correlation(0, 1));
}

TEST_CASE("a fit of several controllers has the comparison of the program's JSON") {
  const Trial4s trial;
  decid_fit_options options = brief();
  options.controllers = "ic,dec";
  const double none = std::numeric_limits<double>::quiet_NaN();
  const std::vector<decid_parameter_prior> priors{
      {"Kp", 300.0, 2000.0, none, none}, {"Kp/mgh", none, none, 1.0, 0.2}, {"theta", none, none, 0.001, 0.0005}};
  options.parameter_priors = priors.data();
  options.parameter_prior_count = priors.size();
  const OwnedResult result = make<OwnedResult>(
      [&](decid_result** place) { return decid_fit(trial.same.get(), trial.recording.get(), &options, place); });

  sim::Protocol protocol = trial.model.protocol;
  protocol.experiment.body_model = &sim::independent_channels();
  const double mgh = protocol.experiment.body.mgh();
  FitRequest request;
  request.settings.max_draws = request.settings.min_draws = 8;
  const posterior::ParameterPrior kp{.name = "Kp", .range = {{300.0, 2000.0}}, .normal = {{mgh, 0.2 * mgh}}},
      theta{.name = "theta", .normal = {{0.001, 0.0005}}};
  request.priors.parameters = {kp};
  request.others.push_back({&sim::single_pendulum(), {kp, theta}});
  Fitter fitter(&trial.model, protocol, {}, request);
  Report report = fitter.report();
  report.recordings.push_back(
      bring(recording::make_recording(trial.sway_rad, trial.rate_hz), recording::ProtocolPlan(protocol), {}));
  fitter.fit(report.recordings);
  const Json expected = parse_json(tools::report_json(report), "report").at("recordings").at(0);

  CHECK(decid_result_parameter(result.get(), 0)->low == 300.0);
  CHECK(decid_result_parameter(result.get(), 0)->high == 2000.0);
  CHECK(decid_result_parameter(result.get(), 1)->low == protocol.ranges()[1].low);
  REQUIRE(decid_result_controllers(result.get()) == 2);
  double weights = 0.0;
  for (std::size_t i = 0; i < 2; ++i) {
    const decid_compared_controller& found = *decid_result_controller(result.get(), i);
    const Json& of = expected.at("controllers").at(i);
    CHECK(found.controller == of.at("controller").get<std::string>());
    CHECK(found.log_predictive_density == of.at("log_predictive_density").get<double>());
    CHECK(found.difference == of.at("difference").get<double>());
    CHECK(found.difference_standard_error == of.at("difference_standard_error").get<double>());
    CHECK(found.weight == of.at("weight").get<double>());
    CHECK((found.comparable != 0) == of.at("comparable").get<bool>());
    weights += found.weight;
  }
  CHECK(near(weights, 1.0, 1e-12));
  CHECK(decid_result_controller(result.get(), 2) == nullptr);
  CHECK(decid_result_parameter(result.get(), 0)->value == expected.at("parameters").at(0).at("value").get<double>());
  CHECK(decid_result_parameters(result.get()) == sim::independent_channels().parameters.size());
  CHECK(decid_result_controllers(nullptr) == 0);
  CHECK(decid_result_controller(nullptr, 0) == nullptr);
}

TEST_CASE("a fit refuses controllers that it cannot compare") {
  const Trial4s trial;
  decid_result* result = nullptr;
  decid_fit_options options = brief();
  const auto fit = [&](const char* controllers) {
    options.controllers = controllers;
    return decid_fit(trial.same.get(), trial.recording.get(), &options, &result);
  };
  refused(fit("dec,pid"), Code::setting_unknown, "controllers");
  refused(fit("dec,,ic"), Code::setting_unknown, "controllers");
  refused(fit("ic,"), Code::setting_unknown, "controllers");
  refused(fit("dec,ic,dec"), Code::setting_conflict, "names dec twice");
  const OwnedProtocol of_dec2015 = make<OwnedProtocol>(
      [](decid_protocol** place) { return decid_protocol_load_controller("short", "dec2015", place); });
  options.protocol = of_dec2015.get();
  refused(fit("dec,ic"), Code::setting_conflict, "does not name dec2015");
  const OwnedProtocol of_dec =
      make<OwnedProtocol>([](decid_protocol** place) { return decid_protocol_load_controller("short", "dec", place); });
  options.protocol = of_dec.get();
  refused(fit("ic"), Code::setting_conflict, "does not name dec");
  options.protocol = nullptr;
  const double none = std::numeric_limits<double>::quiet_NaN();
  const decid_parameter_prior of_ic{"W", 0.2, 0.8, none, none};  // no parameter of dec
  options.parameter_priors = &of_ic;
  options.parameter_prior_count = 1;
  refused(fit("dec"), Code::setting_unknown, "W");
  const decid_parameter_prior of_delay{"delay/mgh", 0.2, 0.8, none, none};
  options.parameter_priors = &of_delay;
  refused(fit("dec"), Code::setting_conflict, "delay");
  options.parameter_priors = &of_ic;
  options.progress = [](void*, double, const char*) { return 1; };
  refused(fit("dec,ic"), Code::stopped);
}

TEST_CASE("a fit does not replace a robot's body, which the protocol has, by a person's") {
  const TemporaryFolder folder;
  const std::filesystem::path file =
      write_text(folder / "robot.json", R"({"body": {"mass_kg": 60, "com_height_m": 0.8, "inertia_kgm2": 42}})");
  const OwnedProtocol robot = protocol(file.c_str());
  const Trial4s trial;
  decid_fit_options options = brief();
  options.protocol = robot.get();
  options.mass_kg = 70.0;
  options.height_m = 1.75;
  decid_result* result = nullptr;
  refused(decid_fit(trial.same.get(), trial.recording.get(), &options, &result), Code::setting_conflict);
  CHECK(result == nullptr);
}

TEST_CASE("a callback stops a fit") {
  const OwnedRecording recording = make_recording(simulated(7));
  decid_fit_options options = brief();
  int calls = 0;
  options.user = &calls;
  options.progress = [](void* user, double, const char*) { return ++*static_cast<int*>(user) >= 2 ? 1 : 0; };
  decid_result* result = nullptr;
  refused(decid_fit(built_in(), recording.get(), &options, &result), Code::stopped, "decid_fit");
  CHECK(calls == 2);
  CHECK(result == nullptr);
}

TEST_CASE("a fit refuses priors out of their bounds") {
  const OwnedRecording recording = make_recording(simulated(7));
  decid_fit_options options = brief();
  options.prior_gain = 2.0;
  decid_result* result = nullptr;
  refused(decid_fit(built_in(), recording.get(), &options, &result), Code::setting_out_of_range, "prior_gain: ");
  options = brief();
  options.prior_start_s = -1.0;
  refused(decid_fit(built_in(), recording.get(), &options, &result), Code::setting_out_of_range, "prior_start_s: ");
  options = brief();
  options.prior_noise_deg = 0.0;
  refused(decid_fit(built_in(), recording.get(), &options, &result), Code::setting_out_of_range, "prior_noise_deg: ");
  options = brief();
  options.parameter_prior_count = 1;
  refused(decid_fit(built_in(), recording.get(), &options, &result), Code::setting_missing, "parameter_priors");
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  decid_parameter_prior prior{"Kq", 1.0, 2.0, unknown, unknown};
  options.parameter_priors = &prior;
  refused(decid_fit(built_in(), recording.get(), &options, &result), Code::setting_unknown, "Kq");
  prior = {"Kp", 2.0, 1.0, unknown, unknown};
  refused(decid_fit(built_in(), recording.get(), &options, &result), Code::setting_out_of_range, "Kp");
  const decid_parameter_prior range{"Kp", 300.0, 2000.0, unknown, unknown},
      normal{"Kp/mgh", unknown, unknown, 1.0, 0.2}, both{"Kp", 300.0, 2000.0, 900.0, 100.0},
      nothing{"Kp", unknown, unknown, unknown, unknown};
  options.parameter_prior_count = 2;
  for (const std::array<decid_parameter_prior, 2>& twice : {std::array{range, nothing},
                                                            {nothing, range},
                                                            {normal, nothing},
                                                            {nothing, nothing},
                                                            {range, range},
                                                            {both, normal}}) {
    options.parameter_priors = twice.data();
    refused(decid_fit(built_in(), recording.get(), &options, &result), Code::setting_conflict, "Kp");
  }
  options.parameter_priors = &prior;
  options.parameter_prior_count = 1;
  prior = {nullptr, 1.0, 2.0, unknown, unknown};
  refused(decid_fit(built_in(), recording.get(), &options, &result), Code::setting_missing);
  prior = {"Kp", 300.0, 2000.0, 1000.0, 0.0};
  refused(decid_fit(built_in(), recording.get(), &options, &result), Code::setting_out_of_range, "Kp");
  options = brief();
  for (const int draws : {0, 4, 7}) {  // the sampler takes 4
    options.max_draws = draws;
    refused(decid_fit(built_in(), recording.get(), &options, &result), Code::setting_out_of_range, "max_draws");
  }
}

}  // namespace decid
