// Point estimates of published frequency responses: see least_squares.hpp.
#include "posterior/frf/least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/math/cholesky.hpp"
#include "base/math/math.hpp"
#include "posterior/density/elementary.hpp"
#include "posterior/frf/fit.hpp"

namespace decid::frf {
namespace {

using sim::Complex;

constexpr double near_end = 1e-6;  // of a range

Complex log_of(Complex value) {
  return {0.5 * decid::log(std::norm(value)), decid::atan2(value.imag(), value.real())};
}

PointEstimate estimate_at(const Density& density, const std::vector<double>& x, const Optimum& optimum) {
  PointEstimate made;
  made.state = density.state(x);
  made.misfit = optimum.misfit;
  made.agreeing = optimum.agreeing;
  const sim::Coefficients c = density.model().protocol().family().coefficients(made.state.parameters);
  made.passing_gain = density.model().passing_gain(c[sim::Coefficient::nv], c[sim::Coefficient::theta]);
  const std::vector<Row>& rows = density.table().rows;
  made.responses.resize(rows.size());
  density.respond(made.state, made.responses);
  for (std::size_t i = 0; i < rows.size(); ++i)
    made.left += std::norm(rows[i].response - made.responses[i]) / std::norm(rows[i].response);
  made.left = std::sqrt(made.left / static_cast<double>(rows.size()));
  for (int p = 0; p < density.gain(); ++p) {
    const auto place = density.find_coordinate(p);
    made.at_end.push_back(place && (x[*place] < near_end || x[*place] > 1.0 - near_end));
  }
  return made;
}

Density without_normal_priors(const Density& density) {
  Priors priors = density.priors();
  for (posterior::ParameterPrior& prior : priors.parameters) prior.normal.reset();
  return {density.model().protocol(), density.table(), priors};
}

}  // namespace

std::vector<double> log_ratio_weights(const Table& table) {
  std::vector<double> weights;
  double sum = 0.0;
  for (const Row& row : table.rows) {
    weights.push_back((row.coherence > 0.0 ? row.coherence : 1.0) / row.frequency_hz);
    sum += weights.back();
  }
  for (double& weight : weights) weight *= static_cast<double>(weights.size()) / sum;
  return weights;
}

PointEstimate fit_log_ratio(const Density& density, const OptimumSettings& settings) {
  if (density.uniform() + 1 < density.size()) return fit_log_ratio(without_normal_priors(density), settings);
  const std::vector<Row>& rows = density.table().rows;
  const std::vector<double> weights = log_ratio_weights(density.table());
  const std::size_t size = density.size(), parameters = size - 2;
  const auto whole = [&](std::span<const double> x) {
    std::vector<double> all(x.begin(), x.end());
    all.insert(all.end(), {0.5, 0.0});  // the gain is 1
    return all;
  };
  const auto evaluate = [&](std::span<const double> x, Local& local) {
    const std::vector<double> all = whole(x);
    const State here = density.state(all);
    if (!density.is_stable(here)) {
      local.misfit = std::numeric_limits<double>::infinity();
      return;
    }
    std::vector<Complex> responses(rows.size()), derived(rows.size() * size);
    density.respond(all, here, responses, derived);
    local.misfit = 0.0;
    std::fill(local.gradient.begin(), local.gradient.end(), 0.0);
    std::fill(local.information.begin(), local.information.end(), 0.0);
    for (std::size_t row = 0; row < rows.size(); ++row) {
      const Complex ratio = log_of(posterior::quotient(responses[row], rows[row].response));
      local.misfit += 0.5 * weights[row] * std::norm(ratio);
      std::vector<Complex> by(parameters);
      for (std::size_t i = 0; i < parameters; ++i) {
        by[i] = posterior::quotient(derived[row * size + i], responses[row]);
        local.gradient[i] += weights[row] * (ratio * std::conj(by[i])).real();
        for (std::size_t j = 0; j <= i; ++j)
          local.information[triangle(i) + j] += weights[row] * (by[i] * std::conj(by[j])).real();
      }
    }
  };
  const Optimum optimum = minimise(parameters, parameters, evaluate, settings);
  PointEstimate made = estimate_at(density, whole(optimum.x), optimum);
  made.state.error = 0.0;
  const double p_value = density.table().has_confidence()
                             ? chi_square_beyond(density.chi_square(made.state, 0.0), 2 * static_cast<int>(rows.size()))
                             : std::numeric_limits<double>::quiet_NaN();
  made.warnings = no_controller_warnings(density, made.left, p_value);
  return made;
}

}  // namespace decid::frf
