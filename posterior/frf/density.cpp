// The posterior density of a published frequency response: see density.hpp.
#include "posterior/frf/density.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"

namespace decid::frf {
namespace {

using sim::Complex;

constexpr double error_beside_confidence = 0.01, error_alone = 0.05;
constexpr double max_gain = 0.9, max_error = 1.0;

double real_product(Complex a, Complex b) {
  return a.real() * b.real() + a.imag() * b.imag();
}

Priors filled(Priors priors, const Table& table) {
  const auto check = [](bool right, const char* setting, double value, const char* remedy) {
    if (!right)
      throw Error(Code::setting_out_of_range, std::string("priors, ") + setting, format("is %g", value), remedy);
  };
  if (!priors.error) priors.error = table.has_confidence() ? error_beside_confidence : error_alone;
  check(priors.gain >= 0.0 && priors.gain <= max_gain, "gain", priors.gain, "give 0 to 0.9");
  check(*priors.error >= 0.0 && *priors.error <= max_error, "error", *priors.error, "give 0 to 1");
  check(priors.error_factor > 1.0 && std::isfinite(priors.error_factor), "error_factor", priors.error_factor,
        "give a factor above 1");
  if (*priors.error == 0.0 && !table.has_confidence())
    throw Error(Code::setting_missing, table.file, "has no confidence, and the prior error is 0",
                "add a confidence column, or give " + setting("prior_error") + " above 0");
  return priors;
}

}  // namespace

Density::Density(const sim::Protocol& protocol, Table table, const Priors& priors)
    : table_(std::move(table)),
      priors_(filled(priors, table_)),
      ranges_(posterior::ranges_for({.parameters = priors.parameters}, protocol.ranges())),
      place_of_(ranges_.size()),
      model_(protocol, table_) {
  const posterior::Priors of_parameters =
      posterior::with_conventions({.parameters = priors.parameters}, protocol.ranges());
  priors_.parameters = of_parameters.parameters;
  for (const sim::ParameterInfo& info : ranges_)
    quantiles_.push_back(posterior::make_quantile(of_parameters, info.name, info.low, info.range()));
  add_parameters(false);
  of_gain_ = free_.size();
  add_parameters(true);
  const sim::Family& family = protocol.family();
  // Noise and threshold are parameters of their own or constants (posterior::require_family).
  const std::optional<std::size_t> nv = family.find_parameter(sim::Coefficient::nv);
  const std::optional<std::size_t> theta = family.find_parameter(sim::Coefficient::theta);
  const auto is_uniform = [&](std::optional<std::size_t> p) { return p && place_of_[*p] && *place_of_[*p] < of_gain_; };
  if (!is_uniform(nv) || !is_uniform(theta)) return;
  const auto passes = [&](double of_nv, double of_theta) { return model_.passing_gain(of_nv, of_theta); };
  dead_band_ = DeadBand{*nv, *theta, DeadBandPrior(quantiles_[*nv], quantiles_[*theta], passes)};
}

/// Gives the parameters that are not fixed the next coordinates, those with normal priors or all others.
void Density::add_parameters(bool normal) {
  for (std::size_t p = 0; p < ranges_.size(); ++p) {
    if (quantiles_[p].range == 0.0 || (quantiles_[p].sd > 0.0) != normal) continue;
    place_of_[p] = free_.size() + (normal ? 1 : 0);  // after the gain
    free_.push_back(p);
  }
}

bool Density::has_given_priors() const {
  return std::ranges::any_of(priors_.parameters, [&](const posterior::ParameterPrior& prior) {
    const auto info = std::ranges::find(ranges_, prior.name, &sim::ParameterInfo::name);
    return prior.range || prior.normal || prior.fixed != info->convention;
  });
}

std::optional<std::size_t> Density::find_coordinate(int quantity) const {
  if (quantity == gain()) return of_gain_;
  if (quantity == error()) return size() - 1;
  return place_of_[static_cast<std::size_t>(quantity)];
}

State Density::state(std::span<const double> x) const {
  State state;
  state.parameters = sim::Parameters(ranges_.size());
  for (std::size_t p = 0; p < ranges_.size(); ++p) {
    const posterior::Quantile& prior = quantiles_[p];
    state.parameters[p] = !place_of_[p]    ? prior.low
                          : prior.sd > 0.0 ? prior.value_in_tails(x[*place_of_[p]])
                                           : prior.value_at(x[*place_of_[p]]);
  }
  if (dead_band_) {
    const std::size_t nv = dead_band_->nv, theta = dead_band_->theta;
    const DeadBandPrior::Point point = dead_band_->prior.at(x[*place_of_[nv]], x[*place_of_[theta]]);
    state.parameters[nv] = point.nv;
    state.parameters[theta] = point.theta;
  }
  state.gain = 1.0 + priors_.gain * (2.0 * x[of_gain_] - 1.0);
  state.error = *priors_.error * decid::exp(decid::log(priors_.error_factor) * x[size() - 1]);
  return state;
}

void Density::add_factors(std::size_t parameter, std::span<const double> x, const State& here,
                          std::vector<Factor>& factors) const {
  const std::size_t coordinate = *place_of_[parameter];
  const posterior::Quantile& prior = quantiles_[parameter];
  const double slope = prior.sd > 0.0 ? prior.slope_in_tails(x[coordinate]) : prior.slope_at(x[coordinate]);
  const sim::Family& family = model_.protocol().family();
  if (dead_band_ && parameter == dead_band_->theta) return;
  if (dead_band_ && parameter == dead_band_->nv)
    return factors.push_back({coordinate, ResponseModel::by_passed, dead_band_->prior.at(x[coordinate], 0.5).by_rank});
  for (const sim::Family::Term& term : family.terms) {
    if (term.parameter != parameter) continue;
    double factor = slope * term.factor;
    auto derivative = static_cast<std::size_t>(term.coefficient);
    const bool is_nv = term.coefficient == sim::Coefficient::nv;
    if (is_nv || term.coefficient == sim::Coefficient::theta) {
      const sim::Coefficients c = family.coefficients(here.parameters);
      const auto slopes = model_.passing_slopes(c[sim::Coefficient::nv], c[sim::Coefficient::theta]);
      factor *= is_nv ? slopes.by_nv : slopes.by_theta;
      derivative = ResponseModel::by_passed;
    }
    factors.push_back({coordinate, derivative, factor});
  }
}

double Density::value(const State& state, int quantity) const {
  if (quantity == gain()) return state.gain;
  return quantity == error() ? state.error : state.parameters[static_cast<std::size_t>(quantity)];
}

void Density::respond(const State& state, std::span<Complex> responses) const {
  model_.respond(state.parameters, responses);
  for (Complex& response : responses) response *= state.gain;
}

double Density::variance(std::size_t row, Complex response, double relative_error) const {
  const double stddev = table_.rows[row].stddev;
  return stddev * stddev + relative_error * relative_error * std::norm(response);
}

void Density::respond(std::span<const double> x, const State& here, std::span<Complex> responses,
                      std::span<Complex> derived) const {
  const std::size_t rows = table_.rows.size();
  std::vector<Complex> by_coefficient(rows * ResponseModel::derivatives);
  model_.respond(here.parameters, responses, by_coefficient);
  std::vector<Factor> factors;
  for (const std::size_t parameter : free_) add_factors(parameter, x, here, factors);
  std::fill(derived.begin(), derived.end(), 0.0);
  for (std::size_t row = 0; row < rows; ++row) {
    const std::span<Complex> by = derived.subspan(row * size(), size());
    for (const Factor& factor : factors)
      by[factor.coordinate] +=
          here.gain * factor.factor * by_coefficient[row * ResponseModel::derivatives + factor.derivative];
    by[of_gain_] = 2.0 * priors_.gain * responses[row];
    responses[row] *= here.gain;
  }
}

// With h = gain H, v the variance and e = table - h: misfit = sum |e|^2 / (2 v) + log v, and the information of a
// complex number about its mean and the logarithm of its variance is Re(h_i* h_j) / v + (log v)_i (log v)_j.
void Density::evaluate(std::span<const double> x, Local& local) const {
  const State here = state(x);
  if (!is_stable(here)) {
    local.misfit = std::numeric_limits<double>::infinity();
    return;
  }
  const std::size_t rows = table_.rows.size(), count = size();
  std::vector<Complex> responses(rows), derived(rows * count);
  respond(x, here, responses, derived);
  const double spread = *priors_.error > 0.0 ? decid::log(priors_.error_factor) : 0.0;
  std::vector<double> by_log(count);  // by the logarithm of the variance
  local.misfit = 0.0;
  std::fill(local.gradient.begin(), local.gradient.end(), 0.0);
  std::fill(local.information.begin(), local.information.end(), 0.0);
  for (std::size_t row = 0; row < rows; ++row) {
    const Complex response = responses[row], rest = table_.rows[row].response - response;
    const double square = variance(row, response, here.error), precision = 1.0 / square;
    const double relative = here.error * here.error;
    const std::span<const Complex> by = std::span(derived).subspan(row * count, count);
    for (std::size_t i = 0; i < count; ++i) by_log[i] = 2.0 * relative * precision * real_product(response, by[i]);
    by_log.back() = 2.0 * relative * precision * std::norm(response) * spread;
    const double excess = 1.0 - 0.5 * std::norm(rest) * precision;
    local.misfit += 0.5 * std::norm(rest) * precision + decid::log(square);
    for (std::size_t i = 0; i < count; ++i) {
      local.gradient[i] += excess * by_log[i] - precision * real_product(rest, by[i]);
      for (std::size_t j = 0; j <= i; ++j)
        local.information[triangle(i) + j] += precision * real_product(by[i], by[j]) + by_log[i] * by_log[j];
    }
  }
}

void Density::log_densities(const State& state, std::span<double> values) const {
  std::vector<Complex> responses(table_.rows.size());
  respond(state, responses);
  for (std::size_t i = 0; i < responses.size(); ++i) {
    const double square = variance(i, responses[i], state.error);
    values[i] = -0.5 * std::norm(table_.rows[i].response - responses[i]) / square - decid::log(2.0 * sim::pi * square);
  }
}

double Density::chi_square(const State& state, double relative_error) const {
  std::vector<Complex> responses(table_.rows.size());
  respond(state, responses);
  double sum = 0.0;
  for (std::size_t i = 0; i < responses.size(); ++i)
    sum += std::norm(table_.rows[i].response - responses[i]) / variance(i, responses[i], relative_error);
  return sum;
}

}  // namespace decid::frf
