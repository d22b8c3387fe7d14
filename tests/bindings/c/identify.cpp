// Identification through C: the bits of the C++ library, from files and samples, in many threads.
#include <cmath>
#include <cstddef>
#include <thread>

#include "base/text.hpp"
#include "identify/recordings.hpp"
#include "nn/safetensors.hpp"
#include "sim/segments.hpp"
#include "tests/bindings/c/owned.hpp"

namespace decid {
namespace {

using namespace test;

bool same(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
}

std::string csv_of(const std::vector<double>& sway_rad) {
  std::string text = "time,sway_rad,platform_deg\n";
  char line[80];
  for (std::size_t i = 0; i < sway_rad.size(); ++i) {
    std::snprintf(line, sizeof line, "%.2f,%.17g,%.17g\n", static_cast<double>(i) * 0.01, sway_rad[i],
                  decid_protocol_tilt(decid_model_protocol(built_in()))[i] / sim::rad_per_deg);
    text += line;
  }
  return text;
}

OwnedRecording read(const std::filesystem::path& path, const decid_read_options* options = nullptr) {
  return make<OwnedRecording>(
      [&](decid_recording** place) { return decid_recording_read(path.c_str(), options, place); });
}

OwnedResult identify(const decid_recording* recording, const decid_identify_options* options = nullptr) {
  return make<OwnedResult>([&](decid_result** place) { return decid_identify(built_in(), recording, options, place); });
}

/// Everything that C shows of a result is what the library found.
void check_same(const decid_result* result, const Report& all) {
  const RecordingResult& id = all.recordings.front();
  const Estimate& estimate = id.estimate;
  const double mgh = all.protocol.experiment.body.mgh();
  const sim::ParameterTable ranges = all.protocol.ranges();
  REQUIRE(decid_result_parameters(result) == ranges.size());
  CHECK(decid_result_quantities(result) == ranges.size());
  for (std::size_t p = 0; p < ranges.size(); ++p) {
    const int quantity = static_cast<int>(p);
    const decid_parameter& found = *decid_result_parameter(result, p);
    CHECK(found.name == ranges[p].name);
    CHECK(found.unit == ranges[p].unit);
    CHECK(found.low == ranges[p].low);
    CHECK(found.high == ranges[p].high);
    CHECK(found.value == estimate.parameters[p]);
    CHECK(found.sd == estimate.distribution->stddev(quantity));
    CHECK(found.interval50[0] == estimate.distribution->quantile(quantity, 0.25));
    CHECK(found.interval50[1] == estimate.distribution->quantile(quantity, 0.75));
    CHECK(found.interval90[0] == estimate.distribution->quantile(quantity, 0.5 * (1.0 - 0.9)));
    CHECK(found.interval90[1] == estimate.distribution->quantile(quantity, 1.0 - 0.5 * (1.0 - 0.9)));
    CHECK(same(found.normalized, ranges[p].per_mgh ? found.value / mgh : NAN));
    CHECK(same(found.normalized_interval90[1], ranges[p].per_mgh ? found.interval90[1] / mgh : NAN));
    CHECK(std::isnan(found.rhat));
    CHECK(decid_result_correlation(result, p, 0) == estimate.distribution->correlation(quantity, 0));
  }
  const decid_figures& figures = *decid_result_figures(result);
  CHECK(figures.rms_residual_deg == id.explanation.rms_residual_deg);
  CHECK(figures.variance_accounted_for == id.explanation.variance_accounted_for);
  CHECK(figures.response_ratio == id.explanation.response_ratio);
  CHECK(figures.ood_score == id.explanation.ood_score);
  CHECK(figures.peak_to_peak_deg == id.peak_to_peak_deg());
  CHECK(figures.mass_kg == all.protocol.experiment.body.mass_kg);
  CHECK(figures.body_assumed == (all.body_assumed ? 1 : 0));
  CHECK(same(figures.tilt_correlation, id.trial.tilt ? id.trial.tilt->correlation : NAN));
  const Warnings& warnings = id.warnings;
  REQUIRE(decid_result_warnings(result) == warnings.size());
  for (std::size_t i = 0; i < warnings.size(); ++i) {
    const decid_warning& warning = *decid_result_warning(result, i);
    CHECK(warning.code == warnings[i].code);
    CHECK(warning.text == warnings[i].text);
    CHECK(static_cast<int>(warning.severity) == static_cast<int>(warnings[i].severity));
  }
  CHECK(static_cast<int>(decid_result_trust(result)) == static_cast<int>(id.trust()));
  std::size_t samples = 0;
  const float* values = decid_result_sway(result, &samples);
  CHECK(std::vector<float>(values, values + samples) == id.trial.sway_rad());
  values = decid_result_fitted(result, &samples);
  CHECK(std::vector<float>(values, values + samples) == id.explanation.fitted_rad);
  CHECK(decid_result_sampling(result) == nullptr);
  CHECK(decid_result_draws(result, 0) == nullptr);
}

Report expected(const std::filesystem::path& path, const ReadOptions& options) {
  return identify_files(built_in_model(), "the model", {path}, options);
}

}  // namespace

TEST_CASE("sway of leg and trunk, of markers and of positions is the library's") {
  const TemporaryFolder folder;
  std::string text = "Laboratory 3\ntime,leg_deg,trunk_deg,hip,shoulder\n";
  for (int k = 0; k < 300; ++k)
    text += format("%.2f,%.6f,%.6f,%.6f,%.6f\n", k / 100.0, std::sin(0.1 * k), std::cos(0.3 * k), std::sin(0.1 * k),
                   std::cos(0.2 * k));
  const auto path = write_text(folder / "parts.csv", text);
  const auto check = [&](const decid_read_options& options, const recording::RecordingOptions& same_options) {
    const OwnedRecording made = read(path, &options);
    const recording::Recording expected = recording::read_recording(path, same_options);
    const auto& rad = expected.signals.at(recording::com_sway).rad;
    REQUIRE(decid_recording_samples(made.get()) == rad.size());
    CHECK(std::equal(rad.begin(), rad.end(), decid_recording_sway(made.get())));
  };
  decid_read_options options;
  decid_read_defaults(&options, sizeof options);
  options.leg_column = "leg_deg";
  options.trunk_column = "trunk_deg";
  check(options, {.leg_column = "leg_deg", .trunk_column = "trunk_deg"});
  options.skip_lines = 1;
  check(options, {.leg_column = "leg_deg", .trunk_column = "trunk_deg"});
  decid_read_defaults(&options, sizeof options);
  options.unit = DECID_CENTIMETRES;
  options.hip_column = "hip";
  options.shoulder_column = "shoulder";
  options.ankle_column = "leg_deg";
  options.body_height_m = 1.7;
  check(options, {.hip_column = "hip",
                  .shoulder_column = "shoulder",
                  .ankle_column = "leg_deg",
                  .body_height_m = 1.7,
                  .metres_per_unit = 0.01});
  decid_read_defaults(&options, sizeof options);
  options.unit = DECID_METRES;
  options.column = "hip";
  options.com_height_m = 3.0;
  check(options, {.column = "hip", .com_height_m = 3.0, .metres_per_unit = 1.0});
}

TEST_CASE("a number stands for a missing value where a caller says so") {
  const TemporaryFolder folder;
  std::string text = "time,sway_deg\n";
  for (int k = 0; k < 60; ++k) text += format("%.2f,%.2f\n", k / 100.0, k == 30 ? -77.5 : 0.01 * k);
  const auto path = write_text(folder / "gap.csv", text);
  decid_read_options options;
  decid_read_defaults(&options, sizeof options);
  options.fill_gaps_s = 0.1;
  const double missing = -77.5;
  options.missing_value = &missing;
  const OwnedRecording filled = read(path, &options);
  CHECK(near(double{decid_recording_sway(filled.get())[30]}, 0.3 * sim::rad_per_deg, 1e-6));
  options.missing_value = nullptr;
  const OwnedRecording plain = read(path, &options);
  CHECK(near(double{decid_recording_sway(plain.get())[30]}, -77.5 * sim::rad_per_deg, 1e-6));
}

TEST_CASE("a sway whose offset will be subtracted is not too large") {
  const TemporaryFolder folder;
  std::string text = "time,sway_deg\n";
  std::vector<double> sway;
  for (int k = 0; k < 60; ++k) {
    sway.push_back(25.0 + 0.01 * k);
    text += format("%.2f,%.2f\n", k / 100.0, sway.back());
  }
  const auto path = write_text(folder / "offset.csv", text);
  const auto is_large = [](const OwnedRecording& recording) {
    for (std::size_t i = 0; i < decid_recording_warnings(recording.get()); ++i)
      if (std::string(decid_recording_warning(recording.get(), i)->code) == "large_sway") return true;
    return false;
  };
  for (const bool upright : {false, true}) {
    decid_read_options options;
    decid_read_defaults(&options, sizeof options);
    options.mean_is_upright = upright ? 1 : 0;
    CHECK(is_large(read(path, &options)) == !upright);
    decid_samples_options how;
    decid_samples_defaults(&how, sizeof how);
    how.unit = DECID_DEGREES;
    how.mean_is_upright = options.mean_is_upright;
    decid_recording* made = nullptr;
    REQUIRE(decid_recording_of_samples(sway.data(), sway.size(), 100.0, &how, &made) == DECID_OK);
    CHECK(is_large(OwnedRecording(made)) == !upright);
  }
}

TEST_CASE("a file's tables and its recordings are read as the library reads them") {
  const TemporaryFolder folder;
  const auto rows = [](int phase) {
    std::string text;
    for (int k = 0; k < 60; ++k) text += format("%.2f,%.6f\n", k / 100.0, std::sin(0.1 * k + phase));
    return text;
  };
  const auto check = [](const std::filesystem::path& path, const decid_read_options& options,
                        const recording::RecordingOptions& same_options, std::size_t samples) {
    const OwnedRecording made = read(path, &options);
    const recording::Recording expected = recording::read_recording(path, same_options);
    const auto& rad = expected.signals.at(recording::com_sway).rad;
    REQUIRE(rad.size() == samples);
    REQUIRE(decid_recording_samples(made.get()) == samples);
    CHECK(std::equal(rad.begin(), rad.end(), decid_recording_sway(made.get())));
  };
  decid_read_options options;
  decid_read_defaults(&options, sizeof options);
  const auto sections = write_text(folder / "sections.csv",
                                   "Devices\ntime,sway_deg\n" + rows(0) + "\nTrajectories\ntime,sway_deg\n" + rows(1));
  options.section = "Trajectories";
  check(sections, options, {.section = "Trajectories"}, 60);
  options.section = "1";
  check(sections, options, {.section = "1"}, 60);

  std::string text = "subject,block,time,sway_deg\n";
  for (int k = 0; k < 120; ++k)
    text += format("s0%d,%d,%.2f,%.6f\n", 1 + k / 60, 1 + k / 30 % 2, k % 30 / 100.0, std::sin(0.1 * k));
  const auto path = write_text(folder / "long.csv", text);
  decid_read_defaults(&options, sizeof options);
  options.trial_column = "subject,block";
  const auto trials = make<std::unique_ptr<decid_trials, Freed<decid_trials_free>>>(
      [&](decid_trials** place) { return decid_trials_read(path.c_str(), &options, place); });
  REQUIRE(decid_trials_count(trials.get()) == 4);
  CHECK(std::string(decid_trials_name(trials.get(), 2)) == "s02,1");
  CHECK(decid_trials_name(trials.get(), 4) == nullptr);
  options.trial = decid_trials_name(trials.get(), 2);
  check(path, options, {.trial_column = "subject,block", .trial = "s02,1"}, 30);
  decid_read_defaults(&options, sizeof options);
  options.trial_column = "none";
  std::string blocks = "block,time,sway_deg\n";
  for (int k = 0; k < 120; ++k) blocks += format("%d,%.2f,%.6f\n", 1 + k / 60, k / 100.0, std::sin(0.1 * k));
  check(write_text(folder / "blocks.csv", blocks), options, {.is_one_trial = true}, 120);
}

TEST_CASE("a file is identified to the bits of the library, with a body and a measured tilt or without") {
  const TemporaryFolder folder;
  const auto path = write_text(folder / "trial.csv", csv_of(simulated(7)));
  decid_read_options reading;
  decid_read_defaults(&reading, sizeof reading);
  reading.column = "sway_rad";
  check_same(identify(read(path, &reading).get()).get(),
             expected(path, {.recording = {.column = "sway_rad"}, .trial = {}, .truth = {}}));

  reading.tilt_column = "platform_deg";
  decid_identify_options options;
  decid_identify_defaults(&options, sizeof options);
  options.mass_kg = 70.0;
  options.height_m = 1.75;
  options.detrend = DECID_DETREND_OFFSET;
  const OwnedRecording recording = read(path, &reading);
  CHECK(std::string(decid_recording_column(recording.get())) == "sway_rad");
  CHECK(decid_recording_rate_hz(recording.get()) == 100.0);
  REQUIRE(decid_recording_tilt(recording.get()) != nullptr);
  ReadOptions same_options;
  same_options.recording.column = "sway_rad";
  same_options.recording.tilt_column = "platform_deg";
  same_options.trial.detrend = recording::Detrend::offset;
  same_options.body = sim::make_body(sim::make_segments({.mass_kg = 70.0, .height_m = 1.75}));
  check_same(identify(recording.get(), &options).get(), expected(path, same_options));
}

TEST_CASE("samples in degrees give the result of a file in degrees") {
  std::vector<double> degrees = simulated(8);
  for (double& value : degrees) value /= sim::rad_per_deg;
  std::string text = "sway_deg\n";
  char line[40];
  for (const double value : degrees) {
    std::snprintf(line, sizeof line, "%.17g\n", value);
    text += line;
  }
  const TemporaryFolder folder;
  const auto path = write_text(folder / "trial.csv", text);
  const OwnedRecording recording = make<OwnedRecording>([&](decid_recording** place) {
    return decid_recording_of(degrees.data(), degrees.size(), 100.0, DECID_DEGREES, place);
  });
  ReadOptions options;
  options.recording.rate_hz = 100.0;
  check_same(identify(recording.get()).get(), expected(path, options));
}

namespace {

OwnedRecording make_tilted(const std::vector<double>& sway, const decid_samples_options& options) {
  return make<OwnedRecording>([&](decid_recording** place) {
    return decid_recording_of_samples(sway.data(), sway.size(), 100.0, &options, place);
  });
}

bool has_code(const decid_result* result, const std::string& code) {
  for (std::size_t i = 0; i < decid_result_warnings(result); ++i)
    if (decid_result_warning(result, i)->code == code) return true;
  return false;
}

}  // namespace

TEST_CASE("a body that few people have is warned of, as by the program") {
  const OwnedRecording recording = make_recording(simulated(7));
  decid_identify_options options;
  decid_identify_defaults(&options, sizeof options);
  options.height_m = 1.75;
  options.mass_kg = 70.0;
  CHECK_FALSE(has_code(identify(recording.get(), &options).get(), "implausible_body"));
  options.mass_kg = 154.0;  // pounds
  const OwnedResult result = identify(recording.get(), &options);
  CHECK(has_code(result.get(), "implausible_body"));
  CHECK(decid_result_trust(result.get()) != DECID_USABLE);
}

TEST_CASE("samples with a tilt give the result of a file: the tilt determines the start, and its sign and size count") {
  constexpr std::size_t before = 250;  // samples at rest, until the protocol starts
  const std::vector<double> trial = simulated(7);
  std::vector<double> sway(before, 0.0), tilt_deg(before, 0.0);
  sway.insert(sway.end(), trial.begin(), trial.end());
  for (std::size_t k = 0; k < trial.size(); ++k)
    tilt_deg.push_back(decid_protocol_tilt(decid_model_protocol(built_in()))[k] / sim::rad_per_deg);
  std::string text = "time,sway_rad,platform_deg\n";
  for (std::size_t k = 0; k < sway.size(); ++k)
    text += format("%.2f,%.17g,%.17g\n", 0.01 * static_cast<double>(k), sway[k], tilt_deg[k]);
  const TemporaryFolder folder;
  const Report of_file =
      expected(write_text(folder / "log.csv", text),
               {.recording = {.column = "sway_rad", .tilt_column = "platform_deg"}, .trial = {}, .truth = {}});

  decid_samples_options options;
  decid_samples_defaults(&options, sizeof options);
  options.unit = DECID_RADIANS;
  options.tilt_unit = DECID_DEGREES;
  options.tilt = tilt_deg.data();
  const OwnedRecording recording = make_tilted(sway, options);
  REQUIRE(decid_recording_tilt(recording.get()) != nullptr);
  CHECK(decid_recording_tilt(recording.get())[before + 3000] == tilt_deg[before + 3000] * sim::rad_per_deg);
  CHECK(std::string(decid_recording_column(recording.get())).empty());
  const OwnedResult found = identify(recording.get());
  check_same(found.get(), of_file);
  const decid_figures& figures = *decid_result_figures(found.get());
  CHECK(std::abs(figures.tilt_delay_s - 2.5) < 0.001);  // a tenth of a sample, as tests/recording/trial.cpp says
  CHECK(figures.tilt_correlation > 0.999);
  CHECK(std::abs(figures.tilt_gain - 1.0) < 0.002);

  // Both inverted are the same log, and one alone is refused.
  std::vector<double> other_sway = sway, other_tilt = tilt_deg;
  for (double& value : other_sway) value = -value;
  for (double& value : other_tilt) value = -value;
  options.tilt = other_tilt.data();
  decid_result* none = nullptr;
  refused(decid_identify(built_in(), make_tilted(sway, options).get(), nullptr, &none), Code::protocol_mismatch,
          "the other sign");
  CHECK(none == nullptr);
  options.invert_tilt = 1;
  options.invert_sway = 1;
  check_same(identify(make_tilted(other_sway, options).get()).get(), of_file);

  // A platform that tilts 1.25 times as far, in the sway's unit.
  for (double& value : other_tilt) value *= -1.25 * sim::rad_per_deg;
  decid_samples_defaults(&options, sizeof options);
  options.unit = DECID_RADIANS;
  options.tilt = other_tilt.data();
  const OwnedResult large = identify(make_tilted(sway, options).get());
  CHECK(std::abs(decid_result_figures(large.get())->tilt_gain - 1.25 * figures.tilt_gain) < 1e-9);
  CHECK(has_code(large.get(), "tilt_of_other_size"));
  CHECK_FALSE(has_code(found.get(), "tilt_of_other_size"));

  // Options of an older header, which has no inversion: it reads neither.
  decid_samples_options older = options;
  older.size = offsetof(decid_samples_options, invert_sway);
  older.invert_sway = 1;
  const OwnedRecording same_sway = make_tilted(sway, older);
  CHECK(std::equal(sway.begin(), sway.end(), decid_recording_sway(same_sway.get())));
}

TEST_CASE("one model serves many threads, each with errors of its own") {
  const OwnedRecording first = make_recording(simulated(7)), second = make_recording(simulated(8));
  const double alone[] = {decid_result_parameter(identify(first.get()).get(), 0)->value,
                          decid_result_parameter(identify(second.get()).get(), 0)->value};
  CHECK(alone[0] != alone[1]);
  double together[8] = {};
  std::string errors[8];
  {
    std::vector<std::thread> threads;
    for (int i = 0; i < 8; ++i)
      threads.emplace_back([&, i] {
        decid_result* result = nullptr;
        decid_identify(built_in(), i % 2 == 0 ? first.get() : second.get(), nullptr, &result);
        together[i] = decid_result_parameter(result, 0)->value;
        decid_result_free(result);
        decid_model* none = nullptr;
        decid_model_load(("none" + std::to_string(i)).c_str(), &none);
        errors[i] = decid_error_where();
      });
    for (std::thread& thread : threads) thread.join();
  }
  for (int i = 0; i < 8; ++i) {
    CHECK(together[i] == alone[i % 2]);
    CHECK(errors[i] == "none" + std::to_string(i));
  }
}

TEST_CASE("a model shows its network, and is saved as it is") {
  const Model model = built_in_model();
  CHECK(decid_model_sha256(built_in()) == nn::weights_sha256(model.network));
  CHECK(decid_model_head(built_in()) == model.head->name());
  REQUIRE(decid_model_layers(built_in()) == model.network.layers().size());
  for (std::size_t i = 0; i < model.network.layers().size(); ++i) {
    const decid_layer& layer = *decid_model_layer(built_in(), i);
    CHECK(layer.text == model.network.layers()[i].text());
    CHECK(layer.output_shape[0] == static_cast<std::size_t>(model.network.layers()[i].dst_shape().channels));
    CHECK(layer.flops == static_cast<std::uint64_t>(model.network.layers()[i].flops()));
  }
  nn::TensorFile file;
  nn::save_network(model.network, file);
  REQUIRE(decid_model_tensors(built_in()) == file.tensors.size());
  for (std::size_t i = 0; i < file.tensors.size(); ++i) {
    const decid_tensor& tensor = *decid_model_tensor(built_in(), i);
    CHECK(tensor.name == file.tensors[i].name);
    CHECK(std::equal(file.tensors[i].shape.begin(), file.tensors[i].shape.end(), tensor.shape,
                     tensor.shape + tensor.dimensions));
    CHECK(std::equal(file.tensors[i].values.begin(), file.tensors[i].values.end(), tensor.values));
  }
  const TemporaryFolder folder;
  const auto path = folder / "model.safetensors";
  REQUIRE(decid_model_save(built_in(), path.c_str()) == DECID_OK);
  CHECK(read_text(path) == read_text(DECID_SOURCE_DIR "/models/built_in.safetensors"));
  const OwnedModel again = make<OwnedModel>([&](decid_model** place) { return decid_model_load(path.c_str(), place); });
  CHECK(std::string(decid_model_sha256(again.get())) == decid_model_sha256(built_in()));
}

}  // namespace decid
