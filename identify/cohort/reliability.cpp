// Reliability of repeated visits: see reliability.hpp.
#include "identify/cohort/reliability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/error.hpp"
#include "base/math/incomplete_beta.hpp"
#include "base/math/statistics.hpp"
#include "base/text.hpp"

namespace decid::cohort {
namespace {

constexpr double normal_975 = 1.9599639845400543;

/// Mean squares of a two-way table.
struct MeanSquares {
  double participants, visits, rest;
};
MeanSquares mean_squares(std::size_t visits, std::span<const double> values) {
  const std::size_t participants = values.size() / visits;
  const double all = mean(values);
  std::vector<double> of_participant, of_visit(visits, 0.0);
  for (std::size_t i = 0; i < participants; ++i) of_participant.push_back(mean(values.subspan(i * visits, visits)));
  for (std::size_t i = 0; i < values.size(); ++i) of_visit[i % visits] += values[i] / static_cast<double>(participants);
  double between_participants = 0.0, between_visits = 0.0, rest = 0.0;
  for (const double value : of_participant) between_participants += (value - all) * (value - all);
  for (const double value : of_visit) between_visits += (value - all) * (value - all);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double off = values[i] - of_participant[i / visits] - of_visit[i % visits] + all;
    rest += off * off;
  }
  const auto n = static_cast<double>(participants), k = static_cast<double>(visits);
  return {k * between_participants / (n - 1.0), n * between_visits / (k - 1.0), rest / ((n - 1.0) * (k - 1.0))};
}

/// Returns minus infinity where the denominator, an estimated variance, is 0 or below: the quotient's limit there.
double variance_ratio(double numerator, double denominator, double scale) {
  return denominator > 1e-12 * scale ? numerator / denominator : -INFINITY;
}

/// Returns the interval of ICC(2,1) or, with `average`, ICC(2,k). odds: of the same ICC, which is irr's choice.
std::array<double, 2> interval_of(double odds, const MeanSquares& squares, double n, double k, bool average) {
  const double a = k * odds / n, b = 1.0 + k * odds * (n - 1.0) / n;
  const double by_visits = a * squares.visits, by_rest = b * squares.rest, sum = by_visits + by_rest;
  const double freedom = sum * sum / (by_visits * by_visits / (k - 1.0) + by_rest * by_rest / ((n - 1.0) * (k - 1.0)));
  const double low = f_critical(0.025, n - 1.0, freedom), high = f_critical(0.025, freedom, n - 1.0);
  const double others = average ? squares.visits - squares.rest : k * squares.visits + (k * n - k - n) * squares.rest;
  const double scale = n * (squares.participants + squares.visits + squares.rest);
  const double below = n * (squares.participants - low * squares.rest);
  const double above = n * (high * squares.participants - squares.rest);
  return {variance_ratio(below, low * others + n * squares.participants, scale),
          variance_ratio(above, others + n * high * squares.participants, scale)};
}

/// Returns the interval, or NaN for both ends if the estimate lies outside. Below 0, ICC(2,1) has a difference of mean
/// squares where Satterthwaite's degrees of freedom need a sum: few people then have far below one degree, whose
/// quantiles of F make both ends about the same number.
std::array<double, 2> if_around(double estimate, const std::array<double, 2>& interval) {
  const double rounding = 1e-9 * (1.0 + std::abs(estimate));
  const bool is_around =
      estimate == interval[0] || (interval[0] <= estimate + rounding && estimate <= interval[1] + rounding);
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  return is_around ? interval : std::array{unknown, unknown};
}

}  // namespace

Reliability reliability(std::size_t visits, std::span<const double> values,
                        std::span<const double> measurement_variances) {
  const std::size_t participants = visits > 0 ? values.size() / visits : 0;
  if (visits < 2 || participants < 2 || participants * visits != values.size() ||
      (!measurement_variances.empty() && measurement_variances.size() != values.size()))
    throw Error(Code::size_mismatch, "reliability", format("%zu values of %zu visits", values.size(), visits),
                "give two participants or more, two visits or more, and a value for each");
  const MeanSquares squares = mean_squares(visits, values);
  const auto n = static_cast<double>(participants), k = static_cast<double>(visits);
  const double whole = squares.participants + squares.visits + squares.rest;
  if (!std::isfinite(whole) || whole <= 0.0)
    throw Error(Code::value_invalid, "reliability", "the values are all equal, or one is not finite",
                "leave this parameter out");

  Reliability found;
  found.participants = participants;
  const double visit_variance = (squares.visits - squares.rest) / n,
               participant_part = squares.participants - squares.rest;
  found.icc_single =
      variance_ratio(participant_part, squares.participants + (k - 1.0) * squares.rest + k * visit_variance, whole);
  found.icc_average = variance_ratio(participant_part, squares.participants + visit_variance, whole);
  constexpr double rounding = 1e-20;
  const double nothing = rounding * (squares.participants + squares.visits);
  if (squares.rest > nothing) {
    const double odds = participant_part / (squares.rest + visit_variance);  // ICC / (1 - ICC) of the mean of all k
    found.icc_single95 = if_around(found.icc_single, interval_of(odds / k, squares, n, k, false));
    found.icc_average95 = if_around(found.icc_average, interval_of(odds, squares, n, k, true));
  } else if (squares.visits > nothing) {  // everybody changes by the same amount: the interval's freedom is 0 over 0
    found.icc_single95.fill(std::numeric_limits<double>::quiet_NaN());
    found.icc_average95 = found.icc_single95;
  } else {  // visits agree
    found.icc_single95 = {found.icc_single, found.icc_single};
    found.icc_average95 = {found.icc_average, found.icc_average};
  }
  found.standard_error = std::sqrt(squares.rest + std::max(0.0, visit_variance));
  found.minimal_detectable_change = normal_975 * std::sqrt(2.0) * found.standard_error;
  found.participant_sd = std::sqrt(std::max(0.0, participant_part / k));
  found.visit_sd = std::sqrt(std::max(0.0, visit_variance));
  const double measured = measurement_variances.empty() ? 0.0 : mean(measurement_variances);
  found.measurement_sd = std::sqrt(measured);
  found.within_participant_sd = std::sqrt(std::max(0.0, squares.rest - measured));
  return found;
}

}  // namespace decid::cohort
