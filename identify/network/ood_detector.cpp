// Out-of-distribution detection: see ood_detector.hpp.
#include "identify/network/ood_detector.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <variant>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "identify/network/model.hpp"
#include "nn/predictor.hpp"

namespace decid {
namespace {

constexpr int batch = 64;
/// Numbers of trials for learning, and for measuring the usual distance.
constexpr int max_learned = 6144, max_shown = 4096;
constexpr double usual_part = 0.97, learned_part = 0.6;
constexpr int trials_a_feature = 8;
/// Fraction of the mean variance that is added to each variance, so that constant features cause no division by 0.
constexpr double ridge = 1e-3;

/// Returns how many of `trials` are used for learning.
int learned_of(int trials) {
  return static_cast<int>(learned_part * std::min(trials, max_learned + max_shown));
}

/// Features of `trials` images, one row each.
std::vector<float> features_of(nn::Predictor& predictor, int trials, std::span<const float> images) {
  const auto count = static_cast<std::size_t>(trials);
  std::vector<float> outputs(count * static_cast<std::size_t>(predictor.inference().output_shape().size()));
  std::vector<float> features(count * static_cast<std::size_t>(predictor.feature_count()));
  predictor.run(images, outputs, features);
  return features;
}

/// Returns the inverse of the Cholesky factor of the rows' covariance: a lower triangle, row by row. Not by
/// base/math/cholesky.hpp: fused multiply-adds would give model files other bits.
std::vector<double> whitening_of(const std::vector<float>& rows, const std::vector<double>& mean) {
  const std::size_t n = mean.size(), count = rows.size() / n;
  std::vector<double> covariance(n * n, 0.0);
  parallel_for(static_cast<int>(n), [&](int index) {
    const auto i = static_cast<std::size_t>(index);
    for (std::size_t r = 0; r < count; ++r) {
      const float* row = rows.data() + r * n;
      for (std::size_t j = 0; j <= i; ++j)
        covariance[i * n + j] += (static_cast<double>(row[i]) - mean[i]) * (static_cast<double>(row[j]) - mean[j]);
    }
    for (std::size_t j = 0; j <= i; ++j) covariance[i * n + j] /= static_cast<double>(count);
  });
  double trace = 0.0;
  for (std::size_t i = 0; i < n; ++i) trace += covariance[i * n + i];
  const double added = std::max(ridge * trace / static_cast<double>(n), 1e-12);
  std::vector<double>& factor = covariance;  // in place, row by row
  for (std::size_t i = 0; i < n; ++i) {
    factor[i * n + i] += added;
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = factor[i * n + j];
      for (std::size_t k = 0; k < j; ++k) sum -= factor[i * n + k] * factor[j * n + k];
      factor[i * n + j] = i == j ? std::sqrt(sum) : sum / factor[j * n + j];
    }
  }
  std::vector<double> inverse(n * (n + 1) / 2, 0.0);
  const auto at = [&](std::size_t i, std::size_t j) -> double& { return inverse[i * (i + 1) / 2 + j]; };
  for (std::size_t j = 0; j < n; ++j) {
    at(j, j) = 1.0 / factor[j * n + j];
    for (std::size_t i = j + 1; i < n; ++i) {
      double sum = 0.0;
      for (std::size_t k = j; k < i; ++k) sum += factor[i * n + k] * at(k, j);
      at(i, j) = -sum / factor[i * n + i];
    }
  }
  return inverse;
}

/// Images of trials first .. first + count - 1.
std::vector<float> images_of(const Model& model, const dataset::TrialSource& source, int epoch, int first, int count) {
  const auto values = static_cast<std::size_t>(model.images().shape().size());
  std::vector<int> indices(static_cast<std::size_t>(count));
  std::iota(indices.begin(), indices.end(), first);
  std::vector<float> images(indices.size() * values);
  dataset::encode_all(
      model.encoding(),
      [&](const dataset::SwaySink& take) {
        source.take(dataset::Part::unseen, epoch, indices,
                    [&](std::size_t place, const sim::Parameters&, const dataset::Sway& sway) { take(place, sway); });
      },
      images);
  return images;
}

/// Features of trials first .. first + count - 1, images for a few at a time in memory.
std::vector<float> features_of_trials(const Model& model, nn::Predictor& predictor, const dataset::TrialSource& source,
                                      int epoch, int first, int count, Communicator* ranks) {
  if (ranks != nullptr) {
    const auto all = static_cast<std::size_t>(count), width = static_cast<std::size_t>(feature_count(model.network));
    const RankRange own = rank_range(all, ranks->rank(), ranks->size());
    std::vector<float> rows(all * width);
    std::ranges::copy(features_of_trials(model, predictor, source, epoch, first + static_cast<int>(own.first),
                                         static_cast<int>(own.count()), nullptr),
                      rows.begin() + static_cast<std::ptrdiff_t>(own.first * width));
    gather_ranges(*ranks, all, width, rows);
    return rows;
  }
  std::vector<float> rows;
  for (int done = 0; done < count; done += source.trials_at_once()) {
    const int here = std::min(source.trials_at_once(), count - done);
    const std::vector<float> more = features_of(predictor, here, images_of(model, source, epoch, first + done, here));
    rows.insert(rows.end(), more.begin(), more.end());
  }
  return rows;
}

}  // namespace

