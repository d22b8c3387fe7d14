// The comparison of methods: see comparison.hpp.
#include "tools/compare/comparison.hpp"

#include <chrono>
#include <cmath>

namespace decid::tools {
namespace {

/// Standard deviation of the prior about the network's answer, as a fraction of the ranges. On trials of a seed behind
/// no published figure, 0.08 had smaller errors than 0.15, and both had smaller errors than no prior.
constexpr double network_spread = 0.08;

/// Names and descriptions of the figures: the single likeliest parameters, then means.
struct Names {
  const char *likeliest, *likeliest_text, *mean, *mean_text;
};
Names names_of(Method method) {
  switch (method) {
    case Method::fit:
      return {"iterative fit, likeliest", "The same fit, the single likeliest parameters: what a fit usually returns",
              "iterative fit", "Iterative fit from the middle of the ranges, mean of the likely parameters"};
    case Method::fit_from_network:
      return {"iterative fit from network, likeliest", "The same fit, the single likeliest parameters",
              "iterative fit from network", "Iterative fit from the network's answer, mean of the likely parameters"};
    case Method::posterior:
      break;
  }
  return {nullptr, nullptr, "posterior", "Mean of draws from the posterior (decid fit); simulations are its gradients"};
}

}  // namespace

Comparison::Comparison(const Model& model, dataset::Dataset data, const ComparisonSettings& settings)
    : identifier_(model),
      divisor_(model.targets.stddev),
      data_(std::move(data)),
      settings_(settings),
      density_(data_.protocol, {.start_s = 0.0, .gain = 0.0}),
      simulator_(data_.protocol),
      table_(data_.protocol.ranges()) {
  iterative::check_budget({settings.simulations, settings.seed}, static_cast<std::size_t>(settings.starts));
}

MethodFigures Comparison::network() {
  const auto start = std::chrono::steady_clock::now();
  network_.clear();
  for (int i = 0; i < trials(); ++i) {
    const std::span<const float> sway_rad = data_.trial(i);
    network_.push_back(
        identifier_.estimate({recording::make_trial({sway_rad.begin(), sway_rad.end()})}).front().parameters);
  }
  MethodFigures figures =
      compute_errors("network", "The network's answer, no simulation", network_, data_.parameters, divisor_);
  figures.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / trials();
  return figures;
}

std::optional<MethodAnswer> Comparison::answer(Method method, int trial, const std::function<bool()>& stop) const {
  MethodAnswer found = method == Method::posterior ? posterior_answer(trial, stop)
                                                   : fit_answer(trial, method == Method::fit_from_network);
  if (stop()) return std::nullopt;
  return found;
}

MethodAnswer Comparison::posterior_answer(int trial, const std::function<bool()>& stop) const {
  const posterior::Posterior found =
      posterior::sample(density_, density_.observe(data_.trial(trial)), settings_.posterior,
                        [&](const posterior::Progress&) { return !stop(); });
  if (stop()) return {};
  MethodAnswer answer{sim::Parameters(table_.size()), {}, static_cast<double>(found.leapfrog_steps())};
  sim::Parameters standard_error(table_.size());
  for (std::size_t p = 0; p < table_.size(); ++p) {
    answer.mean[p] = found.mean(static_cast<int>(p));
    standard_error[p] = found.stddev(static_cast<int>(p));
  }
  answer.squared_ratio = squared_ratio(trial, answer.mean, standard_error);
  return answer;
}

MethodAnswer Comparison::fit_answer(int trial, bool from_network) const {
  std::vector<iterative::Start> starts;
  if (from_network) {
    starts.push_back({network_.at(static_cast<std::size_t>(trial)), network_spread, network_spread});
  } else {
    starts.push_back(iterative::middle_start(table_));
    while (starts.size() < static_cast<std::size_t>(settings_.starts))
      starts.push_back(iterative::random_start(table_, settings_.seed, starts.size()));
  }
  const iterative::Result found =
      iterative::fit(simulator_, data_.trial(trial), starts, {settings_.simulations, settings_.seed});
  return {found.parameters, found.likeliest, static_cast<double>(found.simulations),
          squared_ratio(trial, found.parameters, found.standard_error)};
}

double Comparison::squared_ratio(int trial, const sim::Parameters& estimate,
                                 const sim::Parameters& standard_error) const {
  double sum = 0;
  for (std::size_t p = 0; p < estimate.size(); ++p) {
    const double difference = estimate[p] - data_.parameters[static_cast<std::size_t>(trial)][p];
    sum += difference * difference / (standard_error[p] * standard_error[p]);
  }
  return sum;
}

std::vector<MethodFigures> Comparison::figures(Method method, std::span<const MethodAnswer> answers,
                                               double seconds) const {
  std::vector<sim::Parameters> means, likeliest;
  double simulations = 0, ratio2 = 0;
  for (const MethodAnswer& answer : answers) {
    means.push_back(answer.mean);
    likeliest.push_back(answer.likeliest);
    simulations += answer.simulations;
    ratio2 += answer.squared_ratio;
  }
  const Names names = names_of(method);
  std::vector<MethodFigures> all;
  if (names.likeliest != nullptr)
    all.push_back(compute_errors(names.likeliest, names.likeliest_text, likeliest, data_.parameters, divisor_));
  all.push_back(compute_errors(names.mean, names.mean_text, means, data_.parameters, divisor_));
  for (MethodFigures& figures : all) {
    figures.simulations = simulations / trials();
    figures.seconds = seconds / trials();
  }
  all.back().error_per_standard_error =
      std::sqrt(ratio2 / (static_cast<double>(trials()) * static_cast<double>(table_.size())));
  return all;
}

}  // namespace decid::tools
