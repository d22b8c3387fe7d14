// Groups of people compared: see groups.hpp.
#include "identify/groups.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/error.hpp"
#include "base/math/statistics.hpp"
#include "base/name_order.hpp"
#include "base/text.hpp"
#include "identify/network/student_t.hpp"

namespace decid {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

double squared(double value) {
  return value * value;
}

/// Computes difference +- t standard_error, for this interval on its own and for `intervals` together.
void add_intervals(GroupEffect& effect, double standard_error, double degrees_of_freedom, std::size_t intervals) {
  const auto limits = [&](double probability) {
    const double half_width = student_t_critical(probability, degrees_of_freedom) * standard_error;
    return std::array{effect.difference - half_width, effect.difference + half_width};
  };
  effect.interval95 = limits(0.05);
  effect.adjusted_interval95 = limits(0.05 / static_cast<double>(std::max<std::size_t>(intervals, 1)));
}

GroupEffect effect_without_spread(double difference) {
  return {difference, {unknown, unknown}, {unknown, unknown}, unknown};
}

/// The recordings of a person in a group; `values` is their sum, then their mean.
struct Participant {
  std::size_t recordings = 0;
  std::vector<double> values;
};
using Participants = std::map<std::string, Participant>;
using Groups = std::map<std::string, Participants, NameOrder>;

Groups participants_of(std::span<const GroupedRecording> recordings, std::size_t parameters) {
  Groups by_name;
  for (const GroupedRecording& recording : recordings) {
    Participants& participants =
        by_name[recording.group];  // a group is listed even if all of its recordings are left out
    if (recording.values.empty()) continue;
    if (recording.values.size() != parameters)
      throw Error(Code::size_mismatch, "compare_groups", format("a recording has %zu values", recording.values.size()),
                  format("give %zu, one per parameter", parameters));
    Participant& participant = participants[recording.participant];
    participant.values.resize(parameters);
    for (std::size_t p = 0; p < parameters; ++p) participant.values[p] += recording.values[p];
    ++participant.recordings;
  }
  for (auto& [name, participants] : by_name)
    for (auto& [id, participant] : participants)
      for (double& value : participant.values) value /= static_cast<double>(participant.recordings);
  return by_name;
}

std::vector<double> values_of(const Participants& participants, std::size_t parameter) {
  std::vector<double> values;
  for (const auto& [id, participant] : participants) values.push_back(participant.values[parameter]);
  return values;
}

Group summary_of(const std::string& name, const Participants& participants, std::size_t parameters) {
  Group group{name, participants.size(), 0, {}};
  for (const auto& [id, participant] : participants) group.recordings += participant.recordings;
  for (std::size_t p = 0; p < parameters; ++p) group.parameters.push_back(group_sample(values_of(participants, p)));
  return group;
}

/// Returns the members of `people` who are also in `others`.
Participants also_in(const Participants& others, const Participants& participants) {
  Participants both;
  for (const auto& [id, participant] : participants)
    if (others.contains(id)) both.emplace(id, participant);
  return both;
}

GroupPair compare_pair(const Participants& first, const Participants& second, std::size_t parameters,
                       std::size_t intervals) {
  const Participants first_of_both = also_in(second, first), second_of_both = also_in(first, second);
  const std::size_t both = first_of_both.size();
  GroupPair pair;
  pair.paired = both > 0;
  pair.participants = {first.size(), second.size()};
  if (pair.paired) {
    pair.participants = {both, both};
    pair.unpaired_participants = first.size() + second.size() - 2 * both;
  }
  for (std::size_t p = 0; p < parameters; ++p)
    pair.parameters.push_back(
        pair.paired
            ? paired_effect(values_of(first_of_both, p), values_of(second_of_both, p), intervals)
            : independent_effect(group_sample(values_of(first, p)), group_sample(values_of(second, p)), intervals));
  return pair;
}

}  // namespace

GroupSample group_sample(std::span<const double> values) {
  const auto count = static_cast<double>(values.size());
  double sum = 0.0, squares = 0.0;
  for (const double value : values) sum += value;
  const double mean = values.empty() ? unknown : sum / count;
  // The mean of equal values may differ from them by rounding.
  const bool varies = std::ranges::any_of(values, [&](double value) { return value != values.front(); });
  for (const double value : values)
    if (varies) squares += squared(value - mean);
  return {values.size(), mean, values.size() > 1 ? std::sqrt(squares / (count - 1.0)) : unknown};
}

