// Data sets and evaluation in C.
#include <cstddef>
#include <limits>

#include "base/parallel.hpp"
#include "base/version.hpp"
#include "bindings/c/handles.hpp"
#include "identify/evaluation/calibration.hpp"
#include "identify/network/for_body.hpp"
#include "identify/network/prediction.hpp"
#include "identify/training/training.hpp"

using namespace decid::c;

decid_dataset::decid_dataset(decid::dataset::StoredDataset of) : data(std::move(of)), protocol(data.about().protocol) {
  for (const decid::sim::Parameters& trial : data.about().parameters)
    parameters.insert(parameters.end(), trial.begin(), trial.end());
}

namespace {

using decid::dataset::Dataset;
using decid::dataset::StoredDataset;

StoredDataset make(const decid_protocol& protocol, const decid_dataset_options& asked) {
  const decid::dataset::DatasetRequest request{protocol.protocol(), asked.count, asked.base, asked.seed};
  bool stopped = false;
  const auto progress = [&](int done, int total) {
    if (asked.progress != nullptr)
      stopped = asked.progress(asked.user, static_cast<double>(done) / total, "simulating") != 0;
    return !stopped;
  };
  try {
    if (asked.path == nullptr) return StoredDataset(decid::dataset::generate(request, nullptr, progress));
    decid::dataset::generate_npz(asked.path, request, std::string("decid ") + decid::version, progress);
    return StoredDataset(asked.path);
  } catch (const decid::Error&) {
    if (stopped) throw Stopped{"decid_dataset_make"};
    throw;
  }
}

/// Which trials of the part there are.
std::vector<int> chosen_of(const Dataset& data, int split) {
  std::vector<int> chosen;
  for (int i = 0; i < data.trials(); ++i)
    if (split == DECID_ALL || (data.split[static_cast<std::size_t>(i)] == 0) == (split == DECID_TRAINING))
      chosen.push_back(i);
  if (chosen.empty())
    throw decid::Error(decid::Code::trials_missing, "decid_evaluate", "that half of the data set is empty",
                       "give DECID_ALL");
  return chosen;
}

decid_evaluation evaluate(const decid::Model& model, const std::string& name, const StoredDataset& stored, int split) {
  constexpr const char* where = "the data set";
  if (split < DECID_ALL || split > DECID_VALIDATION)
    throw decid::Error(decid::Code::setting_unknown, "decid_evaluate", decid::format("there is no split %d", split),
                       "give a value of decid_split");
  const Dataset& data = stored.about();
  const decid::ForBody body = decid::for_trials(model, name, data.protocol, where);
  const decid::Measured part = split == DECID_TRAINING     ? decid::Measured::training
                               : split == DECID_VALIDATION ? decid::Measured::validation
                                                           : decid::Measured::all;
  decid::require_not_trained_on(model.origin, decid::dataset::trial_identity(stored), part, where);
  const std::vector<int> chosen = chosen_of(data, split);
  std::vector<decid::sim::Parameters> truth;
  for (const int i : chosen) truth.push_back(body.to_model(model, data.parameters[static_cast<std::size_t>(i)]));
  const auto sways = [&](std::span<const int> indices, const decid::SwaySink& take) {
    decid::parallel_for(static_cast<int>(indices.size()), [&](int i) {
      std::vector<float> sway(static_cast<std::size_t>(data.samples));
      const auto place = static_cast<std::size_t>(i);
      stored.read(chosen[static_cast<std::size_t>(indices[place])], sway);
      take(place, {sway, body.height});
    });
  };
  const std::vector<float> outputs = decid::predict(model, static_cast<int>(chosen.size()), 64, sways);
  const decid::Evaluation found = decid::evaluate(model.targets, decid::to_scores(model, outputs), truth);
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  decid_evaluation result{
      static_cast<size_t>(found.trials), found.mse(), found.matlab_loss(), {}, unknown, unknown, unknown};
  static_assert(decid::sim::Parameters::max_parameters <= DECID_MAX_PARAMETERS);
  std::copy(found.mse_per_parameter.begin(), found.mse_per_parameter.end(), result.mse_per_parameter);
  if (const auto calibration = decid::network_calibration(model, outputs, truth)) {
    result.coverage50 = calibration->figures.all.coverage50;
    result.coverage90 = calibration->figures.all.coverage90;
    result.log_score = calibration->figures.log_score;
  }
  return result;
}

}  // namespace

