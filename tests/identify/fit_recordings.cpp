// Fits of several controllers to one recording, and of several recordings together.
#include "identify/fit_recordings.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/compared_controllers.hpp"
#include "identify/network/model.hpp"
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
  result.trial = recording::make_trial(recorded(protocol, {1250.0, 400.0, 0.4, 0.02, 0.3, 0.15}, 0.02, 0));
  return result;
}

FitRequest with_channels(std::vector<posterior::ParameterPrior> priors = {}) {
  FitRequest request;
  request.settings = quick();
  request.others.push_back({&sim::independent_channels(), std::move(priors)});
  return request;
}

}  // namespace

TEST_CASE("another controller has priors of its own, and is compared") {
  // compared_controllers.cpp tests which differences are named.
  RecordingResult result = recording_of_channels(sines_protocol());
  FitRequest request = with_channels({{.name = "W", .fixed = 0.4}});
  request.settings.max_leapfrog_steps = 8;
  Fitter fitter(nullptr, sines_protocol(), {}, request);
  CHECK(fitter.fit(std::span(&result, 1)));
  REQUIRE(!result.error);
  REQUIRE(result.fit->others.size() == 1);
  const ControllerFit& channels = result.fit->others[0];
  CHECK(channels.controller == "ic");
  CHECK(channels.posterior.quantile(2, 0.0) == 0.4);
  CHECK(channels.posterior.quantile(2, 1.0) == 0.4);
  CHECK(channels.posterior.mean(2) == 0.4);
  CHECK(channels.posterior.stddev(2) == 0.0);
  REQUIRE(result.fit->compared);
  CHECK(std::max(result.fit->compared->difference, channels.compared.difference) == 0.0);
  CHECK(std::min(result.fit->compared->difference, channels.compared.difference) < 0.0);
  CHECK(result.fit->comparable == chains_allow_comparison(result.fit->posterior.max_rhat(), result.warnings));
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

namespace {

/// Recordings of one person, of which the second has an error.
std::vector<RecordingResult> of_one_participant() {
  std::vector<RecordingResult> read(4);
  for (std::size_t i = 0; i < read.size(); ++i) {
    read[i].file = "trial" + std::to_string(i) + ".csv";
    read[i].trial = recording::make_trial(recorded(sines_protocol(), some_parameters(), 0.02, i));
  }
  read[1].error = Error(Code::file_missing, "trial1.csv", "is missing", "name another");
  return read;
}

FitRequest quick_request() {
  FitRequest request;
  request.settings = quick();
  request.settings.max_leapfrog_steps = 8;
  return request;
}

}  // namespace

TEST_CASE("recordings fitted together have the same parameters, but for those that conditions free") {
  std::vector<RecordingResult> read = of_one_participant();
  FitRequest request = quick_request();
  request.freed = {"theta"};
  Fitter fitter(nullptr, sines_protocol(), {}, request);
  const FitGroup group{{0, 1, 3}, {"open", "open", "closed"}};
  std::vector<std::size_t> order;
  CHECK(fit_each(
      read, [&](std::size_t) -> Fitter& { return fitter; }, {}, [&](std::size_t i) { order.push_back(i); },
      std::span(&group, 1)));
  CHECK(order.size() == 4);
  CHECK(read[1].error->code() == Code::file_missing);
  REQUIRE(!read[0].error);
  REQUIRE(!read[3].error);
  const posterior::Posterior &first = read[0].fit->posterior, &last = read[3].fit->posterior;
  CHECK(first.mean(sim::Kp) == last.mean(sim::Kp));
  CHECK(first.mean(sim::Theta) != last.mean(sim::Theta));
  REQUIRE(read[3].fit->joint);
  CHECK(read[3].fit->joint->files == std::vector<std::string>{"trial0.csv", "trial3.csv"});
  CHECK(read[3].fit->joint->condition == "closed");
  CHECK(read[3].fit->joint->freed == request.freed);
  // The recording that is in no group has the bits of a fit of its own.
  std::vector<RecordingResult> alone = of_one_participant();
  CHECK(fitter.fit(std::span(alone).subspan(2, 1)));
  CHECK(!read[2].fit->joint);
  CHECK(read[2].fit->posterior.mean(sim::Kp) == alone[2].fit->posterior.mean(sim::Kp));
}

TEST_CASE("a parameter that is free and fixed is refused, also one that is fixed by convention") {
  FitRequest request = quick_request();
  request.freed = {"Kp"};
  (void)Fitter(nullptr, sines_protocol(), {}, request);
  sim::Protocol conventional = sines_protocol();
  conventional.experiment.body_model = &sim::dec2015();
  check_error([&] { Fitter(nullptr, conventional, {}, request); }, Code::setting_conflict, "Kp");
  request.priors.parameters.push_back({.name = "Kp", .fixed = 839.0});
  check_error([&] { Fitter(nullptr, sines_protocol(), {}, request); }, Code::setting_conflict, "Kp");
}

TEST_CASE("recordings that cannot be fitted together each have the error") {
  const auto code_of = [](const FitRequest& request, const sim::Protocol& second) {
    std::vector<RecordingResult> read = of_one_participant();
    read[2].error = read[1].error;
    Fitter one(nullptr, sines_protocol(), {}, request), other(nullptr, second, {}, request);
    const FitGroup group{{0, 3}};
    fit_each(
        read, [&](std::size_t i) -> Fitter& { return i == 0 ? one : other; }, {}, {}, std::span(&group, 1));
    REQUIRE(read[0].error);
    REQUIRE(read[3].error);
    CHECK(read[0].error->code() == read[3].error->code());
    return read[0].error->code();
  };
  FitRequest unknown = quick_request();
  unknown.freed = {"W"};
  CHECK(code_of(unknown, sines_protocol()) == Code::setting_unknown);
  CHECK(code_of(with_channels(), sines_protocol()) == Code::setting_conflict);
  sim::Protocol heavier = sines_protocol();
  heavier.experiment.body.mass_kg += 10.0;
  CHECK(code_of(quick_request(), heavier) == Code::value_invalid);
}

TEST_CASE("a fit does not use samples that were not measured") {
  RecordingResult result;
  result.trial = recording::make_trial(recorded(sines_protocol(), some_parameters(), 0.02, 0));
  result.trial.gaps = {{800, 1195}};
  FitRequest request;
  request.settings = quick();
  request.keeps_log_likelihood = true;
  Fitter fitter(nullptr, sines_protocol(), {}, request);
  CHECK(fitter.fit(std::span(&result, 1)));
  REQUIRE(!result.error);
  // Blocks of 0.1 s: those in the gap are no observations.
  const posterior::Inferred& inferred = result.fit->inferred;
  REQUIRE(result.fit->block_s == 0.1);
  const std::size_t blocks = inferred.sway_rad.low.size(), recorded = blocks - 40;
  REQUIRE(inferred.recorded_blocks.size() == recorded);
  CHECK(inferred.recorded_blocks[79] == 79);
  CHECK(inferred.recorded_blocks[80] == 120);
  CHECK(inferred.recorded_blocks.back() == static_cast<int>(blocks) - 1);
  const std::vector<double>& pointwise = inferred.left_out.pointwise;
  REQUIRE(pointwise.size() == recorded);
  double sum = 0.0, squares = 0.0;
  for (const double each : pointwise) {
    CHECK(std::abs(each) > 1e-9);
    sum += each;
  }
  for (const double each : pointwise) squares += std::pow(each - sum / static_cast<double>(recorded), 2);
  CHECK(near(inferred.left_out.log_density, sum, 1e-12));
  CHECK(near(inferred.left_out.standard_error,
             std::sqrt(squares * static_cast<double>(recorded) / static_cast<double>(recorded - 1)), 1e-9));
  CHECK(inferred.log_likelihood.size() == result.fit->stored_draws.size() * recorded);
}

TEST_CASE("trials that explain and check a recording have a platform that moved before, if the recording's did") {
  sim::Protocol protocol = sines_protocol(), moved = protocol;
  moved.moved_before = true;
  FitRequest request;
  request.settings = quick();
  request.settings.max_leapfrog_steps = 8;
  FitRequest asked = request;
  asked.priors.moved_before = true;
  const auto fitted = [&](const sim::Protocol& of, const FitRequest& how, std::optional<bool> by_tilt) {
    RecordingResult result;
    result.file = "cut.csv";
    result.trial = recording::make_trial(recorded(protocol, some_parameters(), 0.02, 0));
    if (by_tilt) result.trial.tilt = recording::TiltMatch{.moved_before = by_tilt};
    Fitter fitter(nullptr, of, {}, how);
    CHECK(fitter.fit(std::span(&result, 1)));
    REQUIRE(!result.error);
    return result.explanation.fitted_rad;
  };
  const auto at_rest = fitted(protocol, request, {}), by_option = fitted(protocol, asked, {});
  CHECK(at_rest.front() == 0.0F);
  CHECK(by_option.front() != 0.0F);
  CHECK(fitted(moved, request, {}) == by_option);
  CHECK(fitted(protocol, asked, false) == fitted(protocol, request, false));
  CHECK(fitted(protocol, request, true) == fitted(moved, request, true));
  CHECK(fitted(moved, request, false).front() == 0.0F);
  CHECK(fitted(moved, asked, false) == fitted(protocol, request, false));
}

TEST_CASE("a platform that moved before a protocol for which no cycle can be simulated there is a caution") {
  const auto cautions = [](const sim::Protocol& protocol, bool moved) {
    FitRequest request;
    request.settings = quick();
    request.settings.max_leapfrog_steps = 8;
    RecordingResult result;
    result.trial = recording::make_trial(recorded(protocol, some_parameters(), 0.02, 0));
    result.trial.tilt = recording::TiltMatch{.moved_before = moved};
    Fitter fitter(nullptr, protocol, {}, request);
    CHECK(fitter.fit(std::span(&result, 1)));
    REQUIRE(!result.error);
    CHECK((result.explanation.fitted_rad.front() != 0.0F) == (moved && protocol.experiment.lead_in_s() == 0.0));
    return std::ranges::count_if(result.warnings, [](const Warning& one) {
      return one.code == "moved_before" && one.severity == Severity::caution;
    });
  };
  sim::Protocol late = sines_protocol();
  std::get<sim::Sines>(late.experiment.stimulus).lead_in_s = 1.0;
  late.noise.vestibular.period_s = 0.0;
  CHECK(cautions(sines_protocol(), true) == 0);
  CHECK(cautions(late, false) == 0);
  CHECK(cautions(late, true) == 1);
}

TEST_CASE("a recording with an oscillation that the draws do not have is a caution") {
  const std::vector<float> sway = recorded(sines_protocol(), some_parameters(), 0.02, 0);
  std::vector<RecordingResult> read(2);
  read[0].trial = recording::make_trial(sway);
  std::vector<float> shaken = sway;
  for (std::size_t k = 0; k < shaken.size(); ++k)
    shaken[k] +=
        static_cast<float>(0.5 * sim::rad_per_deg * std::sin(2.0 * sim::pi * 2.0 * static_cast<double>(k) / 100.0));
  read[1].trial = recording::make_trial(shaken);
  Fitter fitter(nullptr, sines_protocol(), {}, quick_request());
  CHECK(fitter.fit(read));
  const auto severity = [](const RecordingResult& result) -> std::optional<Severity> {
    for (const Warning& one : result.warnings)
      if (one.code == "unlike_simulated") return one.severity;
    return {};
  };
  CHECK_FALSE(severity(read[0]));
  CHECK(severity(read[1]) == Severity::caution);
}

TEST_CASE("a constant recording, and one with too many gaps, is an error of its own, also among several of a person") {
  std::vector<RecordingResult> read = of_one_participant(), alone = of_one_participant();
  for (const std::size_t constant : {std::size_t{2}, std::size_t{3}})
    read[constant].trial = recording::make_trial(std::vector<float>(2000, 0.0F));
  read[3].trial.tilt.emplace().is_other_size = true;  // the group leaves it out
  read[1].error.reset();
  read[1].trial.gaps = {{100, 1900}};
  Fitter fitter(nullptr, sines_protocol(), {}, quick_request());
  const FitGroup group{{0, 1, 2, 3}, {}};
  CHECK(fit_each(
      read, [&](std::size_t) -> Fitter& { return fitter; }, {}, {}, std::span(&group, 1)));
  for (const std::size_t constant : {std::size_t{2}, std::size_t{3}}) {
    REQUIRE(read[constant].error);
    CHECK(read[constant].error->code() == Code::value_invalid);
    CHECK(contains(read[constant].error->where(), read[constant].file));
    CHECK_FALSE(read[constant].fit);
  }
  REQUIRE(read[1].error);
  CHECK(read[1].error->code() == Code::value_missing);
  // The group's only other recording has the bits and the warnings of a fit of its own.
  REQUIRE(!read[0].error);
  CHECK(fitter.fit(std::span(alone).first(1)));
  CHECK(read[0].fit->posterior.mean(sim::Kp) == alone[0].fit->posterior.mean(sim::Kp));
  CHECK(read[0].warnings.size() == alone[0].warnings.size());
}

TEST_CASE("a recording that the group leaves out is fitted alone; a stop marks the fits that it cut") {
  std::vector<RecordingResult> read = of_one_participant();
  read[2].trial.tilt_at_given_start.emplace().is_other_size = true;
  CHECK(reason_to_leave_out(read[2]) == "tilt_of_other_size");
  read[2].trial.tilt_at_given_start.reset();
  CHECK(reason_to_leave_out(read[2]).empty());
  read[2].trial.tilt.emplace().is_other_size = true;
  CHECK(reason_to_leave_out(read[2]) == "tilt_of_other_size");
  Fitter fitter(nullptr, sines_protocol(), {}, quick_request());
  const FitGroup group{{2, 0, 3}, {}};
  const auto run = [&](const FitProgress& progress) {
    return fit_each(
        read, [&](std::size_t) -> Fitter& { return fitter; }, progress, {}, std::span(&group, 1));
  };
  // The first run that draws is that of the recording that is left out, the second the others'.
  int runs = 0;
  CHECK_FALSE(run([&](std::size_t recording, const posterior::Progress& here) {
    const bool begins = recording == 2 && std::string(here.stage) == "drawing" && here.done < 0.75;
    return !begins || ++runs < 2;
  }));
  REQUIRE(read[2].fit);
  CHECK_FALSE(read[2].fit->stopped);
  CHECK_FALSE(read[2].fit->joint);
  REQUIRE(read[0].fit);
  CHECK(read[0].fit->joint->files == std::vector<std::string>{"trial0.csv", "trial3.csv"});
  CHECK(read[2].fit->posterior.mean(sim::Kp) != read[0].fit->posterior.mean(sim::Kp));
  CHECK(read[0].fit->stopped);
  CHECK(read[0].fit->posterior.draws_per_chain() < quick().max_draws);

  // A stop before the first draw is the error of the recording, or of all that are fitted together.
  const auto stop = [](std::size_t, const posterior::Progress&) { return false; };
  read = of_one_participant();
  read[2].trial.tilt.emplace().is_other_size = true;
  CHECK_FALSE(run(stop));
  for (const std::size_t i : {0U, 2U, 3U}) {
    REQUIRE(read[i].error);
    CHECK(read[i].error->code() == Code::stopped);
  }

  // A stop after the last draws takes nothing away.
  read = of_one_participant();
  fitter.fit(std::span(read).last(1), [](std::size_t, const posterior::Progress& here) { return here.done < 1.0; });
  REQUIRE(read[3].fit);
  CHECK(read[3].fit->posterior.draws_per_chain() == quick().max_draws);
  CHECK_FALSE(read[3].fit->stopped);
}

TEST_CASE("a recording that hardly follows the tilt is fitted alone first, and joins the others if it is usable") {
  Fitter fitter(nullptr, sines_protocol(), {}, quick_request());
  const FitGroup group{{0, 2, 3}, {}};
  const auto files_with = [&](double gain, bool is_of_this_stimulus) {
    std::vector<RecordingResult> read = of_one_participant();
    read[2].trial.response_gain = gain;
    if (!is_of_this_stimulus) std::ranges::reverse(read[2].trial.sway_rad());
    CHECK(fit_each(
        read, [&](std::size_t) -> Fitter& { return fitter; }, {}, {}, std::span(&group, 1)));
    REQUIRE(read[2].fit);
    CHECK(read[2].fit->joint.has_value() == reason_to_leave_out(read[2]).empty());
    return read[0].fit->joint->files;
  };
  const std::vector<std::string> all{"trial0.csv", "trial2.csv", "trial3.csv"}, others{"trial0.csv", "trial3.csv"};
  CHECK(files_with(20.0, false) == others);
  CHECK(files_with(28.1, false) == all);  // it follows the tilt, so it is not fitted alone
  CHECK(files_with(20.0, true) == all);
}

namespace {

/// Runs a Butterworth low-pass of first order forwards and backwards.
std::vector<float> first_order(std::vector<float> sway, double cutoff_hz, double rate_hz) {
  const double warped = std::tan(sim::pi * cutoff_hz / rate_hz);
  for (int pass = 0; pass < 2; ++pass) {
    double in = double{sway[0]}, out = in;
    for (float& value : sway) {
      out = (warped * (double{value} + in) + (1.0 - warped) * out) / (1.0 + warped);
      in = double{std::exchange(value, static_cast<float>(out))};
    }
    std::ranges::reverse(sway);
  }
  return sway;
}

}  // namespace

TEST_CASE("a low-pass is undone before a fit; one that may delay leaves the start open; one that is unclear warns") {
  // A fit that infers the start drops `other_start`; one whose tilt gives the start, or that infers another one, keeps
  // it.
  const double rate_hz = sines_protocol().experiment.sample_rate_hz;
  std::vector<RecordingResult> read(9);
  for (RecordingResult& one : read) {
    one.file = "trial.csv";
    one.trial = recording::make_trial(recorded(sines_protocol(), some_parameters(), 0.02, 0));
  }
  // As recorded; filtered and unknown; filtered and known; unclear; with a measured tilt, and a filter that may delay;
  // with a response that starts far away; started 0.06 s late, with a response within 0.7 s of that, and within 0.7 s
  // of its negative only.
  for (const std::size_t i : {1U, 2U}) read[i].trial.sway_rad() = first_order(read[i].trial.sway_rad(), 3.0, rate_hz);
  const recording::LowPass filter{1, true, 3.0, rate_hz, 0.6, 0.6};
  read[2].trial.low_pass = filter;
  read[3].trial.low_pass = filter;
  read[3].trial.low_pass->gain_high = 0.9;
  add_caution(read[2].warnings, "smooth", "of the sway as recorded");
  for (const std::size_t i : {4U, 5U}) read[i].trial.tilt.emplace();
  for (const std::size_t i : {0U, 4U, 6U}) {
    add_caution(read[i].warnings, "other_start", "starts later");
    read[i].trial.other_start_s = i == 6U ? 2.4 : 0.2;
  }
  for (const std::size_t i : {7U, 8U}) {
    std::vector<float>& sway = read[i].trial.sway_rad();
    std::shift_left(sway.begin(), sway.end(), 6);
    add_caution(read[i].warnings, "other_start", "starts later");
    read[i].trial.other_start_s = i == 7U ? 0.7 : -0.7;
  }
  read[5].trial.low_pass = {2, false, 4.0, rate_hz, 0.95, 0.95};
  Fitter fitter(nullptr, sines_protocol(), {}, quick_request());
  REQUIRE(fitter.fit(read));
  for (const RecordingResult& one : read) REQUIRE(one.fit);

  const double as_recorded = read[0].fit->samples_noise_deg;
  CHECK(read[1].fit->samples_noise_deg < 0.9 * as_recorded);
  CHECK(near(read[2].fit->samples_noise_deg, as_recorded, 0.05));
  const auto count = [&](std::size_t i, const char* code) {
    return std::ranges::count(read[i].warnings, code, &Warning::code);
  };
  CHECK(count(2, "smooth") == 1);
  CHECK(std::ranges::find(read[2].warnings, "smooth", &Warning::code)->severity == Severity::info);
  CHECK(count(3, "smooth") == 1);
  CHECK(read[3].fit->samples_noise_deg == as_recorded);
  CHECK(read[4].fit->posterior.stddev(posterior::Density::start) == 0.0);
  CHECK(read[5].fit->posterior.stddev(posterior::Density::start) > 0.0);
  CHECK(count(0, "other_start") == 0);
  CHECK(count(4, "other_start") == 1);
  CHECK(count(6, "other_start") == 1);
  CHECK(within(read[7].fit->posterior.mean(posterior::Density::start), 0.05, 0.03));
  CHECK(count(7, "other_start") == 0);
  CHECK(count(8, "other_start") == 1);
}

TEST_CASE(
    "the network is no second answer to a fit with a fixed parameter, so chains that are roughly apart are a caution") {
  const Model model = load_model(DECID_SOURCE_DIR "/tests/golden/0.2.0/net.safetensors");
  FitRequest request = quick_request();
  request.priors.parameters.push_back({.name = "theta", .fixed = 0.002});
  for (request.settings.seed = 1; request.settings.seed <= 20; ++request.settings.seed) {
    RecordingResult one;
    one.trial = recording::make_trial(recorded(model.protocol, some_parameters(), 0.02, 0));
    Fitter fitter(&model, model.protocol, {}, request);
    REQUIRE(fitter.report().network_answers);
    CHECK(fitter.fit(std::span(&one, 1)));
    REQUIRE(one.fit);
    CHECK(one.fit->answer == FitFigures::Answer::posterior);
    CHECK(one.fit->network.has_value());
    const double rhat = one.fit->posterior.max_rhat();
    if (!(rhat > 1.1 && rhat <= 1.5)) continue;
    const auto found = std::ranges::find(one.warnings, "chains_disagree", &Warning::code);
    REQUIRE(found != one.warnings.end());
    CHECK(found->severity == Severity::caution);
    return;
  }
  FAIL("no seed has chains that are roughly apart");
}
