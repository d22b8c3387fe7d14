// decid power: how many participants and trials a difference between two groups or visits needs.
#include "identify/cohort/power.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "identify/cohort/planning.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/named_values.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/json/recording_json.hpp"

namespace decid::tools {
namespace {

constexpr double default_noise_deg = 0.02;
constexpr int max_fits = 128;
constexpr int min_people = 100;  ///< a standard deviation of fewer has a standard error above 7%

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

/// The study's parameters, SI units, and which of them the options give.
struct PowerValues {
  sim::Parameters at, difference, participant, visit, trial, measured;            ///< means and standard deviations
  std::vector<bool> has_mean, wanted, has_sd, has_visit_sd, has_trial_sd, known;  ///< known: --measurement-sd
  bool simulates;  ///< a difference of a parameter without --measurement-sd
};

/// A parameter with a difference, and its power.
struct PowerRow {
  const sim::ParameterInfo& info;
  double mean, difference, participant_sd;
  cohort::PowerDesign design;  ///< with the standard deviation of the participants' values
  double power;
  std::size_t needed;         ///< participants; 0: more than the search's maximum
  std::size_t trials_needed;  ///< with the given number of participants; 0: as above
};

/// Returns the protocol of the study: --protocol, or the model's. files: receives the names of the files that were
/// read.
sim::Protocol study_protocol(const PowerOptions& options, const Model& model, std::vector<std::string>& files) {
  if (options.protocol.empty()) return model.protocol;
  if (options.by == "network")
    throw Error(Code::setting_conflict, "--protocol", "is for --by fit: a network reads its own protocol",
                "add --by fit, or leave it out");
  sim::Protocol protocol = read_protocol(options.protocol, options.common.quiet, &files);
  if (protocol.experiment.body_model != model.protocol.experiment.body_model)
    throw Error(Code::setting_conflict, "--protocol", "has another controller than the model",
                "give a protocol of the model's controller");
  return protocol;
}

/// Throws Error for a difference of a parameter that fits fix by convention, so that they do not measure it.
void refuse_fixed(const PowerValues& values, const sim::ParameterTable& table) {
  for (std::size_t p = 0; p < table.size(); ++p)
    if (values.wanted[p] && !values.known[p] && table[p].convention)
      throw Error(Code::setting_conflict, "--difference",
                  table[p].name + format(" is fixed at %g", *table[p].convention) + table[p].unit_after() +
                      " in fits, which do not measure it",
                  "give its --measurement-sd, or differences of other parameters");
}

/// Returns the spread of the recordings' values: the network's, or decid fit's.
cohort::ValueSpread spread_of(const PowerOptions& options, const Model& model, sim::Protocol protocol,
                              const PowerValues& values) {
  const cohort::PlannedGroups groups{values.at, values.difference, values.participant};
  set_sensor_noise(protocol, options.sensor_noise_deg);
  if (options.by == "network")
    return cohort::spread_of_network(model, protocol, groups, options.recordings / 4, options.seed);
  const sim::SensorNoise& sensor = protocol.noise.sensor;
  const double noise_deg =
      options.sensor_noise_deg.empty() ? default_noise_deg : std::sqrt(sensor.low_deg * sensor.high_deg);
  if (noise_deg == 0.0)
    throw Error(Code::setting_out_of_range, "--sensor-noise", "is 0 degrees, and --by fit needs measurement noise",
                "give a level above 0");
  refuse_fixed(values, protocol.ranges());
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

/// Throws Error for a negative standard deviation, whose square would count as one of the other sign.
void refuse_negative(const std::string& option, const std::vector<bool>& given, const sim::Parameters& values,
                     const sim::ParameterTable& table) {
  for (std::size_t p = 0; p < table.size(); ++p)
    if (given[p] && values[p] < 0.0)
      throw Error(Code::setting_out_of_range, option,
                  table[p].name + format(" is %g", values[p]) + table[p].unit_after(),
                  "give a standard deviation of 0 or more");
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

/// Throws Error for options that change nothing in the call.
void refuse_unused_options(const PowerOptions& options, const PowerValues& values, const sim::ParameterTable& table,
                           const Command& command) {
  const std::string no_difference = "it has no --difference";
  for (const auto& [option, given] : {std::pair("--measurement-sd", &values.known),
                                      {"--trial-sd", &values.has_trial_sd},
                                      {"--visit-sd", &values.has_visit_sd}})
    refuse_unused(option, *given, values.wanted, table, no_difference);
  if (!values.simulates) {
    refuse_unused("--participant-sd", values.has_sd, values.wanted, table, no_difference);
    refuse_unused("--at", values.has_mean, values.wanted, table, no_difference);
  }
  if (!options.design.paired && !options.visit_sd.empty())
    throw Error(Code::setting_conflict, "--visit-sd", "is for visits of the same participants", "add --paired");
  if (options.design.paired && !values.simulates && !options.participant_sd.empty())
    throw Error(Code::setting_conflict, "--participant-sd",
                "is not used: --paired compares the visits of each participant", "leave it out, or give --visit-sd");
  for (const char* option : {"--sensor-noise", "--protocol", "--by", "--recordings", "--seed"})
    if (!values.simulates && command.count(option) > 0)
      throw Error(Code::setting_conflict, option,
                  "is not used: --measurement-sd gives the uncertainty of all recordings", "leave one of them out");
}

/// Returns the options' values, with defaults for those that are not given. Throws Error for an impossible value.
PowerValues read_options(const PowerOptions& options, const sim::Protocol& protocol, const Command& command) {
  const sim::ParameterTable table = protocol.ranges();
  const double mgh_nm_rad = protocol.experiment.body.mgh();
  const sim::Parameters none(table.size());
  PowerValues values{table.middle(), none, none, none, none, none, {}, {}, {}, {}, {}, {}, false};
  std::vector<bool> percent_at, percent_difference;
  values.has_mean = read_named_values("--at", options.at, table, mgh_nm_rad, table.middle(), values.at, &percent_at);
  values.wanted = read_named_values("--difference", options.differences, table, mgh_nm_rad, values.at,
                                    values.difference, &percent_difference);
  for (std::size_t p = 0; p < table.size(); ++p) {
    values.participant[p] = table[p].range() / 8.0;
    values.visit[p] = table[p].range() / 24.0;
  }
  values.known =
      read_named_values("--measurement-sd", options.measurement_sd, table, mgh_nm_rad, values.at, values.measured);
  values.simulates = !std::ranges::equal(values.wanted, values.known,
                                         [](bool is_wanted, bool is_known) { return is_known || !is_wanted; });
  const auto check_means = [&](const sim::Parameters& differences) {
    for (std::size_t p = 0; p < table.size(); ++p)
      if (values.simulates || values.wanted[p])  // simulated people have all parameters
        cohort::check_mean(table[p], values.at[p], differences[p], percent_at[p] ? 0.0 : mgh_nm_rad);
  };
  check_means(none);
  refuse_beyond_range("--difference", values.wanted, values.difference, table);
  for (std::size_t p = 0; p < table.size(); ++p)
    if (values.wanted[p] && values.difference[p] == 0.0)
      throw Error(Code::setting_out_of_range, "--difference", table[p].name + " is 0, which no study finds",
                  "give the smallest difference that matters");
  check_means(values.difference);
  const auto read_sd = [&](const char* option, const std::vector<std::string>& texts, sim::Parameters& sd) {
    std::vector<bool> given = read_named_values(option, texts, table, mgh_nm_rad, values.at, sd);
    refuse_beyond_range(option, given, sd, table);
    refuse_negative(option, given, sd, table);
    return given;
  };
  values.has_sd = read_sd("--participant-sd", options.participant_sd, values.participant);
  values.has_visit_sd = read_sd("--visit-sd", options.visit_sd, values.visit);
  values.has_trial_sd = read_sd("--trial-sd", options.trial_sd, values.trial);
  refuse_beyond_range("--measurement-sd", values.known, values.measured, table);
  refuse_negative("--measurement-sd", values.known, values.measured, table);
  refuse_unused_options(options, values, table, command);
  for (std::size_t p = 0; p < table.size() && !options.common.quiet; ++p)
    if (values.wanted[p] && !percent_difference[p]) note_small_difference(table[p], values.difference[p], mgh_nm_rad);
  return values;
}

/// Returns a row for each parameter with a difference.
std::vector<PowerRow> power_rows(const PowerOptions& options, const PowerValues& values, const Model& model,
                                 const sim::Protocol& protocol) {
  cohort::ValueSpread spread;
  if (values.simulates) spread = spread_of(options, model, protocol, values);
  const double significance = 0.05 / options.intervals;  // Bonferroni
  std::vector<PowerRow> rows;
  for (std::size_t p = 0; p < values.at.size(); ++p) {
    if (!values.wanted[p]) continue;
    cohort::PowerDesign design = options.design;
    design.participants = static_cast<std::size_t>(options.participants);
    design.trials = static_cast<std::size_t>(options.trials);
    design.participant_sd = values.known[p] ? values.participant[p] : spread.participant_sd[p];
    design.visit_sd = values.visit[p];
    design.trial_sd = values.trial[p];
    design.measurement_sd = values.known[p] ? values.measured[p] : spread.measurement_sd[p];
    rows.push_back({model.parameters()[p], values.at[p], values.difference[p], values.participant[p], design,
                    cohort::power_of(design, values.difference[p], significance),
                    cohort::participants_for(design, values.difference[p], options.power, significance),
                    cohort::trials_for(design, values.difference[p], options.power, significance)});
  }
  return rows;
}

/// Returns the number of simulated people from whom the standard deviations come; 0: none.
int simulated_people(const PowerOptions& options, const PowerValues& values) {
  if (!values.simulates) return 0;
  return options.by == "fit" ? std::min(options.recordings, max_fits) : options.recordings / 4;
}

Json power_json(const PowerOptions& options, const std::vector<PowerRow>& rows, int people) {
  Json list = Json::array();
  for (const PowerRow& row : rows)
    list.push_back({{"name", row.info.name},
                    {"unit", row.info.unit},
                    {"mean", row.mean},
                    {"difference", row.difference},
                    {"participant_sd", row.participant_sd},
                    {"participant_sd_of_values", row.design.participant_sd},
                    {"visit_sd", row.design.visit_sd},
                    {"trial_sd", row.design.trial_sd},
                    {"measurement_sd", row.design.measurement_sd},
                    {"power", row.power},
                    {"participants_needed", row.needed > 0 ? Json(row.needed) : Json(nullptr)},
                    {"trials_needed", row.trials_needed > 0 ? Json(row.trials_needed) : Json(nullptr)}});
  return {{"participants", options.participants}, {"trials", options.trials},
          {"paired", options.design.paired},      {"power_wanted", options.power},
          {"intervals", options.intervals},       {"simulated_participants", people > 0 ? Json(people) : Json(nullptr)},
          {"parameters", std::move(list)}};
}

std::string count_or_dash(std::size_t count) {
  return count > 0 ? std::to_string(count) : "-";
}

std::string power_text(const PowerOptions& options, const std::vector<PowerRow>& rows, int people) {
  std::string text = format("%-22s %12s %12s %14s %12s %10s %12s %8s\n", "parameter, unit", "mean", "difference",
                            "participant sd", "recording sd", "power", "participants", "trials");
  for (const PowerRow& row : rows)
    text += format("%-22s %12.5g %12.4g %14.4g %12.4g %9.1f%% %12s %8s\n", name_and_unit(row.info).c_str(), row.mean,
                   row.difference, row.participant_sd, row.design.measurement_sd, 100.0 * row.power,
                   count_or_dash(row.needed).c_str(), count_or_dash(row.trials_needed).c_str());
  return text +
         format(
             "Power of %s: %d participants%s, %s each. Participants: the number%s for a power of %g%%.\n"
             "Trials: the number per participant%s for that power with %d participants%s; -: more than 1,000.\n"
             "Means, differences and standard deviations (sd) are in the parameter's unit.\n",
             options.intervals == 1 ? "a 95% interval"
                                    : format("one of %d 95%% intervals that hold together", options.intervals).c_str(),
             options.participants, options.design.paired ? " in pairs" : " per group",
             counted(options.trials, "trial").c_str(), options.design.paired ? " of pairs" : " per group",
             100.0 * options.power, options.design.paired ? " and visit" : "", options.participants,
             options.design.paired ? " in pairs" : " per group") +
         (people > 0 && people < min_people
              ? format("Rough: the standard deviations come from %d simulated participants only. Give more "
                       "--recordings.\n",
                       people)
              : std::string());
}

void run_power(const PowerOptions& options, const Command& command) {
  const Model model = model_or_built_in(options.model);
  std::vector<std::string> inputs{options.model};
  const sim::Protocol protocol = study_protocol(options, model, inputs);
  const PowerValues values = read_options(options, protocol, command);
  const std::vector<PowerRow> rows = power_rows(options, values, model, protocol);
  const int people = simulated_people(options, values);
  if (!options.common.json) {
    std::cout << power_text(options, rows, people);
    return;
  }
  Call call = record_call(command, inputs);
  call.seed = options.seed;
  Json result = power_json(options, rows, people);
  add_call(result, call);
  std::cout << print_json(result) << '\n';
}

}  // namespace

void add_power(const Command& program) {
  auto options = std::make_shared<PowerOptions>();
  const Command command = program.add_subcommand(
      "power", "Predict how many participants and trials you need to find a difference between groups");
  command.section("Difference");
  command
      .add_option("--difference", options->differences,
                  "Look for this difference of the groups' means: NAME=VALUE in SI units, NAME/mgh=VALUE over the "
                  "body's m g h, or a percentage of the mean")
      .repeatable()
      .required();
  command
      .add_option("--at", options->at,
                  "Set a group's mean: NAME=VALUE, in SI units, or NAME/mgh=VALUE; default: the middle of the range")
      .repeatable();
  command
      .add_option("--participant-sd", options->participant_sd,
                  "Set the standard deviation between participants: NAME=VALUE, or as a percentage of the mean; "
                  "default: an eighth of the range")
      .repeatable()
      .shown_as("NAME[/mgh]=VALUE");
  command
      .add_option(
          "--visit-sd", options->visit_sd,
          "Set a participant's standard deviation from visit to visit, with --paired; default: a 24th of the range")
      .repeatable()
      .shown_as("NAME[/mgh]=VALUE");
  command
      .add_option("--trial-sd", options->trial_sd,
                  "Set a participant's standard deviation from trial to trial; default: 0")
      .repeatable()
      .shown_as("NAME[/mgh]=VALUE");
  command
      .add_option("--measurement-sd", options->measurement_sd,
                  "Set the standard deviation of one recording's estimate; default: simulated or predicted, see --by")
      .repeatable()
      .shown_as("NAME[/mgh]=VALUE");
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
  command.add_option("--power", options->power, "Find the numbers of participants and of trials for this power")
      .range(0.01, 0.999);
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
