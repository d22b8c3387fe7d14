// Recordings of a report as recordings of a cohort: see of_result.hpp.
#include "identify/cohort/of_result.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/error.hpp"
#include "base/math/statistics.hpp"
#include "identify/cohort/detail/to_measurement.hpp"
#include "posterior/planning/bounded_normal.hpp"

namespace decid::cohort {
namespace {

/// Returns the logarithms of uniform over normal prior density at the draws; empty if all priors are uniform.
std::vector<double> log_weights(const posterior::Priors& priors, const sim::ParameterTable& ranges,
                                std::span<const posterior::State> states) {
  std::vector<double> weights;
  for (const posterior::ParameterPrior& prior : priors.parameters) {
    if (!prior.normal) continue;
    const auto named = std::ranges::find(ranges, prior.name, &sim::ParameterInfo::name);
    if (named == ranges.end()) continue;
    const auto p = static_cast<std::size_t>(std::distance(ranges.begin(), named));
    weights.resize(states.size(), 0.0);
    for (std::size_t i = 0; i < states.size(); ++i) {
      const double off = (states[i].parameters[p] - prior.normal->mean) / prior.normal->sd;
      weights[i] += 0.5 * off * off;
    }
  }
  return weights;
}

/// Returns the lowest number of effective draws of these parameters; empty if none is known.
std::optional<double> min_effective_draws(std::span<const double> effective, std::span<const std::size_t> inferred) {
  std::optional<double> lowest;
  for (const std::size_t p : inferred)
    if (p < effective.size() && std::isfinite(effective[p]) && effective[p] > 0.0)
      lowest = std::min(lowest.value_or(effective[p]), effective[p]);
  return lowest;
}

bool same_ranges(const ParameterDistribution& distribution, const sim::ParameterTable& ranges) {
  if (distribution.parameters() != ranges.size()) return false;
  for (std::size_t p = 0; p < ranges.size(); ++p) {
    const double tolerance = 1e-9 * ranges[p].range();
    if (!(std::abs(distribution.low(p) - ranges[p].low) <= tolerance &&
          std::abs(distribution.range(p) - ranges[p].range()) <= tolerance))
      return false;
  }
  return true;
}

/// Returns true if fractions of both ranges mean the same: what scales with m g h may have this ratio. Fixed parameters
/// have no fractions, so the ranges of the inferred ones count.
bool alike(const sim::ParameterTable& ranges, const sim::ParameterTable& other, std::span<const std::size_t> inferred,
           double mgh_ratio) {
  if (!std::ranges::equal(ranges, other, {}, &sim::ParameterInfo::name, &sim::ParameterInfo::name)) return false;
  return std::ranges::all_of(inferred, [&](std::size_t p) {
    const sim::ParameterInfo &a = ranges[p], &b = other[p];
    const double ratio = a.scales_with_mgh ? mgh_ratio : 1.0, tolerance = 1e-9 * b.range();
    return std::abs(ratio * a.low - b.low) <= tolerance && std::abs(ratio * a.high - b.high) <= tolerance;
  });
}

std::string cell_of(const Recording& one) {
  return cell_name(one.group, one.session, one.condition);
}

bool has_two_values(std::span<const Recording> recordings, std::size_t covariate) {
  std::set<double> values;
  for (const Recording& one : recordings)
    if (!std::isnan(one.covariates.at(covariate))) values.insert(one.covariates[covariate]);
  return values.size() > 1;
}

/// The values of a person in a cell; sums, then means.
struct Mean {
  double recordings = 0.0;
  std::vector<double> values, variances, shown;
};

/// Returns the standard deviation of a parameter's prior, which is a normal within the range or uniform.
double prior_sd(const Report& report, const RecordingResult& result, std::size_t p) {
  const sim::ParameterInfo info = report.ranges_for(result)[p];
  if (result.fit && result.fit->answer == FitFigures::Answer::posterior) {
    const posterior::Priors priors = report.priors_for(result);
    for (const posterior::ParameterPrior& prior : priors.parameters)
      if (prior.name == info.name && prior.normal) {
        const double sds = info.range() / prior.normal->sd;
        const posterior::FractionPrior of_fraction{(prior.normal->mean - info.low) / info.range(), sds * sds};
        return info.range() * std::sqrt(posterior::prior_variances(std::span(&of_fraction, 1)).front());
      }
  }
  return info.range() / std::sqrt(12.0);
}

/// The evidence of a recording, or why it has none: see WithoutEvidence.
struct Finding {
  std::optional<Measurement> measurement = {};
  const char* reason = "";
};

Finding evidence_of_draws(const RecordingResult& result, const Report& report, const sim::ParameterTable& ranges,
                          std::span<const std::size_t> inferred) {
  const std::span<const posterior::State> states = result.fit->posterior.states();
  if (states.size() < 16) return {.reason = "few_draws"};
  std::vector<double> fractions;
  for (const posterior::State& state : states) {
    const std::vector<double> all = ranges.to_unit(state.parameters);
    for (const std::size_t p : inferred) fractions.push_back(all[p]);
  }
  const std::vector<double> weights = log_weights(report.priors_for(result), ranges, states);
  const std::optional<double> effective = min_effective_draws(result.fit->posterior.effective_draws(), inferred);
  const auto measure = [&](std::span<const double> weighted) -> std::optional<Measurement> {
    try {
      return Measurement::of_draws(inferred.size(), fractions, weighted, effective);
    } catch (const Error&) {  // its draws are all on a plane, or its prior left too few of them
      return std::nullopt;
    }
  };
  if (std::optional<Measurement> found = measure(weights)) return {.measurement = std::move(found)};
  return {.reason = !weights.empty() && measure({}) ? "narrow_prior" : "flat_draws"};
}

/// Returns true if a result has a distribution of the inferred parameters. A network answers for all parameters: its
/// distribution is not the one given the fixed parameters.
bool has_distribution(const Report& report, const RecordingResult& result) {
  if (result.fit && result.fit->answer == FitFigures::Answer::posterior) return true;
  return result.estimate.distribution && report.inferred_parameters().size() == report.protocol.parameters().size();
}

Finding find_evidence(const RecordingResult& result, const Report& report) {
  const sim::ParameterTable ranges = report.ranges_for(result);
  const std::vector<std::size_t> inferred = report.inferred_parameters();
  const double mgh_ratio = report.protocol_for(result).experiment.body.mgh() / report.protocol.experiment.body.mgh();
  if (!alike(report.ranges(), ranges, inferred, mgh_ratio)) return {.reason = "other_ranges"};
  if (result.fit && result.fit->answer == FitFigures::Answer::posterior)
    return evidence_of_draws(result, report, ranges, inferred);
  if (!has_distribution(report, result)) return {.reason = "no_distribution"};
  const ParameterDistribution& distribution = *result.estimate.distribution;
  if (!same_ranges(distribution, ranges)) return {.reason = "other_ranges"};
  return {.measurement = Measurement::of_distribution(distribution)};
}

/// Evenly spaced quantiles of a sum of independent quantities.
class Sum {
 public:
  /// Adds scale times a parameter of a distribution.
  template <class Distribution>
  void add(const Distribution& distribution, std::size_t parameter, double scale) {
    std::vector<double> sums;
    for (int i = 0; i < levels; ++i) {
      const double added = scale * distribution.quantile(static_cast<int>(parameter), (i + 0.5) / levels);
      for (const double before : quantiles_) sums.push_back(before + added);
    }
    std::ranges::sort(sums);
    quantiles_.clear();
    for (std::size_t i = 0; i < levels; ++i) quantiles_.push_back(sums[(2 * i + 1) * sums.size() / (2 * levels)]);
    const double sd = scale * distribution.stddev(static_cast<int>(parameter));
    variance_ += sd * sd;
  }
  /// mean: the sum's.
  Quantity quantity(double mean) const { return {mean, std::sqrt(variance_), {quantiles_[2], quantiles_[97]}}; }

