// Heads: see head.hpp.
#include "identify/network/head.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "identify/network/mixture.hpp"
#include "nn/training/loss.hpp"

namespace decid {
namespace {

class PointHead final : public Head {
 public:
  std::string name() const override { return "point"; }
  std::size_t outputs(std::size_t parameters) const override { return parameters; }
  /// The squared errors of each parameter.
  std::size_t loss_parts(std::size_t parameters) const override { return parameters; }
  void loss(const nn::TensorView<const float>& outputs, std::span<const float> targets, int trials, std::size_t,
            std::span<double> parts, const nn::TensorView<float>& diff) const override {
    nn::squared_errors<float>(outputs, targets, trials, parts, diff);
  }
  double total_loss(std::span<const double> parts, std::size_t parameters) const override {
    double total = 0.0;
    for (std::size_t p = 0; p < parameters; ++p) {
      double squares = 0.0;
      for (std::size_t i = p; i < parts.size(); i += parameters) squares += parts[i];
      total += squares;
    }
    return total;
  }
  void scores(std::span<const float> outputs, std::span<float> scores) const override {
    if (outputs.size() != scores.size())
      throw Error(Code::size_mismatch, "point head",
                  std::to_string(outputs.size()) + " outputs for " + std::to_string(scores.size()) + " parameters",
                  "give one for each");
    std::ranges::copy(outputs, scores.begin());
  }
};

constexpr int max_components = 16;
const double root_twelve = std::sqrt(12.0);

class MixtureHead final : public Head {
 public:
  explicit MixtureHead(int components) : components_(static_cast<std::size_t>(components)) {}

  std::string name() const override { return "mixture " + std::to_string(components_); }
  std::size_t outputs(std::size_t parameters) const override { return mixture_outputs(components_, parameters); }
  dataset::TargetScaling scaling(const sim::ParameterTable& table, dataset::TargetScaling) const override {
    dataset::TargetScaling uniform{sim::Parameters(table.size()), sim::Parameters(table.size())};
    for (std::size_t p = 0; p < table.size(); ++p) {
      uniform.mean[p] = 0.5 * (table[p].low + table[p].high);
      uniform.stddev[p] = table[p].range() / root_twelve;
    }
    return uniform;
  }
  /// Training begins near the prior, because logarithms far from 0 make enormous gradients.
  float first_weights() const override { return 0.02F; }
  /// The logarithm of the density of each trial; 0 for a lane without a trial.
  std::size_t loss_parts(std::size_t) const override { return nn::lanes; }
  void loss(const nn::TensorView<const float>& outputs, std::span<const float> targets, int trials,
            std::size_t parameters, std::span<double> parts, const nn::TensorView<float>& diff) const override {
    const auto samples = static_cast<std::size_t>(outputs.batch());
    const auto count = static_cast<std::size_t>(outputs.shape().channels);
    const double factor = -1.0 / static_cast<double>(static_cast<std::size_t>(trials) * parameters);
    parallel_for(outputs.blocks() * nn::lanes, [&](int lane) {
      const auto sample = static_cast<std::size_t>(lane);
      if (sample >= samples) {
        parts[sample] = 0.0;
        for (std::size_t o = 0; o < count; ++o) diff.at(lane, static_cast<int>(o), 0, 0) = 0.0F;
        return;
      }
      std::vector<double> values(count), by_value(count), x(parameters);
      for (std::size_t o = 0; o < count; ++o) values[o] = double{outputs.at(lane, static_cast<int>(o), 0, 0)};
      for (std::size_t p = 0; p < parameters; ++p)
        x[p] = mixture_coordinate(0.5 + double{targets[sample * parameters + p]} / root_twelve);
      parts[sample] = mixture_log_density(components_, values, x, by_value, Gradients::balanced);
      for (std::size_t o = 0; o < count; ++o)
        diff.at(lane, static_cast<int>(o), 0, 0) = static_cast<float>(factor * by_value[o]);
    });
  }
  double total_loss(std::span<const double> parts, std::size_t) const override {
    return -std::accumulate(parts.begin(), parts.end(), 0.0);
  }
  void scores(std::span<const float> outputs, std::span<float> scores) const override {
    const Mixture mixture = *distribution(outputs, scores.size());
    for (std::size_t p = 0; p < scores.size(); ++p)
      scores[p] = static_cast<float>((mixture.mean(p) - 0.5) * root_twelve);
  }
  bool gives_distribution() const override { return true; }
  std::optional<Mixture> distribution(std::span<const float> outputs, std::size_t parameters) const override {
    return Mixture(components_, parameters, std::vector<double>(outputs.begin(), outputs.end()));
  }

 private:
  std::size_t components_;
};

/// Returns null for a name that no head has.
const Head* find_head(const std::string& name) {
  if (name == point_head().name()) return &point_head();
  for (int n = 1; n <= max_components; ++n)
    if (name == mixture_head(n).name()) return &mixture_head(n);
  return nullptr;
}

}  // namespace

double Head::loss(const nn::TensorView<const float>& outputs, std::span<const float> targets,
                  const nn::TensorView<float>& diff) const {
  const std::size_t parameters = targets.size() / static_cast<std::size_t>(outputs.batch());
  std::vector<double> parts(static_cast<std::size_t>(outputs.blocks()) * loss_parts(parameters));
  loss(outputs, targets, outputs.batch(), parameters, parts, diff);
  return total_loss(parts, parameters);
}

const Head& mixture_head(int components) {
  static const std::vector<MixtureHead> heads = [] {
    std::vector<MixtureHead> all;
    for (int n = 1; n <= max_components; ++n) all.emplace_back(n);
    return all;
  }();
  if (components < 1 || components > max_components)
    throw Error(Code::setting_out_of_range, "mixture head", "of " + std::to_string(components) + " components",
                "give 1 to " + std::to_string(max_components));
  return heads[static_cast<std::size_t>(components - 1)];
}

const Head& point_head() {
  static const PointHead head;
  return head;
}

const Head& chosen_head(const std::string& name, const std::string& where) {
  if (const Head* head = find_head(name)) return *head;
  throw Error(Code::setting_unknown, where, "is '" + name + "'",
              "give point, or mixture N with 1 to " + std::to_string(max_components) + " for N, such as 'mixture 2'");
}

const Head& head_named(const std::string& name, const std::string& where) {
  if (const Head* head = find_head(name)) return *head;
  throw Error(Code::file_unsupported, where, "has outputs of the kind '" + name + "', which this program does not know",
              "use the decid that wrote it");
}

}  // namespace decid
