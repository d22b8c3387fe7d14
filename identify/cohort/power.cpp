// Power of a study: see power.hpp.
#include "identify/cohort/power.hpp"

#include <cmath>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/text.hpp"
#include "identify/network/student_t.hpp"

namespace decid::cohort {
namespace {

constexpr std::size_t max_participants = 10'000, max_trials = 1'000;

/// Returns P(|T| > critical) of Student's noncentral distribution: over the found standard deviation s, relative to the
/// true one, whose logarithm is integrated by the trapezoidal rule.
double noncentral_tails(double critical, double noncentrality, double freedom) {
  const double half_width = 12.0 / std::sqrt(freedom) + 0.05, half = 0.5 * freedom;
  constexpr int grid = 400;
  const double low = -half_width * (freedom < 6.0 ? 3.0 : 1.0), step = (half_width - low) / grid;
  double sum = 0.0, whole = 0.0;
  for (int i = 0; i <= grid; ++i) {
    const double log_s = low + step * i, s = exp(log_s);
    const double density = exp(freedom * log_s - half * (s * s - 1.0));  // of log s, up to a constant
    whole += density;
    sum += density *
           (normal_distribution(noncentrality - critical * s) + normal_distribution(-noncentrality - critical * s));
  }
  return sum / whole;
}

double variance_of(const PowerDesign& design) {
  const double own = design.paired ? design.visit_sd : design.participant_sd;
  return own * own + (design.trial_sd * design.trial_sd + design.measurement_sd * design.measurement_sd) /
                         static_cast<double>(design.trials);
}

struct Limits {
  std::size_t low, high;
};

/// Returns the smallest value of the count within the limits with at least this power; 0: the highest does not reach
/// it.
std::size_t smallest(std::size_t PowerDesign::*count, Limits within, PowerDesign& design, double difference,
                     double power, double significance) {
  if (!(power > 0.0 && power < 1.0))
    throw Error(Code::setting_out_of_range, "power", format("a power of %g is wanted", power),
                "give one between 0 and 1");
  const auto enough = [&](std::size_t value) {
    design.*count = value;
    return power_of(design, difference, significance) >= power;
  };
  if (!enough(within.high)) return 0;
  while (within.low < within.high) {
    const std::size_t middle = (within.low + within.high) / 2;
    enough(middle) ? within.high = middle : within.low = middle + 1;
  }
  return within.low;
}

}  // namespace

double power_of(const PowerDesign& design, double difference, double significance) {
  double lowest = 0.0;
  for (const double sd : {design.participant_sd, design.visit_sd, design.trial_sd, design.measurement_sd})
    if (!(sd >= 0.0)) lowest = sd;
  if (design.participants < 2 || design.trials < 1 || !(lowest >= 0.0))
    throw Error(
        Code::setting_out_of_range, "power",
        format("%zu participants, %zu trials, standard deviation %g", design.participants, design.trials, lowest),
        "give two participants or more, one trial or more, and standard deviations of 0 or more");
  const double variance = variance_of(design);
  if (!(variance > 0.0) || !std::isfinite(variance) || !std::isfinite(difference))
    throw Error(Code::value_invalid, "power", format("the variance is %g and the difference %g", variance, difference),
                "give finite values, and a standard deviation above 0");
  const auto n = static_cast<double>(design.participants);
  const double freedom = design.paired ? n - 1.0 : 2.0 * n - 2.0;
  return noncentral_tails(student_t_critical(significance, freedom),
                          std::abs(difference) / std::sqrt(2.0 * variance / n), freedom);
}

std::size_t participants_for(PowerDesign design, double difference, double power, double significance) {
  return smallest(&PowerDesign::participants, {2, max_participants}, design, difference, power, significance);
}

std::size_t trials_for(PowerDesign design, double difference, double power, double significance) {
  return smallest(&PowerDesign::trials, {1, max_trials}, design, difference, power, significance);
}

}  // namespace decid::cohort
