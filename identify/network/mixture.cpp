// Mixtures of Gaussians: see mixture.hpp.
#include "identify/network/mixture.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "base/error.hpp"
#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "base/math/random.hpp"

namespace decid {
namespace {

constexpr double log_root_two_pi = 0.91893853320467274178;
constexpr double min_fraction = 1e-4;  // of a range, from its ends

/// Returns the logarithm of the ratio between the density of a fraction and the density of its coordinate.
double log_stretch(double x) {
  return 0.5 * x * x + log_root_two_pi;
}

std::size_t component_outputs(std::size_t parameters) {
  return 1 + parameters + parameters * (parameters + 1) / 2;
}

void check(std::size_t components, std::size_t parameters, std::size_t outputs) {
  if (outputs == mixture_outputs(components, parameters)) return;
  throw Error(Code::size_mismatch, "mixture of " + std::to_string(components),
              std::to_string(outputs) + " outputs for " + std::to_string(parameters) + " parameters",
              "give " + std::to_string(mixture_outputs(components, parameters)));
}

/// One component's part of the outputs.
struct Section {
  Section(std::span<const double> outputs, std::size_t component, std::size_t parameters)
      : values(outputs.subspan(component * component_outputs(parameters), component_outputs(parameters))),
        count(parameters) {}

  double log_weight() const { return values[0]; }
  double centre(std::size_t p) const { return values[1 + p]; }
  double log_diagonal(std::size_t p) const { return std::clamp(values[1 + count + p], -mixture_limit, mixture_limit); }
  bool cut(std::size_t p) const { return std::abs(values[1 + count + p]) > mixture_limit; }
  std::size_t below(std::size_t row, std::size_t column) const { return 1 + 2 * count + row * (row - 1) / 2 + column; }

  std::span<const double> values;
  std::size_t count;
};

/// Weights from their logarithms, which are those of the whole from here on.
double normalise(std::vector<double>& log_weights) {
  const double highest = *std::ranges::max_element(log_weights);
  double sum = 0.0;
  for (const double value : log_weights) sum += decid::exp(value - highest);
  const double whole = highest + decid::log(sum);
  for (double& value : log_weights) value = decid::exp(value - whole);
  return whole;
}

// Integrals over a normal deviate by the trapezoidal rule, whose error falls exponentially with the number of nodes
// (Trefethen and Weideman, SIAM Review 56, 2014).
constexpr int nodes = 25;
constexpr double reach = 6.0, spacing = 2.0 * reach / (nodes - 1);
struct Node {
  double deviate, weight;
};
std::array<Node, nodes> make_nodes() {
  std::array<Node, nodes> all{};
  double sum = 0.0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const double deviate = -reach + spacing * static_cast<double>(i);
    all[i] = {deviate, normal_density(deviate)};
    sum += all[i].weight;
  }
  for (Node& node : all) node.weight /= sum;
  return all;
}

}  // namespace

double mixture_coordinate(double fraction) {
  return inverse_normal(std::clamp(fraction, min_fraction, 1.0 - min_fraction));
}

std::size_t mixture_outputs(std::size_t components, std::size_t parameters) {
  return components * component_outputs(parameters);
}

double mixture_log_density(std::size_t components, std::span<const double> outputs, std::span<const double> x,
                           std::span<double> by_output, Gradients slopes) {
  const double rate = slopes == Gradients::exact ? 1.0 : balanced_rate;
  const std::size_t count = x.size(), each = component_outputs(count);
  check(components, count, outputs.size());
  check(components, count, by_output.size());
  std::vector<double> weights(components), responsibilities(components), off(count), round(count), diagonal(count);
  for (std::size_t k = 0; k < components; ++k) {
    const Section part(outputs, k, count);
    weights[k] = part.log_weight();
    double log_density = -log_root_two_pi * static_cast<double>(count);
    for (std::size_t p = 0; p < count; ++p) {
      off[p] = x[p] - part.centre(p);
      diagonal[p] = decid::exp(part.log_diagonal(p));
      double sum = diagonal[p] * off[p];
      for (std::size_t q = 0; q < p; ++q) sum = std::fma(part.values[part.below(p, q)], off[q], sum);
      round[p] = sum;
      log_density += part.log_diagonal(p) - 0.5 * sum * sum;
    }
    responsibilities[k] = weights[k] + log_density;
    // Derivatives of this component's own logarithm; the factor for its weight in the mixture follows below.
    const std::span<double> by = by_output.subspan(k * each, each);
    for (std::size_t p = 0; p < count; ++p) {
      double by_centre = round[p] * diagonal[p];
      for (std::size_t q = p + 1; q < count; ++q)
        by_centre = std::fma(round[q], part.values[part.below(q, p)], by_centre);
      by[1 + p] = slopes == Gradients::exact ? by_centre : off[p];
      by[1 + count + p] = part.cut(p) ? 0.0 : rate * (1.0 - round[p] * off[p] * diagonal[p]);
      for (std::size_t q = 0; q < p; ++q) by[part.below(p, q)] = -rate * round[p] * off[q];
    }
  }
  const double whole_weight = normalise(weights), whole = normalise(responsibilities);
  for (std::size_t k = 0; k < components; ++k) {
    const std::span<double> by = by_output.subspan(k * each, each);
    by[0] = responsibilities[k] - weights[k];
    for (std::size_t i = 1; i < each; ++i) by[i] *= responsibilities[k];
  }
  return whole - whole_weight;
}

