// Optimisers: see optimiser.hpp.
#include "nn/training/optimiser.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>

#include "base/error.hpp"
#include "base/number.hpp"
#include "base/text.hpp"
#include "nn/training/sharing.hpp"

namespace decid::nn {
namespace {

class Sgd final : public Optimiser {
 public:
  explicit Sgd(const SgdOptions& options) : options_(options) {}

  void update(const Values& v, double learning_rate, long long) const override {
    const auto rate = static_cast<float>(learning_rate), momentum = static_cast<float>(options_.momentum);
    const float decay = v.decays ? static_cast<float>(options_.weight_decay) : 0.0F;
    float* const velocity = v.memory[0];
    if (!options_.nesterov)
      return kernels<float>().sgd_step(v.count, rate, momentum, decay, v.gradient, velocity, v.value);
    for (std::size_t i = 0; i < v.count; ++i) {
      const float gradient = v.gradient[i] + decay * v.value[i];
      velocity[i] = momentum * velocity[i] + gradient;
      v.value[i] -= rate * (gradient + momentum * velocity[i]);
    }
  }
  int memory() const override { return 1; }
  std::string text() const override {
    return format("sgd %.17g %.17g%s", options_.momentum, options_.weight_decay, options_.nesterov ? " nesterov" : "");
  }

 private:
  SgdOptions options_;
};

/// By squares, as libm's pow differs between systems.
double power(double base, long long exponent) {
  double result = 1;
  for (; exponent > 0; exponent /= 2, base *= base)
    if (exponent % 2 == 1) result *= base;
  return result;
}

class AdamW final : public Optimiser {
 public:
  explicit AdamW(const AdamWOptions& options) : options_(options) {}

  void update(const Values& v, double learning_rate, long long step) const override {
    const auto beta1 = static_cast<float>(options_.beta1), beta2 = static_cast<float>(options_.beta2);
    const auto rest1 = static_cast<float>(1 - options_.beta1), rest2 = static_cast<float>(1 - options_.beta2);
    const auto rate = static_cast<float>(learning_rate / (1 - power(options_.beta1, step)));
    const auto bias2 = static_cast<float>(1 / std::sqrt(1 - power(options_.beta2, step)));
    const auto epsilon = static_cast<float>(options_.epsilon);
    const auto kept = static_cast<float>(v.decays ? 1 - learning_rate * options_.weight_decay : 1.0);
    float *const mean = v.memory[0], *const square = v.memory[1];
    for (std::size_t i = 0; i < v.count; ++i) {
      const float g = v.gradient[i];
      mean[i] = beta1 * mean[i] + rest1 * g;
      square[i] = beta2 * square[i] + rest2 * (g * g);
      v.value[i] = kept * v.value[i] - rate * mean[i] / (std::sqrt(square[i]) * bias2 + epsilon);
    }
  }
  int memory() const override { return 2; }
  std::string text() const override {
    return format("adamw %.17g %.17g %.17g %.17g", options_.beta1, options_.beta2, options_.epsilon,
                  options_.weight_decay);
  }

