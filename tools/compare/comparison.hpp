// The comparison of decid compare: network, posterior and iterative fits of the same trials, whose parameters are
// known.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "dataset/sets/dataset.hpp"
#include "identify/evaluation/comparison.hpp"
#include "identify/identify.hpp"
#include "posterior/posterior.hpp"
#include "tools/compare/fit.hpp"

namespace decid::tools {

struct ComparisonSettings {
  int starts = 2;             ///< of the iterative fit without a network
  std::uint64_t seed = 2026;  ///< of the iterative fits
  long long simulations = iterative::Settings{}.simulations;
  posterior::Settings posterior;
};

/// The methods other than the network. `fit` starts in the middle of the ranges and at random.
enum class Method { posterior, fit, fit_from_network };

/// A method's answer for one trial.
struct MethodAnswer {
  sim::Parameters mean;
  sim::Parameters likeliest;   ///< only iterative fits
  double simulations = 0.0;    ///< a posterior's are its gradients
  double squared_ratio = 0.0;  ///< sum over parameters of (error / standard error)^2
  template <class Archive>
  void archive(Archive& a) {
    a(mean, likeliest, simulations, squared_ratio);
  }
};

/// Answers trial by trial, so that processes can share the trials.
class Comparison {
 public:
  /// The model must outlive it. Throws Error if the settings allow too few simulations.
  Comparison(const Model& model, dataset::Dataset data, const ComparisonSettings& settings);

  int trials() const { return data_.trials(); }
  const sim::Protocol& protocol() const { return data_.protocol; }
  /// Identifies all trials with the network, one at a time as recordings come. Call it first: fits start there.
  MethodFigures network();
  /// Returns a method's answer for one trial; nothing if `stop` returned true meanwhile. Any thread may call it.
  std::optional<MethodAnswer> answer(Method method, int trial, const std::function<bool()>& stop) const;
  /// Returns the figures of a method: one entry for a posterior; for a fit, its likeliest parameters and its means.
  /// answers: of all trials. seconds: the wall time of all of them.
  std::vector<MethodFigures> figures(Method method, std::span<const MethodAnswer> answers, double seconds) const;

 private:
  MethodAnswer posterior_answer(int trial, const std::function<bool()>& stop) const;
  MethodAnswer fit_answer(int trial, bool from_network) const;
  double squared_ratio(int trial, const sim::Parameters& estimate, const sim::Parameters& standard_error) const;

  Identifier identifier_;
  sim::Parameters divisor_;  // of z-scores
  dataset::Dataset data_;
  ComparisonSettings settings_;
  posterior::Density density_;
  sim::Simulator simulator_;
  sim::ParameterTable table_;
  std::vector<sim::Parameters> network_;
};

}  // namespace decid::tools
