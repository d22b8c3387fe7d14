// Identification through C: the bits of the C++ library, from files and samples, in many threads.
#include <cmath>
#include <thread>

#include "base/text.hpp"
#include "identify/study/study_results.hpp"
#include "nn/safetensors.hpp"
#include "sim/segments.hpp"
#include "tests/bindings/c/owned.hpp"

namespace decid {
namespace {

using namespace test;

bool same(double a, double b) {
  return a == b || (std::isnan(a) && std::isnan(b));
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
    CHECK(same(found.normalized, ranges[p].scales_with_mgh ? found.value / mgh : NAN));
    CHECK(same(found.normalized_interval90[1], ranges[p].scales_with_mgh ? found.interval90[1] / mgh : NAN));
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
  CHECK(same(figures.tilt_delay_s, id.trial.tilt ? id.trial.tilt->delay_s : NAN));
  CHECK(same(figures.tilt_correlation, id.trial.tilt ? id.trial.tilt->correlation : NAN));
  CHECK(same(figures.tilt_gain, id.trial.tilt ? id.trial.tilt->gain : NAN));
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
  return identify_plan(built_in_model(), "the model", make_plan({path}, options));
}

}  // namespace

TEST_CASE("every option reaches the library, whose bits a file and samples have, with a measured tilt or without") {
  const TemporaryFolder folder;
  const std::vector<double> sway_rad = simulated(7);
  std::vector<double> tilt_deg;
  std::string text = "time,sway_rad,platform_deg\n";
  for (std::size_t i = 0; i < sway_rad.size(); ++i) {
    tilt_deg.push_back(decid_protocol_tilt(decid_model_protocol(built_in()))[i] / sim::rad_per_deg);
    text += format("%.2f,%.17g,%.17g\n", static_cast<double>(i) * 0.01, sway_rad[i], tilt_deg[i]);
  }
  const auto path = write_text(folder / "trial.csv", text);
  decid_read_options reading;
  decid_read_defaults(&reading, sizeof reading);
  reading.tilt_column = "none";
  decid_identify_options options;
  decid_identify_defaults(&options, sizeof options);
  options.begin_s = 0.05;
  options.detrend = DECID_DETREND_LINEAR;
  ReadOptions same_options;
  same_options.recording.find_tilt = false;
  same_options.trial.start_s = 0.05;
  same_options.trial.detrend = recording::Detrend::linear;
  check_same(identify(read(path, &reading).get(), &options).get(), expected(path, same_options));

  reading.tilt_column = "platform_deg";
  decid_identify_defaults(&options, sizeof options);
  options.mass_kg = 154.0;  // pounds: a caution
  options.height_m = 1.75;
  options.detrend = DECID_DETREND_OFFSET;
  same_options = {};
  same_options.recording.tilt_column = "platform_deg";
  same_options.trial.detrend = recording::Detrend::offset;
  same_options.body = sim::make_body(sim::make_segments({.mass_kg = 154.0, .height_m = 1.75}));
  check_same(identify(read(path, &reading).get(), &options).get(), expected(path, same_options));

  decid_samples_options samples;
  decid_samples_defaults(&samples, sizeof samples);
  samples.unit = DECID_RADIANS;
  samples.tilt = tilt_deg.data();
  samples.tilt_unit = DECID_DEGREES;
  const OwnedRecording made = make<OwnedRecording>([&](decid_recording** place) {
    return decid_recording_of_samples(sway_rad.data(), sway_rad.size(), 100.0, &samples, place);
  });
  CHECK(std::string(decid_recording_column(made.get())).empty());
  same_options = {};
  same_options.recording.tilt_column = "platform_deg";
  check_same(identify(made.get()).get(), expected(path, same_options));
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
