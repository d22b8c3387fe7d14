// The structure of a study: see design.hpp.
#include "identify/cohort/detail/design.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/error.hpp"
#include "base/text.hpp"

namespace decid::cohort {
namespace {

void check(std::span<const Recording> recordings, std::size_t parameters, const Settings& settings) {
  if (recordings.empty()) throw Error(Code::trials_missing, "cohort", "there are no recordings", "give at least one");
  if (settings.chains < 1 || settings.draws < 8 || settings.warm_up < 0)
    throw Error(Code::setting_out_of_range, "cohort", format("%d chains of %d draws", settings.chains, settings.draws),
                "give 1 chain and 8 draws or more");
  for (const Recording& one : recordings) {
    if (one.measurement.parameters() != parameters)
      throw Error(Code::size_mismatch, "cohort",
                  format("a recording of %s has %zu parameters", one.participant.c_str(), one.measurement.parameters()),
                  format("give %zu", parameters));
    if (one.covariates.size() != settings.covariates.size())
      throw Error(Code::size_mismatch, "cohort",
                  format("a recording of %s has %zu covariates", one.participant.c_str(), one.covariates.size()),
                  format("give %zu; NaN where one is unknown", settings.covariates.size()));
  }
}

/// Mean and standard deviation of the known values.
struct Scale {
  double mean, sd;
};
Scale scale_of(std::span<const Recording> recordings, std::size_t covariate, const std::string& name) {
  double sum = 0.0, squares = 0.0, count = 0.0;
  for (const Recording& one : recordings) {
    const double value = one.covariates[covariate];
    if (std::isnan(value)) continue;
    sum += value;
    count += 1.0;
  }
  const double mean = sum / count;
  for (const Recording& one : recordings)
    if (const double off = one.covariates[covariate] - mean; !std::isnan(off)) squares += off * off;
  const double sd = std::sqrt(squares / std::max(count - 1.0, 1.0));
  if (!(sd > 0.0) || !std::isfinite(sd))
    throw Error(Code::value_invalid, "cohort", "the covariate " + name + " has fewer than two different values",
                "leave it out");
  return {mean, sd};
}

/// The means of the known covariates of each person and of each group.
class KnownCovariates {
 public:
  struct Mean {
    double sum = 0.0, count = 0.0;
    void add(double value) {
      if (std::isnan(value)) return;
      sum += value;
      count += 1.0;
    }
    double value_or(double other) const { return count > 0.0 ? sum / count : other; }
  };

  KnownCovariates(std::span<const Recording> recordings, std::size_t covariates) {
    for (const Recording& one : recordings)
      for (std::size_t k = 0; k < covariates; ++k)
        for (std::vector<Mean>* means : {&participants_.try_emplace(one.participant, covariates).first->second,
                                         &groups_.try_emplace(one.group, covariates).first->second})
          (*means)[k].add(one.covariates[k]);
  }
  const Mean& of_participant(const std::string& name, std::size_t k) const { return participants_.at(name)[k]; }
  const Mean& of_group(const std::string& name, std::size_t k) const { return groups_.at(name)[k]; }

 private:
  std::map<std::string, std::vector<Mean>> participants_{}, groups_{};
};

}  // namespace

Design make_design(std::span<const Recording> recordings, std::size_t parameters, const Settings& settings) {
  check(recordings, parameters, settings);
  Design design;
  design.parameters = parameters;
  std::set<Design::CellName> cells;
  std::set<std::string> group_names;
  std::map<std::string, std::map<std::size_t, std::vector<std::size_t>>> participants;
  for (const Recording& one : recordings) {
    cells.insert({one.group, one.session, one.condition});
    group_names.insert(one.group);
  }
  design.cells.assign(cells.begin(), cells.end());
  design.groups = group_names.size();
  for (const Design::CellName& cell : design.cells)
    design.group_of_cell.push_back(
        static_cast<std::size_t>(std::distance(group_names.begin(), group_names.find(cell.group))));
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    const Recording& one = recordings[i];
    const auto cell = cells.find({one.group, one.session, one.condition});
    participants[one.participant][static_cast<std::size_t>(std::distance(cells.begin(), cell))].push_back(i);
  }
  std::vector<Scale> scales;
  for (std::size_t k = 0; k < settings.covariates.size(); ++k) {
    scales.push_back(scale_of(recordings, k, settings.covariates[k]));
    design.covariate_mean.push_back(scales.back().mean);
    design.covariate_sd.push_back(scales.back().sd);
  }
  const KnownCovariates known(recordings, scales.size());
  bool shared = false;
  for (const auto& [name, visits] : participants) {
    design.participants.push_back({name, design.group_of_cell[visits.begin()->first], {}});
    for (const auto& [cell, members] : visits) {
      design.participants.back().visits.push_back(design.visits.size());
      Design::Visit visit{design.participants.size() - 1, cell, members, {}};
      for (std::size_t k = 0; k < scales.size(); ++k) {
        KnownCovariates::Mean own;
        for (const std::size_t i : members) own.add(recordings[i].covariates[k]);
        const double value = own.value_or(known.of_participant(name, k).value_or(
            known.of_group(recordings[members.front()].group, k).value_or(scales[k].mean)));
        visit.covariates.push_back((value - scales[k].mean) / scales[k].sd);
      }
      design.visits.push_back(std::move(visit));
      design.has_trial_level |= members.size() > 1;
    }
    design.has_visit_level |= visits.size() > 1;
    shared |= std::ranges::any_of(visits, [&](const auto& visit) {
      return design.group_of_cell[visit.first] != design.participants.back().group;
    });
  }
  if (shared) {  // a person of two groups has one standard deviation
    design.groups = 1;
    design.group_of_cell.assign(design.cells.size(), 0);
    for (Design::Participant& participant : design.participants) participant.group = 0;
  }
  const auto count = static_cast<double>(design.visits.size());
  design.recordings_per_visit = static_cast<double>(recordings.size()) / count;
  design.visits_per_participant = count / static_cast<double>(design.participants.size());
  return design;
}

}  // namespace decid::cohort
