// The structure of a study: recordings in visits (a person in a cell), visits in participants, cells of groups.
#pragma once

#include <string>
#include <vector>

#include "base/name_order.hpp"
#include "identify/cohort/cohort.hpp"

namespace decid::cohort {

struct Design {
  struct CellName {
    std::string group, session, condition;
    bool operator==(const CellName&) const = default;
    /// Orders by group, session, condition, each as NameOrder does.
    bool operator<(const CellName& other) const {
      const NameOrder less;
      if (group != other.group) return less(group, other.group);
      return session != other.session ? less(session, other.session) : less(condition, other.condition);
    }
  };
  struct Visit {
    std::size_t participant, cell;
    std::vector<std::size_t> recordings;
    std::vector<double> covariates;  ///< means of its recordings', about the study's mean, in standard deviations
  };
  struct Participant {
    std::string name;
    std::size_t group;  ///< of the first visit
    std::vector<std::size_t> visits;
  };

  std::vector<CellName> cells;
  std::vector<std::size_t> group_of_cell;  ///< whose participants have a standard deviation of their own
  std::size_t groups = 0, parameters = 0;
  std::vector<Visit> visits;
  std::vector<Participant> participants;
  std::vector<double> covariate_mean, covariate_sd;
  bool has_visit_level = false, has_trial_level = false;
  double recordings_per_visit = 1.0, visits_per_participant = 1.0;  ///< means
};

/// Returns the structure. Throws Error as analyse() does.
Design make_design(std::span<const Recording> recordings, std::size_t parameters, const Settings& settings);

}  // namespace decid::cohort
