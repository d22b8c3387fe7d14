// Compares groups of people by the parameters of their recordings. Recordings of one person are averaged first, because
// they resemble each other more than recordings of two people: the person, not the recording, is the unit (J. Matthews,
// D. Altman, M. Campbell, P. Royston, BMJ 300 (1990) 230-235). Per parameter, of the people's means:
//   difference of two groups of different people: B. Welch, Biometrika 34 (1947) 28-35
//     SE^2 = S1^2 / n1 + S2^2 / n2     df = SE^4 / (S1^4 / (n1^2 (n1 - 1)) + S2^4 / (n2^2 (n2 - 1)))
//   difference of two groups of the same n people, from each person's own difference D (paired)
//     SE^2 = SD^2 / n                  df = n - 1
//   interval: difference +- t SE, t of Student's distribution with df
//   adjusted interval: the same with 0.05 / k instead of 0.05 for k intervals; their joint coverage is at least 95%
//     (Bonferroni; O. Dunn, J. Am. Stat. Assoc. 56 (1961) 52-64), however the parameters depend on each other
//   Hedges' g = J difference / S, with J of base/math/statistics.hpp for f >= 2
//     different people: S^2 = ((n1 - 1) S1^2 + (n2 - 1) S2^2) / f, f = n1 + n2 - 2 (M. Borenstein, L. Hedges,
//     J. Higgins, H. Rothstein, Introduction to Meta-Analysis, 2009, chapter 4)
//     paired: S^2 = (S1^2 + S2^2) / 2, f = n - 1 (d_av of G. Cumming, Understanding The New Statistics, 2012,
//     chapter 11)
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/cohort/cohort.hpp"
#include "identify/cohort/reliability.hpp"

namespace decid {

/// Summarises a group's values, one per person.
struct GroupSample {
  std::size_t count = 0;
  double mean = 0.0;  ///< NaN of none
  double sd = 0.0;    ///< with n - 1; NaN of fewer than two
};
/// Returns the summary of the values of a group, which may have none.
GroupSample group_sample(std::span<const double> values);

/// The effect of a difference. NaN: undefined, because a group has fewer than two people, or nothing varies; hedges_g
/// of two paired people too, where J would be 0.
struct GroupEffect {
  double difference = 0.0;                                    ///< of the means, first less second
  std::array<double, 2> interval95{}, adjusted_interval95{};  ///< of the difference
  double hedges_g = 0.0;
};
/// Compares two groups of different people. intervals: how many intervals the comparison prints in all.
GroupEffect independent_effect(const GroupSample& first, const GroupSample& second, std::size_t intervals);
/// Compares two values of each person. Throws Error for lists of different lengths.
GroupEffect paired_effect(std::span<const double> first, std::span<const double> second, std::size_t intervals);

/// Which group and person a recording belongs to.
struct GroupMember {
  std::string group;                         ///< empty: the recording is not compared
  std::string participant;                   ///< the recording itself where the table has no column of people
  std::string session = {}, condition = {};  ///< compared too, unless empty
  std::vector<double> covariates = {};       ///< one per name in GroupTable; NaN: unknown
  std::string sheet_session = {}, sheet_condition = {};  ///< as the sheet has them, compared or not
  std::string missing = {};  ///< "group", "session" or "condition": the column in which a recording without `group` has
                             ///< no value; empty: it is in no comparison for another reason

  /// Returns what the recording is compared as: cohort::cell_name(), empty for none.
  std::string cell() const { return group.empty() ? std::string() : cohort::cell_name(group, session, condition); }
};
/// A line of the table that names none of the recordings.
struct UnusedLine {
  std::size_t line;  ///< of the file, from 1
  std::string file;  ///< what it names
  bool operator==(const UnusedLine&) const = default;
};
struct GroupTable {
  std::string participant_column;    ///< as the file spells it; empty if there is none
  std::vector<GroupMember> members;  ///< one per recording
  std::vector<UnusedLine> unused = {};
  bool has_groups = true;                       ///< false: all recordings are in cohort::everyone
  std::vector<std::string> covariates = {};     ///< names
  std::vector<std::string> other_columns = {};  ///< if no column names the person: columns without a meaning to decid
};

/// The part of a recording that a comparison reads.
struct GroupedRecording {
  std::string group, participant;
  std::vector<double> values;  ///< one per parameter; empty: the recording is left out
};

struct Group {
  std::string name;
  std::size_t participants = 0, recordings = 0;  ///< without those that are left out
  std::vector<GroupSample> parameters;           ///< of the people's means
};

struct GroupPair {
  std::size_t first = 0, second = 0;  ///< places in the list of groups
  bool paired = false;                ///< someone is in both groups, so only people in both are compared, however few
  std::array<std::size_t, 2> participants{};
  std::size_t unpaired_participants = 0;  ///< people in one group only, whom a paired comparison leaves out
  std::vector<GroupEffect> parameters;
};

struct GroupComparison {
  std::vector<Group> groups;                ///< in the order of their names (NameOrder)
  std::vector<GroupPair> pairs;             ///< all that are compared
  std::size_t intervals = 0;                ///< parameters times pairs: what the adjusted intervals are adjusted for
  std::vector<std::size_t> too_small = {};  ///< places of groups of fewer than two people, which no pair has
};
/// Says whether two groups, in the order of their names, are compared, and which of them is a GroupPair's first.
enum class PairOrder { not_compared, first_minus_second, second_minus_first };
/// Compares every pair of groups, first minus second, or as `order_of` says by their names. Leaves out groups of fewer
/// than two people, whose differences have no interval, if a pair of larger groups remains. Throws Error for a
/// recording with another number of values than `parameters`.
using OrderOfPair = std::function<PairOrder(const std::string& first, const std::string& second)>;
GroupComparison compare_groups(std::span<const GroupedRecording> recordings, std::size_t parameters,
                               const OrderOfPair& order_of = {});

/// A table of groups and the comparison of the recordings of one call. All lists of parameters have those that are
/// compared: Report::inferred_parameters().
struct GroupReport {
  GroupTable table;
  std::vector<std::string> left_out;  ///< one per recording: why it is not compared, "error", "not usable",
                                      ///< "tilt_of_other_size", "without_group", "without_session" or
                                      ///< "without_condition"; empty: it is, or the table has no line of it
  GroupComparison comparison;
  /// The hierarchical model of the recordings' distributions; empty where cohort::analyse_groups() returns none.
  std::optional<cohort::Result> hierarchical = {};
  /// Recordings that are compared, but without a distribution that the hierarchical model can use.
  std::vector<cohort::WithoutEvidence> without_distribution = {};
  /// The m g h, N m/rad, of the body that stiffness and damping of the comparison, the hierarchical model and the
  /// reliability are for: that of all compared recordings, or, where these differ, that of the posture model's own body
  /// (sim::Body), to which each person's values are scaled by m g h.
  double mgh_nm_rad = 0.0;
  bool bodies_differ = false;
  std::size_t assumed_bodies = 0;  ///< recordings that are compared with an assumed body
  /// Reliability per pair of comparison.pairs and parameter, of the participants in both groups; empty lists for groups
  /// of different people, and of one person in both.
  std::vector<std::vector<std::optional<cohort::Reliability>>> reliability = {};
  /// Changes of people in both groups of a pair, by each person's own recordings.
  std::vector<cohort::OwnChange> own_changes = {};
};

}  // namespace decid