 private:
  AdamWOptions options_;
};

/// Throws Error unless low <= value < high.
void check(const char* optimiser, const char* setting, double value, double high, double low = 0) {
  if (!(value >= low && value < high))
    throw Error(Code::setting_out_of_range, optimiser, format("has the setting %s = %g", setting, value),
                format("give a number from %g to below %g", low, high));
}

/// Throws Error unless gradients and memory have a value for each value that is trained.
void check_sizes(const Optimiser& optimiser, const std::vector<Parameter<float>*>& parameters,
                 std::span<const std::span<const float>> gradients, const OptimiserState& state) {
  const auto fits = [](const auto& values, const Parameter<float>* p) { return values.size() == p->value.size(); };
  const auto fits_or_frozen = [&](std::span<const float> gradient, const Parameter<float>* p) {
    return gradient.empty() || fits(gradient, p);
  };
  const bool has_memory =
      state.memory.size() == static_cast<std::size_t>(optimiser.memory()) &&
      std::ranges::all_of(state.memory, [&](const auto& kept) { return std::ranges::equal(kept, parameters, fits); });
  if (!has_memory)
    throw Error(Code::size_mismatch, "optimiser", "has a state of other sizes than this network's parameters",
                "give the state of begin() for this optimiser and network, or of a training of them");
  if (!std::ranges::equal(gradients, parameters, fits_or_frozen))
    throw Error(Code::size_mismatch, "optimiser", "has gradients of other sizes than this network's parameters",
                "give those of a trainer of the same network, in the order of its parameters");
}

}  // namespace

std::shared_ptr<const Optimiser> sgd(const SgdOptions& options) {
  check("sgd", "momentum", options.momentum, 1);
  check("sgd", "weight_decay", options.weight_decay, 1e6);
  return std::make_shared<Sgd>(options);
}

std::shared_ptr<const Optimiser> adamw(const AdamWOptions& options) {
  check("adamw", "beta1", options.beta1, 1);
  check("adamw", "beta2", options.beta2, 1);
  check("adamw", "epsilon", options.epsilon, 1e6, 1e-30);  // 0 would divide 0 by 0 where a gradient is 0
  check("adamw", "weight_decay", options.weight_decay, 1e6);
  return std::make_shared<AdamW>(options);
}

std::shared_ptr<const Optimiser> optimiser_named(const std::string& text) {
  std::istringstream words(text);
  std::string name;
  words >> name;
  AdamWOptions adam;
  SgdOptions descent{.nesterov = name == "nesterov"};
  std::map<std::string, double*> settings;
  if (name == "adamw")
    settings = {{"beta1", &adam.beta1},
                {"beta2", &adam.beta2},
                {"epsilon", &adam.epsilon},
                {"weight_decay", &adam.weight_decay}};
  else if (name == "sgd" || name == "nesterov")
    settings = {{"momentum", &descent.momentum}, {"weight_decay", &descent.weight_decay}};
  else
    throw Error(Code::setting_unknown, "optimiser '" + text + "'", "is not known", "give sgd, nesterov or adamw");
  std::string key, number;
  std::vector<std::string> given;
  while (words >> key) {
    const auto found = settings.find(key);
    if (std::ranges::find(given, key) != given.end())
      throw Error(Code::setting_malformed, "optimiser '" + text + "'", "has " + key + " twice", "give it once");
    const std::optional<double> value = words >> number ? number_from<double>(number) : std::nullopt;
    if (found == settings.end() || !value)
      throw Error(Code::setting_malformed, "optimiser '" + text + "'", "has '" + key + "' without a number, or unknown",
                  "give settings and numbers: momentum and weight_decay of sgd and nesterov; beta1, beta2, epsilon and "
                  "weight_decay of adamw");
    *found->second = *value;
    given.push_back(key);
  }
  return name == "adamw" ? adamw(adam) : sgd(descent);
}

OptimiserState begin(const Optimiser& optimiser, const Network<float>& network) {
  OptimiserState state;
  if (optimiser.memory() < 0)
    throw Error(Code::setting_out_of_range, "optimiser " + optimiser.text(),
                format("keeps %d values for each trained one", optimiser.memory()), "return 0 or more from memory()");
  state.memory.resize(static_cast<std::size_t>(optimiser.memory()));
  for (auto& kept : state.memory)
    for (const Parameter<float>* p : network.parameters()) kept.emplace_back(p->value.size(), 0.0F);
  return state;
}

void update(const Optimiser& optimiser, Network<float>& network, std::span<const std::span<const float>> gradients,
            double learning_rate, OptimiserState& state) {
  const std::vector<Parameter<float>*> parameters = network.parameters();
  check_sizes(optimiser, parameters, gradients, state);
  ++state.steps;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    Parameter<float>& parameter = *parameters[k];
    if (gradients[k].empty()) continue;
    const auto update_values = [&](int, int first, int last) {
      std::vector<float*> memory;
      for (auto& kept : state.memory) memory.push_back(kept[k].data() + first);
      optimiser.update({static_cast<std::size_t>(last - first), gradients[k].data() + first,
                        parameter.value.data() + first, memory.data(), parameter.decays, parameter.shape},
                       learning_rate, state.steps);
    };
    const auto count = static_cast<int>(parameter.value.size());
    if (optimiser.whole_parameters())
      update_values(0, 0, count);
    else
      for_each_group(1, count, value_group, update_values);
  }
}

double clip(std::span<const std::span<float>> gradients, double largest) {
  double sum = 0;
  for (const std::span<float> gradient : gradients) {
    std::vector<double> parts((gradient.size() + value_group - 1) / value_group);
    for_each_group(1, static_cast<int>(gradient.size()), value_group, [&](int, int first, int last) {
      double& part = parts[static_cast<std::size_t>(first / value_group)];
      for (int i = first; i < last; ++i) {
        const auto g = static_cast<double>(gradient[static_cast<std::size_t>(i)]);
        part += g * g;
      }
    });
    for (const double part : parts) sum += part;
  }
  const double norm = std::sqrt(sum);
  if (!(norm > largest)) return norm;
  const auto factor = static_cast<float>(largest / norm);
  for (const std::span<float> gradient : gradients)
    for (float& g : gradient) g *= factor;
  return norm;
}

}  // namespace decid::nn
