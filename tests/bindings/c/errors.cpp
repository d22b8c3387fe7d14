// Errors of the C interface: each call returns only a status, and no exception leaves it.
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include "base/text.hpp"
#include "tests/bindings/c/owned.hpp"

namespace decid {

using namespace test;

// ABI 1: these may grow at their ends, no more.
static_assert(sizeof(void*) != 8 ||
              (offsetof(decid_parameter, effective_draws) == 112 && offsetof(decid_figures, body_assumed) == 88 &&
               offsetof(decid_sampling, seconds) == 32 && offsetof(decid_tensor, shape) == 24 &&
               offsetof(decid_layer, flops) == 56 && offsetof(decid_warning, text) == 16 &&
               offsetof(decid_parameter_info, scales_with_mgh) == 40));
static_assert(sizeof(void*) != 8 ||
              (offsetof(decid_read_options, ankle_column) == 112 && offsetof(decid_identify_options, detrend) == 32 &&
               offsetof(decid_samples_options, invert_tilt) == 28 && offsetof(decid_fit_options, user) == 96 &&
               offsetof(decid_dataset_options, user) == 40 && offsetof(decid_train_options, user) == 112 &&
               offsetof(decid_training, learning_rate) == 40 && offsetof(decid_evaluation, log_score) == 296));

TEST_CASE("the version is the header's") {
  CHECK(decid_abi() == DECID_ABI);
  CHECK(std::string(decid_version()) == DECID_VERSION);
}

// decid.h names these in brackets.
TEST_CASE("defaults are those of the header's comments") {
  decid_fit_options fit;
  decid_fit_defaults(&fit, sizeof fit);
  CHECK(fit.prior_start_s == 0.1);
  CHECK(fit.prior_gain == 0.06);
  CHECK(fit.prior_noise_deg == 0.02);
  CHECK(fit.max_draws == 160);
  CHECK(fit.seed == 1);
  CHECK(std::isnan(fit.begin_s));
  decid_study_options study;
  decid_study_defaults(&study, sizeof study);
  CHECK(study.max_draws == 160);
  CHECK(study.seed == 1);
  decid_train_options train;
  decid_train_defaults(&train, sizeof train);
  CHECK(train.stream_trials == 25600);
  CHECK(train.validation_trials == 1000);
  CHECK(train.seed == 1);
  CHECK(std::string(train.preset) == "best");
  CHECK(train.momentum == -1.0);
}

TEST_CASE("bad input gives where, what and a remedy, and no handle") {
  decid_model* model = reinterpret_cast<decid_model*>(1);
  refused(decid_model_load("no/such.safetensors", &model), Code::file_missing, "no/such.safetensors");
  CHECK(model == nullptr);
  refused(decid_model_load("", &model), Code::setting_missing, "decid_model_load");
  refused(decid_model_load(nullptr, nullptr), Code::setting_missing, "decid_model_load");
  const TemporaryFolder folder;
  refused(decid_model_load(write_text(folder / "model", "x").c_str(), &model), Code::file_damaged);
  refused(decid_model_save(built_in(), "/no/such/folder/model"), Code::file_unwritable, "/no/such/folder");

  decid_protocol* none = nullptr;
  refused(decid_protocol_load("no.json", &none), Code::file_missing, "no.json");
  refused(decid_protocol_load(nullptr, &none), Code::setting_missing, "decid_protocol_load");

  decid_recording* recording = nullptr;
  refused(decid_recording_read("no.csv", nullptr, &recording), Code::file_missing, "no.csv");
  const double sway[] = {0.0, 0.01, NAN};
  refused(decid_recording_of(sway, 3, 100.0, DECID_RADIANS, &recording), Code::value_invalid, "sample 3");
  refused(decid_recording_of(sway, 2, 0.0, DECID_RADIANS, &recording), Code::setting_out_of_range, "0 Hz");
  refused(decid_recording_of(sway, 2, 100.0, DECID_BY_NAME, &recording), Code::unit_unknown);
  refused(decid_recording_of(sway, 2, 100.0, 9, &recording), Code::setting_unknown, "there is no unit 9");
  refused(decid_recording_of(nullptr, 2, 100.0, DECID_RADIANS, &recording), Code::setting_missing);
  for (const std::size_t samples : {SIZE_MAX, SIZE_MAX / 8})
    refused(decid_recording_of(sway, samples, 100.0, DECID_RADIANS, &recording), Code::setting_out_of_range,
            std::to_string(samples) + " samples");
  CHECK(recording == nullptr);
  for (const int threads : {0, -1, 1025, 100000})
    refused(decid_set_threads(threads), Code::setting_out_of_range, "threads: is " + std::to_string(threads));
}

TEST_CASE("a part of a file is refused unless it is plain which") {
  const TemporaryFolder folder;
  std::string text = "subject,time,sway_deg\n";
  for (int k = 0; k < 60; ++k) text += format("s%d,%.2f,%.3f\n", k / 30, 0.01 * (k % 30), std::sin(0.3 * k));
  const auto path = write_text(folder / "long.csv", text);
  decid_read_options options;
  decid_read_defaults(&options, sizeof options);
  decid_recording* recording = nullptr;
  decid_trials* trials = nullptr;
  const auto refused_to_read = [&](Code code, std::string_view fact = {}) {
    refused(decid_recording_read(path.c_str(), &options, &recording), code, fact);
  };
  const auto refused_to_list = [&](Code code, std::string_view fact = {}) {
    refused(decid_trials_read(path.c_str(), &options, &trials), code, fact);
  };
  refused_to_list(Code::setting_missing, "decid_trials_read");
  options.trial = "s0";
  refused_to_read(Code::setting_missing, "decid_recording_read");
  options.trial_column = "none";
  refused_to_read(Code::setting_missing, "decid_recording_read");
  options.trial_column = "subject";
  options.trial = nullptr;
  refused_to_read(Code::recording_ambiguous, "'s0', 's1'");
  decid_trials* listed = nullptr;
  REQUIRE(decid_trials_read(path.c_str(), &options, &listed) == DECID_OK);
  CHECK(decid_trials_count(listed) == 2);
  CHECK(std::string(decid_trials_name(listed, 1)) == "s1");
  CHECK(decid_trials_name(listed, 2) == nullptr);
  decid_trials_free(listed);
  decid_read_defaults(&options, sizeof options);
  options.section = "Trajectories";
  options.skip_lines = 0;
  refused_to_read(Code::setting_conflict, "decid_recording_read");
  refused_to_list(Code::setting_conflict, "decid_trials_read");
  options.section = nullptr;
  options.skip_lines = -2;
  refused_to_read(Code::setting_out_of_range, "skip_lines");
  refused(decid_trials_read("no.csv", nullptr, &trials), Code::setting_missing, "trial_column");
  refused(decid_trials_read(nullptr, nullptr, &trials), Code::setting_missing);
  CHECK(recording == nullptr);
  CHECK(trials == nullptr);
  CHECK(decid_trials_count(nullptr) == 0);
  CHECK(decid_trials_name(nullptr, 0) == nullptr);
  decid_trials_free(nullptr);
}

TEST_CASE("a tilt is an angle, and gaps have a length from 0 to 60 s") {
  const TemporaryFolder folder;
  std::string text = "time,sway_deg,tilt\n";
  for (int k = 0; k < 60; ++k) text += format("%.2f,%.3f,%.3f\n", 0.01 * k, std::sin(0.3 * k), std::sin(0.1 * k));
  const auto path = write_text(folder / "tilted.csv", text);
  decid_read_options options;
  decid_read_defaults(&options, sizeof options);
  decid_recording* recording = nullptr;
  for (const int unit : {DECID_MILLIMETRES, DECID_CENTIMETRES, DECID_METRES}) {
    options.tilt_unit = unit;
    refused(decid_recording_read(path.c_str(), &options, &recording), Code::unit_unknown, "tilt_unit");
  }
  options.tilt_unit = DECID_DEGREES;
  for (const double gap_s : {-5.0, 60.5, static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    options.fill_gaps_s = gap_s;
    refused(decid_recording_read(path.c_str(), &options, &recording), Code::setting_out_of_range, "fill_gaps_s");
  }
  CHECK(recording == nullptr);
  options.fill_gaps_s = 60.0;
  options.tilt_column = "tilt";
  make<OwnedRecording>([&](decid_recording** place) { return decid_recording_read(path.c_str(), &options, place); });
}

TEST_CASE("a tilt in memory has finite angles and a sway") {
  std::vector<double> sway(300), tilt(300);
  for (std::size_t k = 0; k < sway.size(); ++k) sway[k] = tilt[k] = 0.01 * std::sin(0.05 * static_cast<double>(k));
  decid_samples_options options;
  decid_recording* recording = nullptr;
  const auto refused_to_make = [&](Code code, std::string_view fact = {}) {
    refused(decid_recording_of_samples(sway.data(), sway.size(), 100.0, &options, &recording), code, fact);
  };
  decid_samples_defaults(&options, sizeof options);
  refused_to_make(Code::unit_unknown, "decid_recording_of_samples");
  refused(decid_recording_of_samples(sway.data(), sway.size(), 100.0, nullptr, &recording), Code::unit_unknown);
  options.unit = DECID_METRES;
  refused_to_make(Code::unit_unknown);
  options.unit = DECID_RADIANS;
  options.invert_tilt = 1;
  refused_to_make(Code::setting_missing, "invert_tilt");
  options.invert_tilt = 0;
  options.tilt_unit = DECID_DEGREES;
  refused_to_make(Code::setting_missing, "tilt_unit");
  options.tilt = tilt.data();
  options.tilt_unit = DECID_CENTIMETRES;
  refused_to_make(Code::unit_unknown, "tilt_unit");
  options.tilt_unit = 9;
  refused_to_make(Code::setting_unknown, "there is no unit 9");
  options.tilt_unit = DECID_BY_NAME;
  tilt[4] = INFINITY;
  refused_to_make(Code::value_invalid, "sample 5 (counted from 1) of the tilt");
  tilt[4] = 0.0;
  refused(decid_recording_of_samples(nullptr, 300, 100.0, &options, &recording), Code::setting_missing, "sway");
  CHECK(recording == nullptr);
}

TEST_CASE("messages name the caller's fields, or plain names for bindings to other languages") {
  const TemporaryFolder folder;
  std::string text = "time,sway_deg,leg\n";
  for (int k = 0; k < 60; ++k) text += format("%.2f,%.3f,%.3f\n", 0.01 * k, std::sin(0.3 * k), std::cos(0.3 * k));
  const auto path = write_text(folder / "short.csv", text);
  const OwnedRecording recording =
      make<OwnedRecording>([&](decid_recording** place) { return decid_recording_read(path.c_str(), nullptr, place); });
  decid_identify_options options;
  decid_identify_defaults(&options, sizeof options);
  options.begin_s = 130.0;
  decid_read_options reading;
  decid_read_defaults(&reading, sizeof reading);
  reading.leg_column = "leg";
  decid_result* result = nullptr;
  decid_recording* none = nullptr;
  refused(decid_identify(built_in(), recording.get(), &options, &result), Code::setting_out_of_range, " begin_s ");
  refused(decid_recording_read(path.c_str(), &reading, &none), Code::setting_missing, "leg_column, trunk_column");
  REQUIRE(decid_name_settings(DECID_PLAIN_NAMES) == DECID_OK);
  refused(decid_identify(built_in(), recording.get(), &options, &result), Code::setting_out_of_range, " begin ");
  refused(decid_recording_read(path.c_str(), &reading, &none), Code::setting_missing, "leg, trunk");
  REQUIRE(decid_name_settings(DECID_FIELD_NAMES) == DECID_OK);
  refused(decid_identify(built_in(), recording.get(), &options, &result), Code::setting_out_of_range, " begin_s ");
  refused(decid_name_settings(2), Code::setting_unknown, "names 2");
  CHECK(result == nullptr);
  CHECK(none == nullptr);
}

TEST_CASE("identification refuses one half of a body, other numbers than a detrending's, and NULL") {
  decid_result* result = nullptr;
  const OwnedRecording recording = make_recording(simulated(7));
  decid_identify_options options;
  decid_identify_defaults(&options, sizeof options);
  options.mass_kg = 70.0;
  refused(decid_identify(built_in(), recording.get(), &options, &result), Code::setting_missing,
          "mass_kg is given without height_m");
  options.height_m = 1.75;
  options.detrend = 7;
  refused(decid_identify(built_in(), recording.get(), &options, &result), Code::setting_unknown, "no detrending 7");
  refused(decid_identify(nullptr, recording.get(), nullptr, &result), Code::setting_missing);
  refused(decid_identify(built_in(), nullptr, nullptr, &result), Code::setting_missing);
  CHECK(result == nullptr);
}

TEST_CASE("options of another library's size are refused if it is newer, and filled up if it is older") {
  decid_result* result = nullptr;
  const OwnedRecording recording = make_recording(simulated(7));
  decid_identify_options options;
  decid_identify_defaults(&options, sizeof options);
  options.size = sizeof options + 8;
  refused(decid_identify(built_in(), recording.get(), &options, &result), Code::size_mismatch, "48");
  options.size = 0;
  refused(decid_identify(built_in(), recording.get(), &options, &result), Code::size_mismatch,
          "its options have a size of 0");
  // A header without what stands behind the body: its garbage is not read.
  decid_identify_defaults(&options, offsetof(decid_identify_options, begin_s));
  options.begin_s = -1e9;
  options.detrend = 7;
  REQUIRE(decid_identify(built_in(), recording.get(), &options, &result) == DECID_OK);
  decid_result_free(result);
}

TEST_CASE("accessors accept null and indices beyond the end") {
  CHECK(decid_model_sha256(nullptr) == nullptr);
  CHECK(decid_model_protocol(nullptr) == nullptr);
  CHECK(decid_model_layer(built_in(), 1000) == nullptr);
  CHECK(decid_model_tensor(nullptr, 0) == nullptr);
  CHECK(decid_protocol_samples(nullptr) == 0);
  CHECK(decid_protocol_tilt(nullptr) == nullptr);
  CHECK(decid_protocol_parameter(decid_model_protocol(built_in()), 7) == nullptr);
  CHECK(decid_recording_sway(nullptr) == nullptr);
  CHECK(decid_recording_warning(nullptr, 0) == nullptr);
  CHECK(decid_result_parameters(nullptr) == 0);
  CHECK(decid_result_parameter(nullptr, 0) == nullptr);
  CHECK(decid_result_trust(nullptr) == DECID_NOT_USABLE);
  CHECK(std::isnan(decid_result_correlation(nullptr, 0, 0)));
  std::size_t samples = 5;
  CHECK(decid_result_sway(nullptr, &samples) == nullptr);
  CHECK(samples == 0);
  CHECK(decid_dataset_trials(nullptr) == 0);
  CHECK(decid_dataset_sway(nullptr) == nullptr);
  const OwnedRecording recording = make_recording(simulated(7));
  CHECK(decid_recording_tilt(recording.get()) == nullptr);
  CHECK(std::string(decid_recording_column(recording.get())).empty());
  decid_result_free(nullptr);
  decid_model_free(nullptr);
  decid_protocol_free(nullptr);
  decid_recording_free(nullptr);
  decid_dataset_free(nullptr);
}

TEST_CASE("an exception of a callback ends at the border") {
  decid_dataset_options options;
  decid_dataset_defaults(&options, sizeof options);
  options.count = 10;
  options.progress = [](void*, double, const char*) -> int { throw std::logic_error("mine"); };
  decid_dataset* dataset = nullptr;
  const OwnedProtocol played = protocol("default");
  refused(decid_dataset_make(played.get(), &options, &dataset), Code::internal);
  options.progress = [](void*, double, const char*) -> int { throw 1; };
  refused(decid_dataset_make(played.get(), &options, &dataset), Code::internal);
  CHECK(dataset == nullptr);
}

}  // namespace decid
