// Posteriors of published frequency responses: see fit.hpp.
#include "posterior/frf/fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "base/math/statistics.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "posterior/sampling/diagnostics.hpp"
#include "posterior/streams.hpp"

namespace decid::frf {
namespace {

using sim::Complex;

constexpr double unlikely = 0.01;
// No controller of the model explains a table that is this far from all of them.
constexpr double impossible = 1e-6, max_left = 0.2;
/// A table that is fitted better than 999 of 1000 by its confidence has another confidence.
constexpr double too_likely = 0.999;
constexpr std::size_t prior_draws = 4096;
constexpr std::uint64_t of_prior = std::uint64_t{1} << 32;  // the particle number of these random numbers

double phase_deg(Complex response) {
  return decid::atan2(response.imag(), response.real()) / sim::rad_per_deg;
}

constexpr char within_priors[] = "within the given ranges, priors and fixed values";
constexpr char remedy_for_priors[] = "; leave out the given ones to see whether another controller does";

/// Returns the standard deviations of the quantities under the prior, over stable loops.
std::vector<double> prior_stddevs(const Density& density, std::uint64_t seed) {
  const Random random(seed, posterior::streams::particles, of_prior);
  std::vector<std::vector<double>> values(static_cast<std::size_t>(density.quantities()));
  std::vector<double> x(density.size());
  for (std::size_t i = 0; i < prior_draws; ++i) {
    for (std::size_t k = 0; k < x.size(); ++k)
      x[k] = k < density.uniform() ? random.uniform(i * x.size() + k) : random.normal(i * x.size() + k);
    const State state = density.state(x);
    if (!density.is_stable(state)) continue;
    for (int q = 0; q < density.quantities(); ++q)
      values[static_cast<std::size_t>(q)].push_back(density.value(state, q));
  }
  std::vector<double> stddevs;
  for (const std::vector<double>& of_quantity : values) stddevs.push_back(decid::stddev(of_quantity));
  return stddevs;
}

}  // namespace

Warnings no_controller_warnings(const Density& density, double left, double p_value) {
  if (!(left > max_left) || p_value >= impossible) return {};
  std::string text = format(
      "no controller %s explains the table: the best ones leave %.0f%% of the response unexplained (root mean square "
      "of the relative error), so do not use their parameters%s",
      density.has_given_priors() ? within_priors : "of this model", 100.0 * left,
      density.has_given_priors() ? remedy_for_priors : "");
  if (!density.table().has_confidence())
    text += "; the table may also be noisy: add a column sd or ci95, or coherence and cycles, which shows it";
  return {{Severity::invalid, "no_controller", text}};
}

double chi_square_beyond(double chi_square, int degrees_of_freedom) {
  if (!(chi_square > 0.0)) return 1.0;
  // In logarithms: exp(-chi_square / 2) is 0 for a table of 710 rows that is fitted perfectly.
  double log_term = -0.5 * chi_square, sum = 0.0;
  for (int i = 0; i < degrees_of_freedom / 2; ++i) {
    sum += decid::exp(log_term);
    log_term += decid::log(0.5 * chi_square / (i + 1));
  }
  return std::min(1.0, sum);
}

State Fit::state(int draw) const {
  const auto number = static_cast<std::size_t>(draw);
  State state;
  state.parameters = sim::Parameters(draws_.size() - 2);
  for (std::size_t p = 0; p < state.parameters.size(); ++p) state.parameters[p] = draws_[p].at(number);
  state.gain = draws_for(gain()).at(number);
  state.error = draws_for(error()).at(number);
  return state;
}

std::vector<std::vector<double>> Fit::chains_for(int quantity) const {
  const std::vector<double>& all = draws_for(quantity);
  std::vector<std::vector<double>> chains;
  for (int chain = 0; chain < chains_; ++chain) {
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(chain) * draws_per_chain();
    chains.emplace_back(first, first + draws_per_chain());
  }
  return chains;
}

double Fit::mean(int quantity) const {
  return decid::mean(draws_for(quantity));
}

double Fit::stddev(int quantity) const {
  return decid::stddev(draws_for(quantity));
}

double Fit::quantile(int quantity, double probability) const {
  return decid::quantile(draws_for(quantity), probability);
}

double Fit::correlation(int a, int b) const {
  return decid::correlation(draws_for(a), draws_for(b));
}

double Fit::contraction(int quantity) const {
  const double before = prior_stddev(quantity);
  if (before == 0.0) return 0.0;
  const double remaining = stddev(quantity) / before;
  return std::max(0.0, 1.0 - remaining * remaining);
}

bool Fit::agreed() const {
  return posterior::chains_agree(rhat_, effective_);
}

void Fit::predict(const Density& density, const std::vector<State>& states) {
  const std::size_t rows = density.table().rows.size();
  const bool confident = density.table().has_confidence();
  const double count = static_cast<double>(states.size());
  std::vector<std::vector<Complex>> responses(rows);
  std::vector<Complex> here(rows);
  misfit_.degrees_of_freedom = 2 * static_cast<int>(rows);
  for (const State& state : states) {
    density.respond(state, here);
    for (std::size_t i = 0; i < rows; ++i) responses[i].push_back(here[i]);
    const double chi_square = density.chi_square(state, confident ? 0.0 : state.error);
    misfit_.chi_square += chi_square / count;
    misfit_.p_value += chi_square_beyond(chi_square, misfit_.degrees_of_freedom) / count;
  }
  if (!confident) misfit_.p_value = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < rows; ++i) {
    Complex sum = 0.0;
    for (const Complex response : responses[i]) sum += response;
    const Complex middle = sum / count;
    const double middle_deg = phase_deg(middle);
    std::vector<double> gains, phases;
    for (const Complex response : responses[i]) {
      gains.push_back(std::sqrt(std::norm(response)));
      phases.push_back(middle_deg + phase_deg(response * std::conj(middle)));
    }
    const double variance = density.variance(i, middle, confident ? 0.0 : mean(error()));
    predicted_.push_back({middle, decid::quantile(gains, 0.05), decid::quantile(gains, 0.95), middle_deg,
                          decid::quantile(phases, 0.05), decid::quantile(phases, 0.95),
                          std::sqrt(std::norm(density.table().rows[i].response - middle) / variance)});
    left_ += std::norm(density.table().rows[i].response - middle) / std::norm(density.table().rows[i].response);
  }
  left_ = std::sqrt(left_ / static_cast<double>(rows));
}