 private:
  static constexpr int levels = 100;  // at 0.005, 0.015, ..: the third and the last but two are the ends of 95%
  std::vector<double> quantiles_{0.0};
  double variance_ = 0.0;
};

}  // namespace

bool FirstOfJoint::operator()(const RecordingResult& result) {
  return !result.fit || !result.fit->joint || result.fit->answer != FitFigures::Answer::posterior ||
         seen_.insert(result.fit->joint->files).second;
}

std::optional<Measurement> to_measurement(const RecordingResult& result, const Report& report) {
  return find_evidence(result, report).measurement;
}

Analysis analyse_groups(const Report& report, std::span<const Recording> members,
                        const std::vector<std::string>& covariates, std::optional<double> mgh_nm_rad) {
  Analysis found;
  std::vector<Recording> recordings;
  std::map<std::string, std::set<std::string>> participants;  // of cells
  FirstOfJoint is_first;
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (members[i].group.empty() || !is_first(report.recordings[i])) continue;
    Finding finding = find_evidence(report.recordings[i], report);
    if (!finding.measurement) {
      found.without_evidence.push_back({i, finding.reason});
      continue;
    }
    Recording& one = recordings.emplace_back(members[i]);
    one.measurement = std::move(*finding.measurement);
    participants[cell_of(one)].insert(one.participant);
  }
  if (std::ranges::count_if(participants, [](const auto& cell) { return cell.second.size() > 1; }) <
      (covariates.empty() ? 2 : 1))
    return found;
  std::erase_if(recordings, [&](const Recording& one) { return participants[cell_of(one)].size() < 2; });
  for (std::size_t k = 0; k < covariates.size(); ++k)
    if (!has_two_values(recordings, k)) return found;
  const sim::ParameterTable table = report.ranges();
  std::vector<sim::ParameterInfo> ranges;
  for (const std::size_t p : report.inferred_parameters()) ranges.push_back(table[p]);
  const double mgh = report.protocol.experiment.body.mgh(), ratio = mgh_nm_rad.value_or(mgh) / mgh;
  for (sim::ParameterInfo& range : ranges) {
    if (!range.scales_with_mgh) continue;
    range.low *= ratio;
    range.high *= ratio;
  }
  Settings settings;
  settings.covariates = covariates;
  found.result = analyse(recordings, ranges, settings);
  return found;
}

