// The uncertainty of recordings of a planned study: see planning.hpp.
#include "identify/cohort/planning.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "identify/detail/streams.hpp"
#include "identify/identify.hpp"
#include "posterior/planning/expected_posterior.hpp"
#include "sim/protocol/conditions.hpp"
#include "sim/streams.hpp"

namespace decid::cohort {
namespace {

constexpr double min_shown = 0.1;  // of a difference
constexpr std::size_t repetitions = 2, recordings_of_participant = 4;
constexpr double max_over_mgh = 2.0;  // no stiffness or damping in SI units is as small
constexpr double max_shrunk = 0.99;   // of the prior's variance

void check_groups(const sim::ParameterTable& table, const PlannedGroups& groups, int participants, double mgh_nm_rad) {
  if (participants < 2)
    throw Error(Code::setting_out_of_range, "power", format("%d participants are simulated", participants),
                "simulate eight recordings or more");
  check_means(table, groups, mgh_nm_rad);
}

/// The estimates of a person's recordings: two of the first group, two of the second.
using ParticipantValues = std::array<sim::Parameters, recordings_of_participant>;

std::vector<ParticipantValues> simulated_values(const Model& model, const sim::Protocol& protocol,
                                                const PlannedGroups& groups, int participants, std::uint64_t seed) {
  const sim::ParameterTable& table = model.parameters();
  const int count = participants * static_cast<int>(recordings_of_participant);
  std::vector<recording::Trial> read(static_cast<std::size_t>(count));
  const auto repetition_of = [](int index) {  // both groups have the same numbers
    const auto place = static_cast<std::uint64_t>(index);
    return place / recordings_of_participant * repetitions + place % repetitions;
  };
  sim::Simulator(protocol).run_until_valid(
      count, 1000,
      [&](int index, int attempt) {
        const auto place = static_cast<std::uint64_t>(index), tried = static_cast<std::uint64_t>(attempt);
        const Random random(seed, streams::cohort, place / recordings_of_participant * 1000 + tried);
        sim::Parameters participant = groups.at;
        for (std::size_t p = 0; p < table.size(); ++p) {
          const double shift = place % recordings_of_participant < repetitions ? 0.0 : groups.difference[p];
          participant[p] = std::clamp(groups.at[p] + shift + groups.participant_sd[p] * random.normal(p), table[p].low,
                                      table[p].high);
        }
        return sim::TrialInput{participant,
                               Random(seed, sim::streams::vestibular_noise, repetition_of(index) * 1000 + tried)};
      },
      [&](int index, const sim::TrialInput&, std::span<double> sway) {
        sim::record(protocol, seed, repetition_of(index), sway);
        read[static_cast<std::size_t>(index)] = recording::make_trial({sway.begin(), sway.end()});
      });
  std::vector<ParticipantValues> values(static_cast<std::size_t>(participants));
  std::size_t place = 0;
  for (const Estimate& estimate : Identifier(model).estimate(read)) {
    values[place / recordings_of_participant][place % recordings_of_participant] = estimate.parameters;
    ++place;
  }
  return values;
}

/// Sums over participants and groups of one parameter.
struct Sums {
  double shift = 0.0, within = 0.0, between = 0.0;  ///< mean shift; variances of recordings and of participants' means
};
Sums sums_of(const std::vector<ParticipantValues>& values, std::size_t p) {
  const auto count = static_cast<double>(values.size());
  Sums sums;
  for (const std::size_t first : {std::size_t{0}, repetitions}) {
    double mean = 0.0, squares = 0.0;
    for (const ParticipantValues& participant : values) {
      const double a = participant[first][p], b = participant[first + 1][p];
      mean += 0.5 * (a + b) / count;
      sums.within += 0.25 * (a - b) * (a - b) / count;  // half of each group
    }
    for (const ParticipantValues& participant : values) {
      const double off = 0.5 * (participant[first][p] + participant[first + 1][p]) - mean;
      squares += off * off / (count - 1.0);
    }
    sums.between += 0.5 * squares;
    sums.shift += first == 0 ? -mean : mean;
  }
  sums.between = std::max(0.0, sums.between - 0.5 * sums.within);
  return sums;
}

}  // namespace

// The limit is not the one of posterior::mgh_hint(), which explains refusals: differences of a few SI units are
// accepted without a note.
std::string hint_of_unit(const sim::ParameterInfo& info, double value, double mgh_nm_rad) {
  if (!info.scales_with_mgh || value == 0.0 || !(std::abs(value) <= max_over_mgh)) return {};
  return format(" (%s is in %s: %g m g h is %.4g, or give %s/mgh)", info.name.c_str(), info.shown_unit().c_str(), value,
                value * mgh_nm_rad, info.name.c_str());
}

void check_mean(const sim::ParameterInfo& info, double at, double difference, double mgh_nm_rad) {
  for (const double shift : {0.0, difference}) {
    const double mean = at + shift;
    if (mean > info.low && mean < info.high) continue;
    const std::string hint = shift == 0.0 && mgh_nm_rad > 0.0 ? hint_of_unit(info, mean, mgh_nm_rad) : std::string();
    throw Error(Code::setting_out_of_range, "power",
                std::string(shift == 0.0 ? "the mean of " : "the second group's mean of ") + info.name +
                    format(" is %g", mean) + info.unit_after(),
                format("give one above %g and below %g", info.low, info.high) + info.unit_after() +
                    (hint.empty() ? info.unit_hint() : hint));
  }
}

void check_means(const sim::ParameterTable& table, const PlannedGroups& groups, double mgh_nm_rad) {
  for (std::size_t p = 0; p < table.size(); ++p) check_mean(table[p], groups.at[p], groups.difference[p], mgh_nm_rad);
}

ValueSpread spread_of_network(const Model& model, const sim::Protocol& protocol, const PlannedGroups& groups,
                              int participants, std::uint64_t seed) {
  const sim::ParameterTable& table = model.parameters();
  check_groups(table, groups, participants, protocol.experiment.body.mgh());
  const std::vector<ParticipantValues> values = simulated_values(model, protocol, groups, participants, seed);
  ValueSpread spread{sim::Parameters(table.size()), sim::Parameters(table.size())};
  for (std::size_t p = 0; p < table.size(); ++p) {
    if (groups.difference[p] == 0.0) continue;
    const Sums sums = sums_of(values, p);
    const double shown = sums.shift / groups.difference[p];
    if (!(shown > min_shown))
      throw Error(Code::value_invalid, "power",
                  format("the network shows %.0f%% of the difference of %s", 100.0 * shown, table[p].name.c_str()),
                  "plan with fits, or give " + setting("measurement_sd"));
    spread.participant_sd[p] = std::sqrt(sums.between) / shown;
    spread.measurement_sd[p] = std::sqrt(sums.within) / shown;
  }
  return spread;
}

ValueSpread spread_of_fits(const sim::Protocol& protocol, const posterior::Priors& priors, const PlannedGroups& groups,
                           double sensor_noise_deg, int participants, std::uint64_t seed) {
  const posterior::Density density(protocol, priors);
  check_groups(density.ranges(), groups, participants, protocol.experiment.body.mgh());
  const posterior::ExpectedPosterior found =
      posterior::expected_posterior(density, {.draws = participants,
                                              .sensor_noise_deg = sensor_noise_deg,
                                              .at = groups.at,
                                              .participant_sd = groups.participant_sd,
                                              .seed = seed});
  ValueSpread spread{groups.participant_sd, sim::Parameters(found.sd.size())};
  for (std::size_t p = 0; p < found.sd.size(); ++p)
    spread.measurement_sd[p] = density.infers(static_cast<int>(p))
                                   ? found.sd[p] / std::sqrt(1.0 - std::min(found.relative_variance[p], max_shrunk))
                                   : std::numeric_limits<double>::quiet_NaN();
  return spread;
}

}  // namespace decid::cohort