bool Fit::explained() const {
  return !has_code(warnings_, "no_controller");
}

void Fit::warn(const Density& density) {
  warnings_ = no_controller_warnings(density, left_, misfit_.p_value);
  const double worst = *std::ranges::max_element(rhat_);
  if (!(worst <= posterior::max_lone_rhat))  // as of recordings without a network
    add_caution(warnings_, "chains_disagree",
                format("the chains do not agree (R-hat %.3f): the table may fit more than one controller", worst));
  else if (!agreed())
    add_info(
        warnings_, "few_draws",
        format("the chains agree roughly (R-hat %.3f, %.0f effective draws at least): means and intervals are less "
               "accurate than usual; run again with another ",
               worst, *std::ranges::min_element(effective_)) +
            setting("seed"));
  const Priors& priors = density.priors();
  if (misfit_.p_value < unlikely) {
    add_caution(
        warnings_, "table_unexplained",
        format("%s the table: chi-square is %.3g at %d degrees of freedom by its %s (p = %.2g)%s%s",
               density.has_given_priors() ? (std::string("no controller ") + within_priors + " explains").c_str()
                                          : "the model does not explain",
               misfit_.chi_square, misfit_.degrees_of_freedom, density.table().confidence.c_str(), misfit_.p_value,
               *priors.error > 0.0
                   ? format("; the intervals attribute the rest, %.0f%% of the response, to errors of the table",
                            100.0 * left_)
                         .c_str()
                   : "; the intervals are too narrow",
               density.has_given_priors() ? remedy_for_priors : ""));
  }
  if (misfit_.p_value > too_likely)
    add_caution(
        warnings_, "confidence_too_large",
        format("the controllers lie much nearer to the table than its %s says (chi-square %.3g at %d degrees of "
               "freedom, p = %.4g): it may be in another unit, such as percent, or be the standard deviation of "
               "people instead of their mean's; the intervals are then too wide",
               density.table().confidence.c_str(), misfit_.chi_square, misfit_.degrees_of_freedom, misfit_.p_value));
  std::vector<double> means;
  for (int p = 0; p < density.gain(); ++p) means.push_back(mean(p));
  const std::string contradicted = posterior::contradicted_priors(priors.parameters, density.ranges(), means);
  if (!contradicted.empty())
    add_caution(warnings_, "prior_contradicted",
                "the table and the prior contradict each other in " + contradicted +
                    ": the values lie more than 5 of the prior's standard deviations from its mean; check the prior's "
                    "unit and the table");
  if (!density.table().has_confidence() && quantile(error(), 0.05) > *priors.error * priors.error_factor) {
    add_caution(
        warnings_, "response_unexplained",
        format("the model leaves %.0f%% of the response unexplained, far more than the %.2g%% expected: the intervals "
               "attribute it to errors of the table",
               100.0 * left_, 100.0 * *priors.error));
  }
}

Fit fit(const Density& density, const SmcSettings& settings) {
  const SmcResult result = sample_smc(
      density.size(), density.uniform(), [&](std::span<const double> x, Local& local) { density.evaluate(x, local); },
      settings);
  Fit found;
  found.chains_ = settings.chains;
  found.draws_.resize(static_cast<std::size_t>(density.quantities()));
  std::vector<State> states;
  for (const std::vector<double>& chain : result.chains) {
    for (std::size_t at = 0; at < chain.size(); at += density.size())
      states.push_back(density.state(std::span(chain).subspan(at, density.size())));
  }
  for (int q = 0; q < density.quantities(); ++q)
    for (const State& state : states) found.draws_[static_cast<std::size_t>(q)].push_back(density.value(state, q));
  found.prior_stddevs_ = prior_stddevs(density, settings.seed);
  // Quantities are judged, not coordinates: Nv and theta depend on two each.
  for (int q = 0; q < density.quantities(); ++q) {
    const posterior::ChainDraws chains = found.chains_for(q);
    found.rhat_.push_back(posterior::rhat(chains));
    found.effective_.push_back(posterior::effective_draws(chains));
  }
  found.acceptance_ = result.acceptance;
  found.evaluations_ = result.evaluations;
  found.predict(density, states);
  found.warn(density);
  return found;
}

}  // namespace decid::frf
