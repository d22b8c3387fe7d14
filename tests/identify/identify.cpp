// Identification from samples: the same whatever the way, the company and the thread, and clear about bad samples.
#include "identify/identify.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/text.hpp"
#include "dataset/sets/dataset.hpp"
#include "identify/study/study_results.hpp"
#include "tests/helpers.hpp"

namespace decid {
namespace {

using namespace test;

const Model& model() {
  static const Model one = built_in_model();
  return one;
}

/// Trials with 0.02 degrees of sensor noise, of a seed that nothing was trained on.
const dataset::Dataset& data() {
  static const dataset::Dataset one = [] {
    sim::Protocol noisy = model().protocol.ideal();
    noisy.noise.sensor = {0.02, 0.02};
    return dataset::generate({.protocol = noisy, .count = 20, .seed = 4711});
  }();
  return one;
}

std::vector<double> samples(int trial) {
  const auto sway = data().trial(trial);
  return {sway.begin(), sway.end()};
}

std::vector<recording::Trial> trials(int count) {
  std::vector<recording::Trial> made;
  for (int i = 0; i < count; ++i) {
    const auto sway = data().trial(i);
    made.push_back(recording::make_trial({sway.begin(), sway.end()}));
  }
  return made;
}

bool same(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

void check_same(const Explanation& a, const Explanation& b) {
  CHECK(a.fitted_rad == b.fitted_rad);
  CHECK(same(a.rms_residual_deg, b.rms_residual_deg));
  CHECK(same(a.variance_accounted_for, b.variance_accounted_for));
  CHECK(same(a.response_ratio, b.response_ratio));
  CHECK(same(a.ood_score, b.ood_score));
  CHECK(a.warnings == b.warnings);
  REQUIRE(a.frf.has_value() == b.frf.has_value());
  REQUIRE(a.frf->recorded.size() == b.frf->recorded.size());
  for (std::size_t i = 0; i < a.frf->recorded.size(); ++i)
    CHECK(a.frf->recorded[i].response == b.frf->recorded[i].response);
}

}  // namespace

TEST_CASE("identify: an estimate does not depend on other recordings, copies or threads") {
  Identifier together(model());
  const std::vector<Estimate> all = together.estimate(trials(20));  // more than the single-sample path takes
  const std::vector<Explanation> explained = together.explain(all, trials(20));
  REQUIRE(all.size() == 20);
  double squares = 0;
  for (int i = 0; i < 20; ++i) {
    const auto place = static_cast<std::size_t>(i);
    const RecordingResult alone = identify(model(), samples(i), 100.0);
    CHECK(alone.estimate.parameters == all[place].parameters);
    CHECK(alone.estimate.image == all[place].image);
    CHECK(alone.estimate.distance == all[place].distance);
    CHECK(alone.estimate.warnings == all[place].warnings);
    if (i % 7 == 0) check_same(alone.explanation, explained[place]);
    const auto found = model().targets.scale(alone.estimate.parameters);
    const auto truth = model().targets.scale(data().parameters[place]);
    for (std::size_t p = 0; p < found.size(); ++p) squares += std::pow(static_cast<double>(found[p] - truth[p]), 2);
  }
  // The documented MSE at this noise is 0.25. With twenty trials of seven parameters, a mean above 0.6 occurs once in
  // thousands of runs.
  CHECK(squares / (7.0 * 20.0) < 0.6);
  Identifier copy(together);
  std::vector<Estimate> here, there;
  std::thread other([&] { there = copy.estimate(trials(12)); });
  here = together.estimate(trials(12));
  other.join();
  for (std::size_t i = 0; i < here.size(); ++i) {
    CHECK(here[i].parameters == there[i].parameters);
    CHECK(here[i].parameters == all[i].parameters);
  }
}

TEST_CASE("identify: files go the same way") {
  const test::TemporaryFolder folder;
  const std::vector<double> sway = samples(3);
  std::vector<std::vector<double>> columns(2);
  for (std::size_t k = 0; k < sway.size(); ++k) {
    columns[0].push_back(static_cast<double>(k) / 100.0);
    columns[1].push_back(sway[k]);
  }
  write_file(folder / "sway.csv", csv({"time", "sway_rad"}, columns, 17));
  const Report read = identify_plan(model(), "m", make_plan({folder / "sway.csv", folder / "nothing.csv"}, {}));
  REQUIRE(read.recordings.size() == 2);
  const RecordingResult& found = read.recordings.front();
  REQUIRE(!found.error);
  const RecordingResult direct = identify(model(), sway, 100.0);
  CHECK(found.estimate.parameters == direct.estimate.parameters);
  CHECK(found.warnings == direct.warnings);
  check_same(found.explanation, direct.explanation);
  CHECK(found.column == "sway_rad");
  CHECK(read.recordings.back().error.has_value());
  CHECK(read.tilt_rad.size() == 12100);
}

TEST_CASE("identify: another rate, another start, another length") {
  const std::vector<double> sway = samples(0);
  const RecordingResult plain = identify(model(), sway, 100.0);

  std::vector<double> later(250, 0.0);  // 2.5 s before the protocol, and a second after it
  later.insert(later.end(), sway.begin(), sway.end());
  later.insert(later.end(), 100, 0.0);
  CHECK(identify(model(), later, 100.0, {.start_s = 2.5}).estimate.parameters == plain.estimate.parameters);
  const RecordingResult not_told = identify(model(), later, 100.0);
  CHECK(not_told.estimate.parameters != plain.estimate.parameters);
  CHECK(!not_told.warnings.empty());  // what was left out is said

  std::vector<double> raised = sway;
  for (double& value : raised) value += 0.06;
  const auto detrended = identify(model(), raised, 100.0, {.detrend = recording::Detrend::offset}).warnings;
  CHECK_FALSE(has(detrended, "sway_off_upright"));  // the cases of recordings.cpp have the warning

  // Two samples a sample, linearly between them: up to 4 Hz, where the network looks, that is the same sway.
  std::vector<double> fast;
  for (std::size_t k = 0; k < sway.size(); ++k) {
    fast.push_back(sway[k]);
    fast.push_back(0.5 * (sway[k] + sway[std::min(k + 1, sway.size() - 1)]));
  }
  const RecordingResult resampled = identify(model(), fast, 200.0);
  const auto a = model().targets.scale(plain.estimate.parameters),
             b = model().targets.scale(resampled.estimate.parameters);
  for (std::size_t p = 0; p < a.size(); ++p)
    CHECK(within(static_cast<double>(b[p]), static_cast<double>(a[p]), 0.25));  // of a standard deviation
}

TEST_CASE("identify: samples that are not a recording are refused") {
  const std::vector<double> sway = samples(0);
  check_error([&] { identify(model(), std::span(sway).first(6000), 100.0); }, Code::recording_too_short,
              "6000 samples");
  check_error([&] { identify(model(), {}, 100.0); }, Code::recording_too_short);
  for (const double rate : {0.0, -100.0, 1e-9, std::nan(""), std::numeric_limits<double>::infinity()})
    check_error([&] { identify(model(), sway, rate); }, Code::setting_out_of_range);
  std::vector<double> bad = sway;
  bad[777] = std::nan("");
  check_error([&] { identify(model(), bad, 100.0); }, Code::value_invalid, "sample 778");
  check_error([&] { identify(model(), std::vector<double>(12100, 0.01), 100.0); }, Code::value_invalid);
  std::vector<double> degrees = sway;  // taken for radians
  for (double& value : degrees) value /= sim::rad_per_deg / 100;
  check_error([&] { identify(model(), degrees, 100.0); }, Code::value_invalid);
  Identifier identifier(model());
  CHECK_THROWS_AS(identifier.estimate({recording::make_trial(std::vector<float>(100, 0.0F))}), Error);
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    std::vector<recording::Trial> two = trials(2);
    two[1].sway_rad()[12099] = value;
    check_error([&] { identifier.estimate(two); }, Code::value_invalid, "trial 1");
  }
  CHECK(identifier.estimate({}).empty());
  CHECK(identifier.explain({}, {}).empty());
}

TEST_CASE("identify: a model that its own validation trials show to be imprecise is a caution") {
  const auto cautions = [](std::vector<EpochLog> log, int patience) {
    Model logged = model();
    logged.log = std::move(log);
    logged.origin.patience = patience;
    return std::ranges::count_if(Identifier(logged).estimate(trials(1)).front().warnings, [](const Warning& w) {
      return w.code == "imprecise_model" && w.severity == Severity::caution;
    });
  };
  const EpochLog barely{1, 1.1, 0.78, 0.1}, better{2, 0.7, 0.59, 0.1}, worse{3, 0.6, 0.61, 0.1};
  CHECK(cautions({}, 0) == 0);  // not known
  CHECK(cautions({barely}, 0) == 1);
  CHECK(cautions({barely, better}, 0) == 0);
  CHECK(cautions({barely, better, worse}, 0) == 1);
  CHECK(cautions({barely, better, worse}, 1) == 0);  // the second epoch was kept
  for (const char* name : {"built_in", "ideal", "spectra", "firmware"}) {
    CAPTURE(name);
    const Model shipped = load_model(std::string(DECID_SOURCE_DIR "/models/") + name + ".safetensors");
    CHECK(shipped.validation_mse().value_or(0.0) < 0.5);
  }
}

TEST_CASE("identify: sway that is too large for a body is warned of once") {
  std::vector<double> large = samples(0);
  const auto [low, high] = std::ranges::minmax(large);
  for (double& value : large) value *= 25 * sim::rad_per_deg / std::max(-low, high);
  const auto about_size = [](const Warnings& warnings) {
    return std::ranges::count_if(warnings,
                                 [](const Warning& w) { return w.text.find("sway reaches 25") != w.text.npos; });
  };
  CHECK(about_size(identify(model(), large, 100.0).warnings) == 1);
  Identifier identifier(model());
  CHECK(about_size(identifier.estimate({recording::make_trial({large.begin(), large.end()})}).front().warnings) == 1);
}

TEST_CASE("identify: a reversed sway gets the hint of its sign, unless the recording's start is doubtful") {
  Identifier identifier(model());
  std::vector<recording::Trial> reversed = trials(1);
  for (float& value : reversed[0].sway_rad()) value = -value;
  for (const bool is_doubtful : {false, true}) {
    reversed[0].start_is_doubtful = is_doubtful;
    const Explanation found = identifier.explain(identifier.estimate(reversed), reversed).front();
    REQUIRE(has(found.warnings, "out_of_distribution"));
    CHECK(contains(found.unlike_training, "invert sway") != is_doubtful);
  }
}

TEST_CASE("identify: a sway of another scale or sign does not resemble the training, and gets no advice on a lean") {
  Identifier identifier(model());
  for (const float factor : {5.0F, 17.3F, -8.0F}) {
    std::vector<recording::Trial> scaled = trials(3);
    for (recording::Trial& trial : scaled)
      for (float& value : trial.sway_rad()) value *= factor;
    for (const Explanation& found : identifier.explain(identifier.estimate(scaled), scaled)) {
      CHECK(has(found.warnings, "out_of_distribution"));
      CHECK_FALSE(has(found.warnings, "slow_lean"));
    }
  }
}

TEST_CASE("identify: a sway that is the tilt, or an angle against the platform, gets a hint and none of its sign") {
  Identifier identifier(model());
  const sim::Protocol& protocol = model().protocol;
  const std::vector<double> tilt = sim::tilt_at_samples(protocol.experiment, sim::make_stimulus(protocol.experiment));
  const auto hint_of = [&](double of_sway, double of_tilt) {
    std::vector<recording::Trial> changed = trials(3);
    std::string hints;
    for (recording::Trial& trial : changed)
      for (std::size_t k = 0; k < tilt.size(); ++k)
        trial.sway_rad()[k] =
            static_cast<float>(of_sway * static_cast<double>(trial.sway_rad()[k]) + of_tilt * tilt[k]);
    for (const Explanation& found : identifier.explain(identifier.estimate(changed), changed)) {
      CHECK(has(found.warnings, "out_of_distribution"));
      CHECK_FALSE(contains(found.unlike_training, "invert"));
      hints += contains(found.unlike_training, "is the platform's tilt:")         ? 't'
               : contains(found.unlike_training, "the platform's tilt, reversed") ? 'r'
               : contains(found.unlike_training, "add the tilt")                  ? 'a'
               : contains(found.unlike_training, "subtract it")                   ? 's'
                                                                                  : '-';
    }
    return hints;
  };
  CHECK(hint_of(0.0, 1.0) == "ttt");
  CHECK(hint_of(0.0, -1.0) == "rrr");
  CHECK(hint_of(1.0, -1.0) == "aaa");
  CHECK(hint_of(-1.0, 1.0) == "sss");
}

TEST_CASE("identify: where the response cannot be measured, the warning says so in words") {
  Identifier identifier(model());
  std::vector<Estimate> estimates = identifier.estimate(trials(1));
  estimates.front().distance = 10 * model().ood_detector.usual;
  const auto unlike = [&] {
    const std::vector<Explanation> explained = identifier.explain(estimates, trials(1));
    for (const Warning& warning : explained.front().warnings) {
      CHECK_FALSE(test::contains(warning.text, "nan"));
      if (warning.code == "out_of_distribution") return warning.text;
    }
    return std::string();
  };
  CHECK(contains(unlike(), "stimulus response ratio 0."));
  sim::Parameters falling = estimates.front().parameters;
  falling[sim::Kp] = falling[sim::Kp_pass] = 0.0;
  estimates.front().parameters = falling;
  CHECK(contains(unlike(), "falls)"));
}

TEST_CASE("a body of the model's height and another weight: the same sway, parameters times its m g h") {
  sim::Body heavy = model().protocol.experiment.body;
  heavy.mass_kg *= 1.5;
  heavy.inertia_kgm2 *= 1.5;
  const std::vector<double> sway = samples(3);
  const RecordingResult as_assumed = identify(model(), sway, 100.0),
                        as_told = identify(model(), sway, 100.0, {}, heavy);
  const Estimate &assumed = as_assumed.estimate, &told = as_told.estimate;
  const sim::ParameterTable& table = model().parameters();
  for (std::size_t p = 0; p < table.size(); ++p)
    CHECK(near(told.parameters[p], assumed.parameters[p] * (table[p].scales_with_mgh ? 1.5 : 1.0), 1e-12));
  CHECK(told.distance == assumed.distance);
  CHECK(told.warnings == assumed.warnings);
  const Explanation &of_assumed = as_assumed.explanation, &of_told = as_told.explanation;
  CHECK(near(of_told.rms_residual_deg, of_assumed.rms_residual_deg, 1e-5));
  CHECK(near(of_told.response_ratio, of_assumed.response_ratio, 1e-5));
  const ForBody body = for_body(model(), "m", heavy);
  CHECK_FALSE(body.assumed);
  CHECK(near(body.ranges[sim::Kp].high, 1.5 * table[sim::Kp].high, 1e-12));
  const sim::Parameters back = body.to_model(model(), told.parameters);
  for (std::size_t p = 0; p < table.size(); ++p) CHECK(near(back[p], assumed.parameters[p], 1e-12));
}

TEST_CASE("bodies of other heights: refused by a model that does not know them, else shown to the network") {
  const sim::Body taller = sim::Body{}.of_height(1.1);
  const Model of_one_height = load_model(DECID_SOURCE_DIR "/models/spectra.safetensors");
  CHECK(for_body(of_one_height, "m", {}).assumed);
  CHECK_FALSE(knows_body(of_one_height, taller));
  CHECK(knows_body(of_one_height, sim::Body{}.of_height(1.005)));
  CHECK(knows_body(model(), taller));
  check_error([&] { identify(of_one_height, samples(3), 100.0, {}, taller); }, Code::setting_out_of_range,
              "body_heights");

  sim::Protocol protocol = sim::default_protocol();
  protocol.heights = {0.8, 1.12};
  Model knowing(protocol, {.channels = {dataset::Channel::sway, dataset::Channel::height}, .block = 100},
                "conv 4 5x1; relu; statspool; fc 7");
  knowing.network.initialise(3);
  knowing.targets = of_one_height.targets;
  const Estimate own = identify(knowing, samples(3), 100.0).estimate,
                 tall = identify(knowing, samples(3), 100.0, {}, taller).estimate;
  std::vector<float> input(static_cast<std::size_t>(knowing.images().shape().size())), output(7);
  knowing.make_input(dataset::Sway(data().trial(3), 1.1), input);
  nn::Predictor(knowing.network, 1).run(input, output);
  for (std::size_t p = 0; p < 7; ++p) {
    CHECK(near(tall.parameters[p], knowing.decode(output)[p], 1e-12));  // the same m g h
    CHECK(tall.parameters[p] != own.parameters[p]);
  }
  check_error([&] { for_body(knowing, "m", sim::Body{}.of_height(1.2)); }, Code::setting_out_of_range, "body_heights");

  // Data sets of another body, and of another experiment.
  sim::Protocol trials = sim::default_protocol();
  trials.experiment.body = taller;
  CHECK(near(for_trials(knowing, "m", trials, "d.npz").height, 1.1, 1e-12));
  CHECK(for_trials(knowing, "m", protocol, "d.npz").height == 1.0);
  check_error([&] { for_trials(of_one_height, "m", trials, "d.npz"); }, Code::file_differs, "d.npz");
  trials.sequence().amplitude_deg = 2.0;
  check_error([&] { for_trials(knowing, "m", trials, "d.npz"); }, Code::file_differs, "d.npz");
}

}  // namespace decid
