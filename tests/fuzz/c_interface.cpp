// The C interface called in any order with hostile arguments: null handles, sizes of options that are wrong, numbers
// that are none, texts of any bytes. Contracts that C leaves to the caller are kept: arrays are as long as is said,
// texts end, a handle is freed once.
#include <fuzzer/FuzzedDataProvider.h>

#include <array>
#include <cmath>
#include <vector>

#include "bindings/c/decid.h"
#include "tests/fuzz/fuzz.hpp"

using namespace decid;

namespace {

/// Handles of one type; entry 0 is always null.
template <class Handle>
struct Handles {
  std::array<Handle*, 4> all{};
  void (*free)(Handle*);

  explicit Handles(void (*of)(Handle*)) : free(of) {}
  ~Handles() {
    for (Handle* handle : all) free(handle);
  }
  Handles(const Handles&) = delete;
  Handles& operator=(const Handles&) = delete;

  const Handle* any(FuzzedDataProvider& data) const { return all[data.ConsumeIntegralInRange<std::size_t>(0, 3)]; }
  /// Calls make(place) for a place of its own, or for none at all.
  template <class Make>
  void fill(FuzzedDataProvider& data, const Make& make) {
    const auto place = data.ConsumeIntegralInRange<std::size_t>(0, 3);
    if (place == 0) {
      REQUIRE_THAT(make(nullptr) == DECID_BAD_INPUT);
      return;
    }
    free(all[place]);
    const decid_status status = make(&all[place]);
    REQUIRE_THAT((status == DECID_OK) == (all[place] != nullptr));
    REQUIRE_THAT(status != DECID_FAILED);
  }
};

double number(FuzzedDataProvider& data) {
  constexpr double odd[]{0.0, -0.0, 1.0, -1.0, 1e300, -1e300, 1e-310, HUGE_VAL, -HUGE_VAL, 70.0, 1.75, 100.0};
  if (data.ConsumeBool()) return data.PickValueInArray(odd);
  return data.ConsumeBool() ? std::nan("") : data.ConsumeFloatingPointInRange(-1000.0, 1000.0);
}

/// A text that may be null; it lives in `kept`.
const char* text(FuzzedDataProvider& data, std::vector<std::string>& kept) {
  if (data.ConsumeBool()) return nullptr;
  constexpr const char* known[]{"short", "default", "COM_x", "2", "none", "/dev/null", "/", "", "point", "conv 4 3x3"};
  kept.push_back(data.ConsumeBool() ? data.PickValueInArray(known) : data.ConsumeRandomLengthString(40));
  return kept.back().c_str();
}

template <class Options>
void hostile_size(FuzzedDataProvider& data, Options& options) {
  if (data.ConsumeIntegralInRange(0, 7) == 0) options.size = data.ConsumeIntegral<std::size_t>();
}

int stop(void*, double, const char*) {
  return 1;
}

struct Session {
  explicit Session(FuzzedDataProvider& from) : data(from) { kept.reserve(200); }

  FuzzedDataProvider& data;
  std::vector<std::string> kept;
  Handles<decid_protocol> protocols{decid_protocol_free};
  Handles<decid_recording> recordings{decid_recording_free};
  Handles<decid_trials> trial_lists{decid_trials_free};
  Handles<decid_model> models{decid_model_free};
  Handles<decid_dataset> datasets{decid_dataset_free};
  Handles<decid_result> results{decid_result_free};
  fuzz::InputFile input{"input"};

