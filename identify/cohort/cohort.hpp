// A hierarchical model over the participants of a study, from the posteriors of their recordings. Every recording keeps
// its whole uncertainty, and participants whose recordings determine little count little.
//
//   std::vector<cohort::Recording> recordings;
//   recordings.push_back({"p1", "", "patients", "", {}, cohort::Measurement::of_draws(7, fractions)});
//   const cohort::Result found = cohort::analyse(recordings, ranges, {});
//   use(found.comparisons[0].effects[sim::Kp].difference.interval95);
//
// In the coordinates x of measurement.hpp, for recording t of person i in cell c (one group, session and condition):
//   x_it = b_c + g z_it + u_i + v_ic + e_it,   u ~ N(0, T_group),  v ~ N(0, V),  e ~ N(0, W), independent by parameter
//   data: the evidence of each recording about x_it (all parameters together, with their correlations)
// v exists if a person is in two cells or more, e if a visit (a person in a cell) has two recordings or more. So
// several recordings of a person share the person's level, and differ by a trial's own deviation, whose size the study
// determines. A plain product of their likelihoods (e = 0) would take trials of one person for copies, and its
// intervals are then too narrow.
//
// Priors: b_c ~ N(0, 1), which is uniform over the range; g ~ N(0, 1/4) per standard deviation of a covariate; a
// standard deviation s of a level has density 1 / sqrt(s^2 + c^2) up to 1, where c^2 is the variance that the levels
// below leave in a person's or visit's mean (G. Box, G. Tiao, Bayesian Inference in Statistical Analysis, 1973, chapter
// 5): for precise recordings of many participants the intervals are those of Student's t. Groups have standard
// deviations of their own, whose logarithms differ from a common one by N(0, 0.3^2); groups that share participants
// have a common one. With two participants a group these priors make the interval half as wide as Student's, and it
// contains 92.5% (1,400 intervals of 95%).
//
// Sampling: Gibbs (sampler.hpp), exact for the evidence. The first stage's posterior under its own prior is the
// proposal, and its prior is divided out (D. Lunn, J. Barrett, M. Sweeting, S. Thompson, Appl. Stat. 62 (2013)
// 551-572). The result depends only on the settings, not on threads or machine.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "identify/cohort/measurement.hpp"
#include "sim/parameters.hpp"

namespace decid::cohort {

/// One recording of a study. Empty texts are values as others are.
struct Recording {
  std::string participant, session, group, condition;
  std::vector<double> covariates;  ///< such as age and weight, one per name in Settings; NaN: unknown, the mean counts
  Measurement measurement;
};

/// A recording, by its place in a report, that the model cannot use, and why: `no_distribution` (a model without
/// intervals, or a network's answer beside fixed parameters), `few_draws` (fewer than 16), `other_ranges` (relative to
/// its body, they are not the report's), `narrow_prior` (narrower than what the recording tells) or `flat_draws`
/// (parameters are perfectly correlated).
struct WithoutEvidence {
  std::size_t recording = 0;
  std::string reason;
  bool operator==(const WithoutEvidence&) const = default;
};

struct Settings {
  std::uint64_t seed = 1;
  int chains = 4;
  int warm_up = 250;  ///< sweeps of each chain that are not kept
  int draws = 1000;   ///< sweeps of each chain that are kept
  std::vector<std::string> covariates = {};
};

/// A quantity's posterior: mean, standard deviation, the central 95% interval, and R-hat of its chains.
struct Quantity {
  double mean = 0.0, sd = 0.0;
  std::array<double, 2> interval95{};
  double rhat = 1.0;  ///< posterior/sampling/diagnostics.hpp; 1 of a quantity that is known
};

/// The group of studies without groups.
inline constexpr const char* everyone = "all";
/// Returns "patients, 1, open": the parts that are not empty. Leaves out `everyone` if there are others.
std::string cell_name(const std::string& group, const std::string& session, const std::string& condition);

/// Returns true if exactly one of group, session and condition differs: such cells are compared.
template <class First, class Second>
bool differ_in_one(const First& a, const Second& b) {
  return (a.group != b.group ? 1 : 0) + (a.session != b.session ? 1 : 0) + (a.condition != b.condition ? 1 : 0) == 1;
}

/// Returns true if the second of two sessions in NameOrder is the later one. Words such as pre and post, or baseline
/// and follow-up, count before the order of names: "post" stands before "pre".
bool second_is_later(const std::string& first, const std::string& second);

/// Returns true if the difference of two cells that are compared is the second, the later session, minus the first;
/// a difference of groups or conditions is the first minus the second.
template <class First, class Second>
bool second_is_minuend(const First& a, const Second& b) {
  return a.session != b.session && second_is_later(a.session, b.session);
}

/// One group in one session and condition.
struct Cell {
  std::string group, session, condition;
  std::size_t participants = 0, recordings = 0;
  std::vector<Quantity> mean;  ///< per parameter, SI units: mean of the population, at the covariates' means
  std::vector<Quantity>
      between_sd;  ///< per parameter: standard deviation of participants, without measurement and trials

