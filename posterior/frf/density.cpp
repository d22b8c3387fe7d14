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

struct Pair {
  std::size_t quantity;
  ResponseModel::Derivative derivative;
};
constexpr Pair derivative_of[] = {{sim::Kp, ResponseModel::by_kp},           {sim::Kd, ResponseModel::by_kd},
                                  {sim::Kp_pass, ResponseModel::by_kp_pass}, {sim::Kd_pass, ResponseModel::by_kd_pass},
                                  {sim::Delay, ResponseModel::by_delay},     {sim::Nv, ResponseModel::by_passed}};

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
      ranges_(protocol.ranges()),
      model_(protocol, table_),
      dead_band_(ranges_, [&](double nv, double theta) { return model_.passing_gain(nv, theta); }) {}

State Density::state(std::span<const double> x) const {
  State state;
  state.parameters = sim::Parameters(ranges_.size());
  for (std::size_t i = 0; i < ranges_.size(); ++i) {
    if (i != sim::Nv && i != sim::Theta) state.parameters[i] = ranges_[i].low + ranges_[i].range() * x[i];
  }
  const DeadBandPrior::Point point = dead_band_.at(x[sim::Nv], x[sim::Theta]);
  state.parameters[sim::Nv] = point.nv;
  state.parameters[sim::Theta] = point.theta;
  state.gain = 1.0 + priors_.gain * (2.0 * x[gain] - 1.0);
  state.error = *priors_.error * decid::exp(decid::log(priors_.error_factor) * x[error]);
  return state;
}

std::array<double, Density::quantities> Density::by_coordinates(std::span<const double> x) const {
  std::array<double, quantities> by{};
  for (std::size_t i = 0; i < ranges_.size(); ++i) by[i] = ranges_[i].range();
  by[sim::Nv] = dead_band_.at(x[sim::Nv], 0.5).by_rank;
  by[sim::Theta] = 0.0;
  by[gain] = 2.0 * priors_.gain;
  return by;
}

double Density::value(const State& state, int quantity) {
  if (quantity == gain) return state.gain;
  return quantity == error ? state.error : state.parameters[static_cast<std::size_t>(quantity)];
}

void Density::respond(const State& state, std::span<Complex> responses) const {
  model_.respond(state.parameters, responses);
  for (Complex& response : responses) response *= state.gain;
}

double Density::variance(std::size_t row, Complex response, double relative_error) const {
  const double deviation = table_.rows[row].deviation;
  return deviation * deviation + relative_error * relative_error * std::norm(response);
}

// With h = gain H, v the variance and e = table - h: misfit = sum |e|^2 / (2 v) + log v, and the information of a
// complex number about its mean and the logarithm of its variance is Re(h_i* h_j) / v + (log v)_i (log v)_j.
void Density::evaluate(std::span<const double> x, Local& local) const {
  const State here = state(x);
  if (!is_stable(here)) {
    local.misfit = std::numeric_limits<double>::infinity();
    return;
  }
  const std::size_t rows = table_.rows.size();
  std::vector<Complex> responses(rows), derived(rows * ResponseModel::derivatives);
  model_.respond(here.parameters, responses, derived);
  const std::array<double, quantities> scale = by_coordinates(x);
  const double spread = *priors_.error > 0.0 ? decid::log(priors_.error_factor) : 0.0;
  local.misfit = 0.0;
  std::fill(local.gradient.begin(), local.gradient.end(), 0.0);
  std::fill(local.information.begin(), local.information.end(), 0.0);
  for (std::size_t row = 0; row < rows; ++row) {
    const Complex response = here.gain * responses[row], rest = table_.rows[row].response - response;
    const double square = variance(row, response, here.error), precision = 1.0 / square;
    const double relative = here.error * here.error;
    std::array<Complex, quantities> by{};
    for (const auto& [quantity, derivative] : derivative_of)
      by[quantity] = here.gain * scale[quantity] * derived[row * ResponseModel::derivatives + derivative];
    by[gain] = scale[gain] * responses[row];
    std::array<double, quantities> by_log{};  // by the logarithm of the variance
    for (std::size_t i = 0; i < quantities; ++i) by_log[i] = 2.0 * relative * precision * real_product(response, by[i]);
    by_log[error] = 2.0 * relative * precision * std::norm(response) * spread;
    const double excess = 1.0 - 0.5 * std::norm(rest) * precision;
    local.misfit += 0.5 * std::norm(rest) * precision + decid::log(square);
    for (std::size_t i = 0; i < quantities; ++i) {
      local.gradient[i] += excess * by_log[i] - precision * real_product(rest, by[i]);
      for (std::size_t j = 0; j <= i; ++j)
        local.information[triangle(i) + j] += precision * real_product(by[i], by[j]) + by_log[i] * by_log[j];
    }
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
