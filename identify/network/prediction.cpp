// Outputs for many trials: see prediction.hpp.
#include "identify/network/prediction.hpp"

#include <algorithm>
#include <numeric>

#include "base/parallel.hpp"
#include "nn/predictor.hpp"

namespace decid {
namespace {

constexpr std::size_t max_image_bytes = std::size_t{32} << 20;

/// Each rank starts with the outputs of its rank_range(); afterwards each rank has all outputs.
void gather_truth(Communicator& ranks, std::size_t parameters, std::vector<sim::Parameters>& truth) {
  std::vector<double> values(truth.size() * parameters);
  for (std::size_t i = 0; i < truth.size(); ++i)
    std::ranges::copy(truth[i], values.begin() + static_cast<std::ptrdiff_t>(i * parameters));
  gather_ranges(ranks, truth.size(), parameters, values);
  for (std::size_t i = 0; i < truth.size(); ++i) {
    truth[i] = sim::Parameters(parameters);
    for (std::size_t p = 0; p < parameters; ++p) truth[i][p] = values[i * parameters + p];
  }
}

}  // namespace

Sways sways_in_memory(std::function<std::span<const float>(int)> sway, double body_height) {
  return [sway = std::move(sway), body_height](std::span<const int> indices, const SwaySink& take) {
    parallel_for(static_cast<int>(indices.size()), [&](int i) {
      const auto place = static_cast<std::size_t>(i);
      take(place, {sway(indices[place]), body_height});
    });
  };
}

std::vector<float> predict(const Model& model, int trials, int at_once, const Sways& sways) {
  const auto outputs = static_cast<std::size_t>(model.network.output_shape().size());
  const auto values = static_cast<std::size_t>(model.network.input_shape().size());
  const auto fitting = static_cast<int>(std::min(max_image_bytes / (values * sizeof(float)), std::size_t{1} << 20));
  at_once = std::clamp(at_once, 1, std::max(fitting, 1));
  nn::Predictor predictor(model.network, std::min(trials, at_once));
  std::vector<float> result(static_cast<std::size_t>(trials) * outputs), images;
  for (int first = 0; first < trials; first += at_once) {
    std::vector<int> indices(static_cast<std::size_t>(std::min(at_once, trials - first)));
    std::iota(indices.begin(), indices.end(), first);
    images.resize(indices.size() * values);
    dataset::encode_all(
        model.encoding(), [&](const SwaySink& take) { sways(indices, take); }, images);
    predictor.run(images,
                  std::span(result).subspan(static_cast<std::size_t>(first) * outputs, indices.size() * outputs));
  }
  return result;
}

std::vector<float> predict(const Model& model, int trials, int at_once, const Sways& sways, Communicator* ranks) {
  if (ranks == nullptr) return predict(model, trials, at_once, sways);
  const auto outputs = static_cast<std::size_t>(model.network.output_shape().size()),
             count = static_cast<std::size_t>(trials);
  const RankRange own = rank_range(count, ranks->rank(), ranks->size());
  std::vector<float> all(count * outputs);
  if (own.count() > 0) {
    const auto own_sways = [&](std::span<const int> indices, const SwaySink& take) {
      std::vector<int> numbers;
      for (const int index : indices) numbers.push_back(static_cast<int>(own.first) + index);
      sways(numbers, take);
    };
    std::ranges::copy(predict(model, static_cast<int>(own.count()), at_once, own_sways),
                      all.begin() + static_cast<std::ptrdiff_t>(own.first * outputs));
  }
  gather_ranges(*ranks, count, outputs, all);
  return all;
}

std::vector<float> to_scores(const Model& model, std::span<const float> outputs) {
  const auto width = static_cast<std::size_t>(model.network.output_shape().size());
  const std::size_t parameters = model.parameters().size(), trials = outputs.size() / width;
  std::vector<float> scores(trials * parameters);
  for (std::size_t i = 0; i < trials; ++i)
    model.head->scores(outputs.subspan(i * width, width), std::span(scores).subspan(i * parameters, parameters));
  return scores;
}

OutputsOf compute_outputs(const Model& model, const dataset::TrialSource& source, dataset::Part part, int epoch,
                          int trials, Communicator* ranks) {
  OutputsOf made;
  made.truth.resize(static_cast<std::size_t>(trials));
  const auto sways = [&](std::span<const int> indices, const SwaySink& take) {
    // Spread over the part: a data set's base trials come before its children.
    const auto all = static_cast<long long>(source.trials(part));
    std::vector<int> places;
    for (const int index : indices) places.push_back(static_cast<int>(index * all / trials));
    source.take(part, epoch, places, [&](std::size_t place, const sim::Parameters& truth, const dataset::Sway& sway) {
      made.truth[static_cast<std::size_t>(indices[place])] = truth;
      take(place, sway);
    });
  };
  made.outputs = predict(model, trials, source.trials_at_once(), sways, ranks);
  if (ranks != nullptr) gather_truth(*ranks, model.parameters().size(), made.truth);
  return made;
}

Predicted predict(const Model& model, const dataset::TrialSource& source, dataset::Part part, Communicator* ranks) {
  OutputsOf found = compute_outputs(model, source, part, 0, source.trials(part), ranks);
  return {to_scores(model, found.outputs), std::move(found.truth)};
}

}  // namespace decid