void decid_dataset_defaults(decid_dataset_options* options, size_t size) {
  decid_dataset_options defaults{};
  defaults.seed = 1;
  set_defaults(options, size, defaults);
}

decid_status decid_dataset_make(const decid_protocol* protocol, const decid_dataset_options* options,
                                decid_dataset** dataset) {
  constexpr const char* where = "decid_dataset_make";
  return made(dataset, where, [&] {
    const decid_dataset_options asked = options_of(options, decid_dataset_defaults, where);
    if (asked.path != nullptr) path_to_write(asked.path, where);
    return std::make_unique<decid_dataset>(make(given(protocol, where, "protocol"), asked));
  });
}
decid_status decid_dataset_read(const char* path, decid_dataset** dataset) {
  return made(dataset, "decid_dataset_read", [&] {
    return std::make_unique<decid_dataset>(
        StoredDataset(std::filesystem::path(&given(path, "decid_dataset_read", "path"))));
  });
}
decid_status decid_dataset_write(const decid_dataset* dataset, const char* path) {
  return guarded([&] {
    constexpr const char* where = "decid_dataset_write";
    const StoredDataset& data = given(dataset, where, "dataset").data;
    if (!data.in_memory())
      throw decid::Error(decid::Code::setting_conflict, where, "the data set is a file already", "copy the file");
    decid::dataset::write_npz(path_to_write(path, where), data.about());
  });
}
void decid_dataset_free(decid_dataset* dataset) {
  delete dataset;
}
size_t decid_dataset_trials(const decid_dataset* dataset) {
  return dataset == nullptr ? 0 : static_cast<size_t>(dataset->data.trials());
}
const decid_protocol* decid_dataset_protocol(const decid_dataset* dataset) {
  return dataset == nullptr ? nullptr : &dataset->protocol;
}
const double* decid_dataset_parameters(const decid_dataset* dataset) {
  return dataset == nullptr ? nullptr : dataset->parameters.data();
}
const int32_t* decid_dataset_group(const decid_dataset* dataset) {
  return dataset == nullptr ? nullptr : dataset->data.about().group.data();
}
const uint8_t* decid_dataset_split(const decid_dataset* dataset) {
  return dataset == nullptr ? nullptr : dataset->data.about().split.data();
}
const float* decid_dataset_sway(const decid_dataset* dataset) {
  return dataset == nullptr || !dataset->data.in_memory() ? nullptr : dataset->data.about().sway.data();
}

decid_status decid_dataset_copy_sway(const decid_dataset* dataset, size_t first, size_t trials, float* sway_rad) {
  return guarded([&] {
    constexpr const char* where = "decid_dataset_copy_sway";
    const StoredDataset& data = given(dataset, where, "dataset").data;
    float* const rows = &given(sway_rad, where, "sway_rad");
    const auto all = static_cast<size_t>(data.trials()), samples = static_cast<size_t>(data.about().samples);
    if (first > all || trials > all - first)
      throw decid::Error(decid::Code::setting_out_of_range, where,
                         decid::format("trials %zu to %zu of %zu", first, first + trials, all), "ask for fewer");
    for (size_t i = 0; i < trials; ++i) data.read(static_cast<int>(first + i), std::span(rows + i * samples, samples));
  });
}

decid_status decid_evaluate(const decid_model* model, const decid_dataset* dataset, int split,
                            decid_evaluation* evaluation, size_t size) {
  return guarded([&] {
    constexpr const char* where = "decid_evaluate";
    constexpr std::size_t first = offsetof(decid_evaluation, log_score) + sizeof(double);  // of the first header
    if (size < first || size > sizeof(decid_evaluation))
      throw decid::Error(
          decid::Code::size_mismatch, where,
          decid::format("its evaluation has a size of %zu, this library's has %zu", size, sizeof(decid_evaluation)),
          "give sizeof(decid_evaluation), and run with the library of that header or a newer one");
    const decid_model& of = given(model, where, "model");
    decid_evaluation& result = given(evaluation, where, "evaluation");
    const decid_evaluation found = evaluate(of.model, of.name, given(dataset, where, "dataset").data, split);
    std::memcpy(static_cast<void*>(&result), &found, size);
  });
}