  void load_protocol() {
    constexpr const char* tiny =
        R"({"name": "tiny", "sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1], "state_s": 0.05, "amplitude_deg": 1,
            "offset_s": 0, "cycles": 1}, "sample_rate_hz": 20})";
    const std::string path = input.write(data.ConsumeBool() ? tiny : data.ConsumeRandomLengthString(400));
    protocols.fill(data, [&](decid_protocol** place) {
      return decid_protocol_load(data.ConsumeIntegralInRange(0, 3) == 0 ? text(data, kept) : path.c_str(), place);
    });
    const decid_protocol* protocol = protocols.any(data);
    const std::size_t samples = decid_protocol_samples(protocol);
    if (const double* tilt = decid_protocol_tilt(protocol))
      REQUIRE_THAT(samples > 0 && std::isfinite(tilt[samples - 1]));
    decid_protocol_parameter(protocol, data.ConsumeIntegral<std::size_t>());
    decid_protocol_json(protocol);
    decid_protocol_rate_hz(protocol);
  }

  void simulate() {
    const decid_protocol* protocol = protocols.any(data);
    const std::size_t samples = decid_protocol_samples(protocol), count = decid_protocol_parameters(protocol);
    if (samples > 1000) return;
    const auto trials = data.ConsumeIntegralInRange<std::size_t>(0, 3);
    std::vector<double> parameters(trials * count + 1), sway(trials * samples + 1);
    for (double& value : parameters) value = number(data);
    std::vector<unsigned char> valid(trials + 1);
    decid_simulate(protocol, data.ConsumeBool() ? parameters.data() : nullptr, trials,
                   data.ConsumeIntegral<std::uint64_t>(), sway.data(), data.ConsumeBool() ? valid.data() : nullptr);
  }

  void read_recording() {
    decid_read_options options;
    decid_read_defaults(&options, sizeof options);
    const double missing = number(data);
    if (data.ConsumeBool()) {
      options.column = text(data, kept);
      options.tilt_column = text(data, kept);
      options.leg_column = text(data, kept);
      options.hip_column = text(data, kept);
      options.unit = data.ConsumeIntegralInRange(-2, 9);
      options.tilt_unit = data.ConsumeIntegralInRange(-2, 9);
      options.rate_hz = number(data);
      options.fill_gaps_s = number(data);
      options.com_height_m = number(data);
      options.body_height_m = number(data);
      options.skip_lines = data.ConsumeBool() ? -1 : data.ConsumeIntegral<int>();
      options.section = text(data, kept);
      options.trial_column = text(data, kept);
      options.trial = text(data, kept);
      options.missing_value = data.ConsumeBool() ? &missing : nullptr;
    }
    hostile_size(data, options);
    const std::string path = input.write(data.ConsumeRandomLengthString(400));
    trial_lists.fill(data, [&](decid_trials** place) { return decid_trials_read(path.c_str(), &options, place); });
    decid_trials_name(trial_lists.any(data), data.ConsumeIntegral<std::size_t>());
    recordings.fill(data, [&](decid_recording** place) {
      return decid_recording_read(data.ConsumeIntegralInRange(0, 7) == 0 ? text(data, kept) : path.c_str(), &options,
                                  place);
    });
  }

  void make_recording() {
    std::vector<double> sway(data.ConsumeIntegralInRange<std::size_t>(0, 200));
    for (std::size_t i = 0; i < sway.size(); ++i) sway[i] = 0.1 * static_cast<double>(i % 17);
    if (!sway.empty()) sway[data.ConsumeIntegralInRange<std::size_t>(0, sway.size() - 1)] = number(data);
    recordings.fill(data, [&](decid_recording** place) {
      return decid_recording_of(data.ConsumeIntegralInRange(0, 7) == 0 ? nullptr : sway.data(), sway.size(),
                                number(data), data.ConsumeIntegralInRange(-2, 9), place);
    });
    std::vector<double> tilt = sway;
    if (!tilt.empty()) tilt[data.ConsumeIntegralInRange<std::size_t>(0, tilt.size() - 1)] = number(data);
    decid_samples_options options;
    decid_samples_defaults(&options, sizeof options);
    options.unit = data.ConsumeIntegralInRange(-2, 9);
    options.tilt_unit = data.ConsumeIntegralInRange(-2, 9);
    options.tilt = data.ConsumeBool() ? nullptr : tilt.data();
    options.invert_sway = data.ConsumeBool() ? 1 : 0;
    options.invert_tilt = data.ConsumeBool() ? 1 : 0;
    hostile_size(data, options);
    recordings.fill(data, [&](decid_recording** place) {
      return decid_recording_of_samples(sway.data(), sway.size(), number(data), &options, place);
    });
    const decid_recording* recording = recordings.any(data);
    decid_recording_column(recording);
    decid_recording_tilt(recording);
    decid_recording_warning(recording, data.ConsumeIntegral<std::size_t>());
  }

  void make_dataset() {
    const decid_protocol* protocol = protocols.any(data);
    if (decid_protocol_samples(protocol) > 1000) return;
    decid_dataset_options options;
    decid_dataset_defaults(&options, sizeof options);
    options.count = data.ConsumeIntegralInRange(-2, 4);
    options.base = data.ConsumeIntegralInRange(-2, 4);
    options.progress = data.ConsumeBool() ? stop : nullptr;
    hostile_size(data, options);
    datasets.fill(data, [&](decid_dataset** place) { return decid_dataset_make(protocol, &options, place); });
    const decid_dataset* dataset = datasets.any(data);
    std::vector<float> sway(4 * decid_protocol_samples(decid_dataset_protocol(dataset)) + 1);
    const auto first = data.ConsumeIntegral<std::size_t>(), trials = data.ConsumeIntegral<std::size_t>();
    if (trials <= 4 || trials > decid_dataset_trials(dataset))
      decid_dataset_copy_sway(dataset, first, trials, sway.data());
  }

  void read_dataset() {
    const std::string path = input.write(data.ConsumeRandomLengthString(400));
    datasets.fill(data, [&](decid_dataset** place) { return decid_dataset_read(path.c_str(), place); });
  }

  void load_model() {
    const std::string path = input.write(data.ConsumeRandomLengthString(400));
    models.fill(data, [&](decid_model** place) { return decid_model_load(path.c_str(), place); });
    const decid_model* model = models.any(data);
    decid_model_tensor(model, data.ConsumeIntegral<std::size_t>());
    decid_model_layer(model, data.ConsumeIntegral<std::size_t>());
    decid_model_head(model);
  }

  void train() {
    decid_train_options options;
    decid_train_defaults(&options, sizeof options);
    options.preset = text(data, kept);
    options.architecture = data.ConsumeBool() ? "globalavgpool\nfc 7" : text(data, kept);
    options.head = text(data, kept);
    options.image = data.ConsumeBool() ? R"({"window": 10})" : text(data, kept);
    options.schedule = text(data, kept);
    options.epochs = data.ConsumeIntegralInRange(-1, 1);
    options.batch = data.ConsumeIntegralInRange(-1, 9);
    options.learning_rate = number(data);
    options.momentum = number(data);
    options.weight_decay = number(data);
    options.patience = data.ConsumeIntegralInRange(-1, 2);
    hostile_size(data, options);
    const decid_dataset* dataset = datasets.any(data);
    if (dataset == nullptr && data.ConsumeBool()) return;
    models.fill(data, [&](decid_model** place) { return decid_train(dataset, nullptr, &options, place); });
  }

  void identify() {
    decid_identify_options options;
    decid_identify_defaults(&options, sizeof options);
    options.mass_kg = number(data);
    options.height_m = number(data);
    options.begin_s = number(data);
    options.detrend = data.ConsumeIntegralInRange(-1, 4);
    hostile_size(data, options);
    const decid_model* model = models.any(data);
    const decid_recording* recording = recordings.any(data);
    results.fill(data, [&](decid_result** place) { return decid_identify(model, recording, &options, place); });
    const decid_result* result = results.any(data);
    decid_result_parameter(result, data.ConsumeIntegral<std::size_t>());
    decid_result_correlation(result, data.ConsumeIntegral<std::size_t>(), data.ConsumeIntegral<std::size_t>());
    decid_result_sway(result, nullptr);
    decid_result_draws(result, data.ConsumeIntegral<std::size_t>());
    decid_evaluation evaluation;
    decid_evaluate(model, datasets.any(data), data.ConsumeIntegralInRange(-1, 4), &evaluation, sizeof evaluation);
  }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const bool one_thread = decid_set_threads(1) == DECID_OK;
  REQUIRE_THAT(one_thread);
  FuzzedDataProvider data(bytes, size);
  Session session(data);
  using Step = void (Session::*)();
  constexpr Step steps[]{&Session::load_protocol,  &Session::simulate,     &Session::read_recording,
                         &Session::make_recording, &Session::make_dataset, &Session::read_dataset,
                         &Session::load_model,     &Session::train,        &Session::identify};
  for (int i = 0; i < 12 && data.remaining_bytes() > 0; ++i) (session.*data.PickValueInArray(steps))();
  return 0;
}