GroupEffect independent_effect(const GroupSample& first, const GroupSample& second, std::size_t intervals) {
  GroupEffect effect = effect_without_spread(first.mean - second.mean);
  if (first.count < 2 || second.count < 2) return effect;
  const auto n1 = static_cast<double>(first.count), n2 = static_cast<double>(second.count);
  const double variance1 = squared(first.sd) / n1, variance2 = squared(second.sd) / n2;  // of the means
  const double variance = variance1 + variance2;
  if (variance == 0.0) return effect;
  const double degrees_of_freedom =
      squared(variance) / (squared(variance1) / (n1 - 1.0) + squared(variance2) / (n2 - 1.0));
  add_intervals(effect, std::sqrt(variance), degrees_of_freedom, intervals);
  const double all = n1 + n2 - 2.0;
  const double pooled = std::sqrt(((n1 - 1.0) * squared(first.sd) + (n2 - 1.0) * squared(second.sd)) / all);
  effect.hedges_g = hedges_g(effect.difference, pooled, all);
  return effect;
}

GroupEffect paired_effect(std::span<const double> first, std::span<const double> second, std::size_t intervals) {
  if (first.size() != second.size())
    throw Error(Code::size_mismatch, "paired_effect",
                format("%zu values are paired with %zu", first.size(), second.size()),
                "give two values of each person");
  std::vector<double> differences;
  for (std::size_t i = 0; i < first.size(); ++i) differences.push_back(first[i] - second[i]);
  const GroupSample sample = group_sample(differences), one = group_sample(first), other = group_sample(second);
  GroupEffect effect = effect_without_spread(sample.mean);
  if (sample.count < 2) return effect;
  const auto n = static_cast<double>(sample.count);
  const auto size_of = [](const GroupSample& group) { return std::abs(group.mean) + group.sd; };
  // Below that, equal differences differ by rounding.
  if (sample.sd > 1e-12 * (size_of(one) + size_of(other)))
    add_intervals(effect, sample.sd / std::sqrt(n), n - 1.0, intervals);
  effect.hedges_g = hedges_g(sample.mean, std::sqrt(0.5 * (squared(one.sd) + squared(other.sd))), n - 1.0);
  return effect;
}

GroupComparison compare_groups(std::span<const GroupedRecording> recordings, std::size_t parameters,
                               const OrderOfPair& order_of) {
  const Groups by_name = participants_of(recordings, parameters);
  const auto is_large = [](const auto& group) { return group->second.size() > 1; };
  std::vector<std::pair<Groups::const_iterator, Groups::const_iterator>> pairs;
  for (auto first = by_name.begin(); first != by_name.end(); ++first)
    for (auto second = std::next(first); second != by_name.end(); ++second) {
      const PairOrder order = order_of ? order_of(first->first, second->first) : PairOrder::first_minus_second;
      if (order == PairOrder::first_minus_second) pairs.emplace_back(first, second);
      if (order == PairOrder::second_minus_first) pairs.emplace_back(second, first);
    }
  const auto is_small = [&](const auto& pair) { return !is_large(pair.first) || !is_large(pair.second); };
  const bool leaves_out = !std::ranges::all_of(pairs, is_small);
  if (leaves_out) std::erase_if(pairs, is_small);
  GroupComparison comparison;
  comparison.intervals = parameters * pairs.size();
  const auto place_of = [&](const auto& group) {
    return static_cast<std::size_t>(std::distance(by_name.begin(), group));
  };
  for (auto group = by_name.begin(); group != by_name.end(); ++group) {
    comparison.groups.push_back(summary_of(group->first, group->second, parameters));
    if (leaves_out && !is_large(group)) comparison.too_small.push_back(place_of(group));
  }
  for (const auto& [first, second] : pairs) {
    GroupPair& pair =
        comparison.pairs.emplace_back(compare_pair(first->second, second->second, parameters, comparison.intervals));
    pair.first = place_of(first);
    pair.second = place_of(second);
  }
  return comparison;
}

}  // namespace decid
