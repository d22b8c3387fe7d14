// decid power: how many participants and trials a difference between two groups or visits needs.
#include "identify/cohort/power.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "identify/cohort/planning.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/named_values.hpp"

namespace decid::tools {
namespace {

constexpr double default_noise_deg = 0.02;
constexpr int max_fits = 128;

struct PowerOptions {
  CommonOptions common;
  std::vector<std::string> differences, at, participant_sd, visit_sd, trial_sd, measurement_sd;
  cohort::PowerDesign design;
  int participants = 12, trials = 1, recordings = 2000, intervals = 1;
  double power = 0.8;
  std::vector<double> sensor_noise_deg;
  std::uint64_t seed = 1;
  std::string model, by = "network", protocol;
};

/// Returns the spread of the recordings' values: the network's, or decid fit's.
cohort::ValueSpread spread_of(const PowerOptions& options, const Model& model, const cohort::PlannedGroups& groups) {
  sim::Protocol protocol = model.protocol;
  if (options.by == "network") {
    if (!options.sensor_noise_deg.empty())
      protocol.noise.sensor = {options.sensor_noise_deg.front(), options.sensor_noise_deg.back()};
    return cohort::spread_of_network(model, protocol, groups, options.recordings / 4, options.seed);
  }
  if (!options.protocol.empty()) protocol = read_protocol(options.protocol, options.common.quiet);
  if (protocol.experiment.body_model != model.protocol.experiment.body_model)
    throw Error(Code::setting_conflict, "--protocol", "has another controller than the model",
                "give a protocol of the model's controller");
  const double noise_deg = options.sensor_noise_deg.empty()
                               ? default_noise_deg
                               : std::sqrt(options.sensor_noise_deg.front() * options.sensor_noise_deg.back());
  const posterior::Priors priors = posterior::with_conventions({}, protocol.ranges());
  return cohort::spread_of_fits(protocol, priors, groups, noise_deg, std::min(options.recordings, max_fits),
                                options.seed);
}

/// Throws Error for a difference or a standard deviation beyond a parameter's range, which no person has: milliseconds
/// for seconds, for example.
void refuse_beyond_range(const std::string& option, const std::vector<bool>& given, const sim::Parameters& values,
                         const sim::ParameterTable& table) {
  for (std::size_t p = 0; p < table.size(); ++p)
    if (given[p] && std::abs(values[p]) > table[p].range())
      throw Error(Code::setting_out_of_range, option,
                  table[p].name + format(" is %g", values[p]) + table[p].unit_after() +
                      format(", more than its whole range of %g", table[p].range()) + table[p].unit_after(),
                  "give less" + table[p].unit_hint());
}

/// Prints a note on a difference that may be over m g h. A small difference may also be meant.
void note_small_difference(const sim::ParameterInfo& info, double difference, double mgh_nm_rad) {
  if (const std::string hint = cohort::hint_of_unit(info, difference, mgh_nm_rad); !hint.empty())
    std::cerr << "note: --difference: " << info.name << format(" is %g", difference) << info.unit_after() << hint
              << '\n';
}

/// Throws Error for values of parameters that nothing is computed from. why: their use, for the message.
void refuse_unused(const std::string& option, const std::vector<bool>& given, const std::vector<bool>& used,
                   const sim::ParameterTable& table, const std::string& why) {
  for (std::size_t p = 0; p < table.size(); ++p)
    if (given[p] && !used[p])
      throw Error(Code::setting_conflict, option, table[p].name + " is not used: " + why, "leave it out");
}

/// Returns "Kp, N m/rad", the unit of all numbers of a line but power and persons; "Nv" for a plain number.
std::string name_and_unit(const sim::ParameterInfo& info) {
  return info.name + (info.shown_unit().empty() ? "" : ", " + info.shown_unit());
}

void run_power(const PowerOptions& options) {
  if (options.by == "network" && !options.protocol.empty())
    throw Error(Code::setting_conflict, "--protocol", "is for --by fit: a network reads its own protocol",
                "add --by fit, or leave it out");
  const Model model = model_or_built_in(options.model);
  const sim::ParameterTable& table = model.parameters();
  sim::Parameters at = table.middle(), difference(table.size()), participant(table.size()), visit(table.size()),
                  trial(table.size());
  std::vector<bool> percent_at, percent_difference;
  const std::vector<bool> has_mean = read_named_values("--at", options.at, table, table.middle(), at, &percent_at);
  const std::vector<bool> wanted =
      read_named_values("--difference", options.differences, table, at, difference, &percent_difference);
  for (std::size_t p = 0; p < table.size(); ++p) {
    participant[p] = table[p].range() / 8.0;
    visit[p] = table[p].range() / 24.0;
  }
  sim::Parameters measured(table.size());
  const std::vector<bool> known = read_named_values("--measurement-sd", options.measurement_sd, table, at, measured);
  const bool simulates =
      !std::ranges::equal(wanted, known, [](bool is_wanted, bool is_known) { return is_known || !is_wanted; });
  const double mgh_nm_rad = model.protocol.experiment.body.mgh();
  const auto check_means = [&](const sim::Parameters& differences) {
    for (std::size_t p = 0; p < table.size(); ++p)
      if (simulates || wanted[p])  // simulated people have all parameters
        cohort::check_mean(table[p], at[p], differences[p], percent_at[p] ? 0.0 : mgh_nm_rad);
  };
  check_means(sim::Parameters(table.size()));
  refuse_beyond_range("--difference", wanted, difference, table);
  check_means(difference);
  const auto read_sd = [&](const char* option, const std::vector<std::string>& texts, sim::Parameters& values) {
    std::vector<bool> given = read_named_values(option, texts, table, at, values);
    refuse_beyond_range(option, given, values, table);
    return given;
  };
  const std::vector<bool> has_sd = read_sd("--participant-sd", options.participant_sd, participant),
                          has_visit_sd = read_sd("--visit-sd", options.visit_sd, visit),
                          has_trial_sd = read_sd("--trial-sd", options.trial_sd, trial);
  refuse_beyond_range("--measurement-sd", known, measured, table);
  sim::Parameters of_values = participant;
  const std::string no_difference = "it has no --difference";
  for (const auto& [option, given] :
       {std::pair("--measurement-sd", &known), {"--trial-sd", &has_trial_sd}, {"--visit-sd", &has_visit_sd}})
    refuse_unused(option, *given, wanted, table, no_difference);
  if (!simulates) {
    refuse_unused("--participant-sd", has_sd, wanted, table, no_difference);
    refuse_unused("--at", has_mean, wanted, table, no_difference);
  }
  if (!options.design.paired && !options.visit_sd.empty())
    throw Error(Code::setting_conflict, "--visit-sd", "is for visits of the same participants", "add --paired");
  if (options.design.paired && !simulates && !options.participant_sd.empty())
    throw Error(Code::setting_conflict, "--participant-sd",
                "is not used: --paired compares the visits of each participant", "leave it out, or give --visit-sd");
  for (const auto& [option, is_given] :
       {std::pair("--sensor-noise", !options.sensor_noise_deg.empty()), {"--protocol", !options.protocol.empty()}})
    if (!simulates && is_given)
      throw Error(Code::setting_conflict, option,
                  "is not used: --measurement-sd gives the uncertainty of all recordings", "leave one of them out");
  for (std::size_t p = 0; p < table.size() && !options.common.quiet; ++p)
    if (wanted[p] && !percent_difference[p]) note_small_difference(table[p], difference[p], mgh_nm_rad);
  if (simulates) {
    const cohort::ValueSpread spread = spread_of(options, model, {at, difference, participant});
    for (std::size_t p = 0; p < table.size(); ++p) {
      if (known[p]) continue;
      measured[p] = spread.measurement_sd[p];
      of_values[p] = spread.participant_sd[p];
    }
  }

  const double significance = 0.05 / options.intervals;  // Bonferroni
  Json list = Json::array();
  std::string text = format("%-22s %12s %12s %14s %12s %10s %12s\n", "parameter, unit", "mean", "difference",
                            "participant sd", "recording sd", "power", "participants");
  for (std::size_t p = 0; p < table.size(); ++p) {
    if (!wanted[p]) continue;
    cohort::PowerDesign design = options.design;
    design.participants = static_cast<std::size_t>(options.participants);
    design.trials = static_cast<std::size_t>(options.trials);
    design.participant_sd = of_values[p];
    design.visit_sd = visit[p];
    design.trial_sd = trial[p];
    design.measurement_sd = measured[p];
    const double power = cohort::power_of(design, difference[p], significance);
    const std::size_t needed = cohort::participants_for(design, difference[p], options.power, significance);
    text += format("%-22s %12.5g %12.4g %14.4g %12.4g %9.1f%% %12s\n", name_and_unit(table[p]).c_str(), at[p],
                   difference[p], participant[p], measured[p], 100.0 * power,
                   needed > 0 ? std::to_string(needed).c_str() : "-");
    list.push_back({{"name", table[p].name},
                    {"unit", table[p].unit},
                    {"mean", at[p]},
                    {"difference", difference[p]},
                    {"participant_sd", participant[p]},
                    {"participant_sd_of_values", of_values[p]},
                    {"visit_sd", visit[p]},
                    {"trial_sd", trial[p]},
                    {"measurement_sd", measured[p]},
                    {"power", power},
                    {"participants_needed", needed > 0 ? Json(needed) : Json(nullptr)}});
  }
  if (options.common.json) {
    std::cout << print_json({{"decid", version},
                             {"participants", options.participants},
                             {"trials", options.trials},
                             {"paired", options.design.paired},
                             {"power_wanted", options.power},
                             {"intervals", options.intervals},
                             {"parameters", std::move(list)}})
              << '\n';
    return;
  }
  std::cout << text
            << format(
                   "Power of %s: %d participants%s, %s each. Participants: the number%s for a power of %g%%.\n"
                   "Means, differences and standard deviations (sd) are in the parameter's unit.\n",
                   options.intervals == 1
                       ? "a 95% interval"
                       : format("one of %d 95%% intervals that hold together", options.intervals).c_str(),
                   options.participants, options.design.paired ? " in pairs" : " per group",
                   counted(options.trials, "trial").c_str(), options.design.paired ? " of pairs" : " per group",
                   100.0 * options.power);
}

}  // namespace

void add_power(const Command& program) {
  auto options = std::make_shared<PowerOptions>();
  const Command command = program.add_subcommand(
      "power", "Predict how many participants and trials you need to find a difference between groups");
  command.section("Difference");
  command
      .add_option(
          "--difference", options->differences,
          "Look for this difference of the groups' means: NAME=VALUE in SI units, or as a percentage of the mean")
      .repeatable()
      .required();
  command
      .add_option("--at", options->at, "Set a group's mean: NAME=VALUE, in SI units; default: the middle of the range")
      .repeatable();
  command
      .add_option("--participant-sd", options->participant_sd,
                  "Set the standard deviation between participants: NAME=VALUE, or as a percentage of the mean; "
                  "default: an eighth of the range")
      .repeatable();
  command
      .add_option(
          "--visit-sd", options->visit_sd,
          "Set a participant's standard deviation from visit to visit, with --paired; default: a 24th of the range")
      .repeatable();
  command
      .add_option("--trial-sd", options->trial_sd,
                  "Set a participant's standard deviation from trial to trial; default: 0")
      .repeatable();
  command
      .add_option("--measurement-sd", options->measurement_sd,
                  "Set the standard deviation of one recording's estimate; default: simulated or predicted, see --by")
      .repeatable();
  command.section("Study");
  command
      .add_option("--participants", options->participants,
                  "Predict the power for this number of participants per group")
      .range(2, 10000);
  command.add_option("--trials", options->trials, "Record this number of trials per participant and visit")
      .range(1, 1000);
  command.add_flag("--paired", options->design.paired, "Compare two visits of the same participants");
  command
      .add_option("--intervals", options->intervals,
                  "Plan for this number of intervals that hold together (simultaneous intervals), for example 7: one "
                  "per parameter and pair of groups")
      .range(1, 1000);
  command.add_option("--power", options->power, "Find the number of participants for this power").range(0.01, 0.999);
  command.section("Model");
  command
      .add_option("--by", options->by,
                  "Simulate values of decid identify (network), or predict those of decid fit (fit)")
      .one_of({"network", "fit"});
  command.add_option("--protocol", options->protocol, "With --by fit: record this protocol; default: the model's");
  command.add_option("--model", options->model, "Use this model file; default: the built-in model");
  command
      .add_option(
          "--sensor-noise", options->sensor_noise_deg,
          "Simulate recordings with this measurement noise in degrees, or from LOW to HIGH; default: the model's; "
          "with --by fit: 0.02")
      .values(1, 2);
  command.add_option("--recordings", options->recordings, "Simulate this number of recordings, four per participant")
      .range(8, 100000);
  add_seed_option(command, options->seed, "Seed the simulated recordings");
  command.footer(
      "Examples:\n"
      "  decid power --difference delay=0.02 --difference Kp=-15%\n"
      "  decid power --difference delay=0.02 --participant-sd delay=0.015 --participants 20 --trials 3\n"
      "  decid power --difference Kp=10% --paired --visit-sd Kp=30 --json\n"
      "  decid power --difference Kp=-15% --by fit --protocol short\n"
      "  decid power --difference delay=0.02 --intervals 7\n"
      "The prediction is for the t-test of the participants' means. If the estimates are uncertain, decid's "
      "hierarchical model finds more.");
  run_with(command, options, true, run_power);
}

}  // namespace decid::tools