Mixture::Mixture(std::size_t components, std::size_t parameters, std::span<const double> outputs)
    : parameters_(parameters), outputs_(outputs.begin(), outputs.end()) {
  check(components, parameters, outputs.size());
  std::vector<double> weights(components);
  for (std::size_t k = 0; k < components; ++k) weights[k] = Section(outputs, k, parameters).log_weight();
  normalise(weights);
  for (std::size_t k = 0; k < components; ++k) {
    const Section part(outputs, k, parameters);
    Component component{weights[k], {}, std::vector<double>(parameters * parameters, 0.0)};
    for (std::size_t p = 0; p < parameters; ++p) component.centre.push_back(part.centre(p));
    // The covariance is the inverse of A times its transpose.
    std::vector<double> inverse;
    for (std::size_t i = 0; i < parameters; ++i) {
      for (std::size_t j = 0; j < i; ++j) inverse.push_back(part.values[part.below(i, j)]);
      inverse.push_back(decid::exp(part.log_diagonal(i)));
    }
    invert_lower(parameters, inverse);
    for (std::size_t i = 0; i < parameters; ++i)
      for (std::size_t j = 0; j < parameters; ++j)
        for (std::size_t q = 0; q <= std::min(i, j); ++q) {
          double& to = component.covariance[i * parameters + j];
          to = std::fma(inverse[triangle(i) + q], inverse[triangle(j) + q], to);
        }
    components_.push_back(std::move(component));
  }
}

// The mean of Phi(x) over a Gaussian is Phi(centre / sqrt(1 + variance)).
double Mixture::mean(std::size_t parameter) const {
  double sum = 0.0;
  for (const Component& k : components_)
    sum += k.weight *
           normal_distribution(k.centre[parameter] / std::sqrt(1.0 + k.covariance[parameter * (parameters_ + 1)]));
  return sum;
}

// Given x_a, x_b is Gaussian, and the mean of Phi of it has the form above: one integral is left.
double Mixture::second_moment(std::size_t a, std::size_t b) const {
  static const std::array<Node, nodes> all = make_nodes();
  double moment = 0.0;
  for (const Component& k : components_) {
    const double variance = k.covariance[a * (parameters_ + 1)], stddev = std::sqrt(variance);
    const double slope = k.covariance[a * parameters_ + b] / stddev;
    const double left = a == b ? 0.0 : std::max(0.0, k.covariance[b * (parameters_ + 1)] - slope * slope);
    const double stretch = std::sqrt(1.0 + left);
    double sum = 0.0;
    for (const Node& node : all)
      sum += node.weight * normal_distribution(k.centre[a] + stddev * node.deviate) *
             normal_distribution((k.centre[b] + slope * node.deviate) / stretch);
    moment += k.weight * sum;
  }
  return moment;
}

double Mixture::stddev(std::size_t parameter) const {
  const double middle = mean(parameter);
  return std::sqrt(std::max(0.0, second_moment(parameter, parameter) - middle * middle));
}

double Mixture::correlation(std::size_t a, std::size_t b) const {
  if (a == b) return 1.0;
  const double scale = stddev(a) * stddev(b);
  return scale > 0.0 ? std::clamp((second_moment(a, b) - mean(a) * mean(b)) / scale, -1.0, 1.0) : 0.0;
}

double Mixture::below_coordinate(std::size_t parameter, double x) const {
  double sum = 0.0;
  for (const Component& k : components_)
    sum += k.weight *
           normal_distribution((x - k.centre[parameter]) / std::sqrt(k.covariance[parameter * (parameters_ + 1)]));
  return sum;
}

double Mixture::below(std::size_t parameter, double fraction) const {
  if (fraction <= 0.0) return 0.0;
  return fraction < 1.0 ? below_coordinate(parameter, inverse_normal(fraction)) : 1.0;
}

double Mixture::quantile(std::size_t parameter, double probability) const {
  double low = -10.0, high = 10.0;
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = 0.5 * (low + high);
    (below_coordinate(parameter, middle) < probability ? low : high) = middle;
  }
  return normal_distribution(0.5 * (low + high));
}

double Mixture::log_density(std::size_t parameter, double fraction) const {
  const double x = mixture_coordinate(fraction);
  std::vector<double> logs;
  for (const Component& k : components_) {
    if (k.weight <= 0.0) continue;
    const double variance = k.covariance[parameter * (parameters_ + 1)], off = x - k.centre[parameter];
    logs.push_back(decid::log(k.weight) - 0.5 * (off * off / variance + decid::log(variance)) - log_root_two_pi);
  }
  return normalise(logs) + log_stretch(x);
}

double Mixture::log_density(std::span<const double> fractions) const {
  std::vector<double> x, unused(outputs_.size());
  double stretch = 0.0;
  for (const double fraction : fractions) {
    x.push_back(mixture_coordinate(fraction));
    stretch += log_stretch(x.back());
  }
  return mixture_log_density(components_.size(), outputs_, x, unused) + stretch;
}

}  // namespace decid