std::vector<std::optional<Reliability>> compute_reliability(const Report& report, std::span<const Recording> members,
                                                            const std::string& first, const std::string& second,
                                                            std::optional<double> mgh_nm_rad) {
  const std::size_t parameters = report.protocol.parameters().size();
  std::map<std::string, std::array<Mean, 2>> participants;
  FirstOfJoint is_first;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const std::string cell = members[i].group.empty() ? std::string() : cell_of(members[i]);
    if (cell != first && cell != second) continue;
    const RecordingResult& result = report.recordings[i];
    if (!is_first(result)) continue;
    Mean& mean = participants[members[i].participant][cell == first ? 0 : 1];
    mean.recordings += 1.0;
    mean.values.resize(parameters);
    mean.variances.resize(parameters);
    mean.shown.resize(parameters);
    const double own = report.protocol_for(result).experiment.body.mgh();
    for (std::size_t p = 0; p < parameters; ++p) {
      const double scale = scale_to(mgh_nm_rad.value_or(own), report, result, p);
      mean.values[p] += scale * result.estimate.parameters[p];
      double shown = 1.0;
      use_distribution(result, [&](const auto& distribution) {
        const double sd = distribution.stddev(static_cast<int>(p)), relative = sd / prior_sd(report, result, p);
        shown = std::max(0.0, 1.0 - relative * relative);
        mean.variances[p] += scale * scale * sd * sd * shown;
      });
      mean.shown[p] += shown;
    }
  }
  std::vector<std::optional<Reliability>> found;
  for (const std::size_t p : report.inferred_parameters()) {
    std::vector<double> values, variances, shown;
    for (const auto& [name, visits] : participants) {
      if (visits[0].recordings < 1.0 || visits[1].recordings < 1.0) continue;
      for (const Mean& visit : visits) {
        values.push_back(visit.values[p] / visit.recordings);
        variances.push_back(visit.variances[p] / (visit.recordings * visit.recordings));
        shown.push_back(visit.shown[p] / visit.recordings);
      }
    }
    try {
      found.emplace_back(reliability(2, values, variances));
      found.back()->shown_fraction = mean(shown);
    } catch (const Error&) {  // one person, or no variance
      found.emplace_back(std::nullopt);
    }
  }
  return found;
}

std::vector<OwnChange> compute_own_changes(const Report& report, std::span<const Recording> members,
                                           const std::string& first, const std::string& second, double mgh_nm_rad) {
  struct Person {
    std::array<std::vector<const RecordingResult*>, 2> visits;
    bool has_caution = false;
  };
  std::map<std::string, Person> participants;
  FirstOfJoint is_first;
  for (std::size_t i = 0; i < members.size(); ++i) {
    const std::string cell = members[i].group.empty() ? std::string() : cell_of(members[i]);
    if ((cell != first && cell != second) || !has_distribution(report, report.recordings[i])) continue;
    Person& person = participants[members[i].participant];
    person.has_caution |= report.recordings[i].trust() != Trust::usable;
    if (is_first(report.recordings[i])) person.visits[cell == first ? 0 : 1].push_back(&report.recordings[i]);
  }
  std::vector<OwnChange> found;
  for (const auto& [name, person] : participants) {
    const auto& visits = person.visits;
    if (visits[0].empty() || visits[1].empty()) continue;
    OwnChange& change = found.emplace_back(OwnChange{name, first, second, {}, person.has_caution});
    for (const std::size_t p : report.inferred_parameters()) {
      Sum sum;
      double mean = 0.0;
      for (const auto& visit : visits)
        for (const RecordingResult* result : visit) {
          const double weight = (&visit == &visits[0] ? 1.0 : -1.0) / static_cast<double>(visit.size()),
                       scale = weight * scale_to(mgh_nm_rad, report, *result, p);
          mean += scale * result->estimate.parameters[p];
          use_distribution(*result, [&](const auto& distribution) { sum.add(distribution, p, scale); });
        }
      change.difference.push_back(sum.quantity(mean));
    }
  }
  return found;
}

void add_own_changes(const std::vector<OwnChange>& own, Result& result) {
  for (Change& change : result.changes) {
    const Visit &first = result.visits[change.first], &second = result.visits[change.second];
    const auto found = std::ranges::find_if(own, [&](const OwnChange& one) {
      return one.participant == first.participant && one.first == result.cells[first.cell].name() &&
             one.second == result.cells[second.cell].name();
    });
    if (found != own.end()) change.own = found->difference;
  }
}

}  // namespace decid::cohort