  std::string name() const { return cell_name(group, session, condition); }
};

/// The difference of two cells in one parameter.
struct Effect {
  Quantity difference;                     ///< first less second, SI units
  std::array<double, 2> simultaneous95{};  ///< all parameters of all comparisons and interactions: joint 95%
  Quantity standardised;   ///< over the root of the cells' mean between-person variance; `mean` is the median
  double direction = 0.5;  ///< the probability that the difference has its likelier sign
};

/// Two cells that differ in the group, the session or the condition only.
struct Comparison {
  std::size_t first = 0, second = 0;     ///< cells; of two sessions the later one is first
  std::size_t participants_in_both = 0;  ///< above 0: paired
  std::vector<Effect> effects;           ///< per parameter
};

/// The difference of two differences: of comparisons within two groups or sessions, from one session or condition to
/// the same other one. It says how much more one group changes than the other.
struct Interaction {
  std::size_t first = 0, second = 0;  ///< comparisons; of two sessions the later one's is first
  std::vector<Effect> effects;        ///< per parameter, first less second
};

/// The change of a parameter per unit of a covariate.
struct Slope : Quantity {
  double direction = 0.5;  ///< the probability that the slope has its likelier sign
};
struct Covariate {
  std::string name;
  double mean = 0.0;        ///< of the recordings; cells' means are at this value
  std::size_t unknown = 0;  ///< recordings without a value: they have the mean of the person's others, else of the
                            ///< group, else of the study
  std::vector<Slope> slopes;
};

/// The standard deviations of a parameter's parts, SI units, at the middle of the cells' means.
struct VarianceParts {
  Quantity participant;      ///< between participants
  Quantity visit;            ///< between visits of a person; 0 if nobody has two
  Quantity trial;            ///< between trials of a visit; 0 if no visit has two
  double measurement = 0.0;  ///< a recording's own uncertainty: the median of the recordings, prior divided out
};

/// A person in one cell.
struct Visit {
  std::string participant;
  std::size_t cell = 0, recordings = 0;
  std::vector<Quantity> value;  ///< per parameter, SI units; the study's other participants inform it
};

/// Returns true if the interval excludes 0; else a change is within measurement error.
inline bool excludes_zero(const Quantity& change) {
  return change.interval95[0] > 0.0 || change.interval95[1] < 0.0;
}

/// Two visits of a person, in cells of one comparison.
struct Change {
  std::size_t comparison = 0, first = 0, second = 0;  ///< visits
  std::vector<Quantity> difference;  ///< per parameter, first less second; the others' changes inform it
  std::vector<Quantity> own = {};    ///< the same by the person's own recordings (OwnChange); empty: unknown
  /// Returns true if both intervals exclude 0. The model moves the change of a person who did not change towards the
  /// mean change of the others.
  bool changed(std::size_t parameter) const {
    return !own.empty() && excludes_zero(difference[parameter]) && excludes_zero(own[parameter]);
  }
};

/// Two visits of a person by the recordings of this person only.
struct OwnChange {
  std::string participant, first, second;  ///< the cells by their names
  std::vector<Quantity> difference;        ///< per parameter, first less second
  bool has_caution = false;                ///< of one of the recordings: the intervals may be too narrow
};

struct Result {
  std::vector<Cell> cells;  ///< by group, session, condition, each in NameOrder
  std::vector<Comparison> comparisons;
  std::vector<Interaction> interactions;
  std::vector<VarianceParts> variances;  ///< per parameter
  std::vector<Covariate> covariates;     ///< as in the settings
  std::vector<Visit> visits;             ///< by participant, then cell
  std::vector<Change> changes;
  double max_rhat = 1.0;  ///< of every Quantity here
  int draws = 0;
};

/// Analyses a study. ranges: low end and width of every parameter's range, in which fractions are. Throws Error for no
/// recordings, for measurements or covariates of another number, a covariate without two values, and settings below 1
/// chain or 8 draws.
Result analyse(std::span<const Recording> recordings, std::span<const sim::ParameterInfo> ranges,
               const Settings& settings);

}  // namespace decid::cohort