int feature_count(const nn::Network<float>& network) {
  const auto layers = network.layers();
  if (layers.size() < 2 || !std::holds_alternative<nn::FullyConnected>(layers.back().kind())) return 0;
  const int count = layers.back().src_shape().size();
  return count <= max_features ? count : 0;
}

std::string why_no_ood_detector(const Model& model, const dataset::TrialSource& source) {
  const auto layers = model.network.layers();
  const int features = feature_count(model.network);
  if (layers.size() < 2) return "the network has one layer, and so no features";
  if (!std::holds_alternative<nn::FullyConnected>(layers.back().kind()))
    return "the network's last layer, " + layers.back().text() + ", is not fc";
  if (features == 0)
    return format("the network's last layer reads %d features, and at most %d are kept",
                  layers.back().src_shape().size(), max_features);
  const auto enough = [&](int trials) { return learned_of(trials) >= trials_a_feature * features; };
  const int there = source.trials(dataset::Part::unseen);
  int needed = there;
  while (!enough(needed)) ++needed;
  if (needed == there) return {};
  return format("it takes %d trials that the network was not trained on, and there are %d", needed, there);
}

OodDetector learn_ood_detector(const Model& model, const dataset::TrialSource& source, int next_epoch,
                               Communicator* ranks) {
  OodDetector detector;
  if (!why_no_ood_detector(model, source).empty()) return detector;
  const auto n = static_cast<std::size_t>(feature_count(model.network));
  const int trials = std::min(source.trials(dataset::Part::unseen), max_learned + max_shown);
  const int learned = learned_of(trials);

  nn::Predictor predictor(model.network, batch);
  const std::vector<float> rows = features_of_trials(model, predictor, source, next_epoch, 0, learned, ranks);
  std::vector<double> mean(n, 0.0);
  for (std::size_t i = 0; i < rows.size(); ++i)
    mean[i % n] += static_cast<double>(rows[i]) / static_cast<double>(learned);
  const std::vector<double> whitening = whitening_of(rows, mean);
  detector.mean.assign(mean.begin(), mean.end());
  detector.whitening.assign(whitening.begin(), whitening.end());

  const std::vector<float> shown =
      features_of_trials(model, predictor, source, next_epoch, learned, trials - learned, ranks);
  std::vector<double> all;
  for (std::size_t i = 0; i < shown.size(); i += n) all.push_back(detector.distance(std::span(shown).subspan(i, n)));
  std::ranges::sort(all);
  detector.usual = all[static_cast<std::size_t>(usual_part * static_cast<double>(all.size()))];
  return detector;
}

double OodDetector::distance(std::span<const float> features) const {
  const std::size_t n = mean.size();
  if (n == 0 || features.size() != n || whitening.size() != n * (n + 1) / 2)
    throw Error(Code::size_mismatch, "familiarity",
                format("%zu features where %zu are known, with %zu numbers to whiten them", features.size(), n,
                       whitening.size()),
                "give the features that it was learned from");
  double squares = 0.0;
  const float* weight = whitening.data();
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 0.0;
    for (std::size_t j = 0; j <= i; ++j)
      sum += static_cast<double>(*weight++) * (static_cast<double>(features[j]) - static_cast<double>(mean[j]));
    squares += sum * sum;
  }
  return std::sqrt(squares / static_cast<double>(n));
}

}  // namespace decid
