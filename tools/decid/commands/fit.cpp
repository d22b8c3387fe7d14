// decid fit: recordings or a published frequency response in, the posterior of their controllers out.
#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "identify/compared_controllers.hpp"
#include "identify/fit_recordings.hpp"
#include "identify/network/for_body.hpp"
#include "identify/result_archive.hpp"
#include "identify/study/joint_groups.hpp"
#include "identify/study/plan_groups.hpp"
#include "identify/study/study_results.hpp"
#include "sim/protocol/protocol_object.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/commands/fit_all.hpp"
#include "tools/decid/commands/fit_frf.hpp"
#include "tools/decid/commands/fit_journal.hpp"
#include "tools/decid/group_file.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/prior_texts.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/recording_flags.hpp"
#include "tools/decid/results/outputs.hpp"
#include "tools/decid/results/results.hpp"

namespace decid::tools {
namespace {

struct FitOptions {
  CommonOptions common;
  RecordingFlags recordings;
  Outputs outputs;
  GroupFlags groups;
  std::string model, protocol, frf;
  std::string joint, free;  ///< columns of the sheet; free: NAME,..:COLUMN
  bool resume = false;
  std::optional<double> amplitude_deg, prior_error, prior_gain;
  PriorTexts priors;
  std::string controllers;  ///< names, separated by commas
  std::string objective = "posterior";
  FitRequest request;
};

/// Options that apply only to recordings, except the file-reading options, and options that apply only to a frequency
/// response.
constexpr const char* of_recordings[] = {"recordings", "--model",  "--prior-start",  "--prior-noise", "--max-draws",
                                         "--table",    "--group",  "--moved-before", "--resume",      "--recursive",
                                         "--study",    "--long",   "--excel",        "--figures",     "--joint",
                                         "--free",     "--within", "--covariates"};
constexpr const char* of_tables[] = {"--amplitude", "--prior-error", "--objective"};

/// Throws Error for options that do not apply to the input.
void check_kind(const FitOptions& options, const Command& command) {
  const bool is_table = !options.frf.empty();
  if (!is_table && options.recordings.files.empty() && options.recordings.study.empty())
    throw Error(Code::setting_missing, "fit", "neither a recording nor a frequency response is named",
                "name CSV, MAT, C3D or .xlsx files, a sheet with --study, or a table with --frf");
  const auto refuse = [&](const char* option) {
    if (command.count(option) == 0) return;
    if (is_table && std::string(option) == "recordings")
      throw Error(Code::setting_conflict, "--frf", "cannot be combined with recordings",
                  "fit them in a call of their own");
    throw Error(Code::setting_conflict, option, is_table ? "cannot be combined with --frf" : "applies to --frf only",
                "leave it out");
  };
  if (is_table) std::ranges::for_each(of_recordings, refuse);
  if (is_table) std::ranges::for_each(reading_options, refuse);
  if (!is_table) std::ranges::for_each(of_tables, refuse);
}

/// Returns the chosen protocol, with the person's body if the options describe one.
sim::Protocol protocol_for(const FitOptions& options, sim::Protocol protocol) {
  options.recordings.refuse_instead_of(protocol);
  if (const std::optional<sim::Body> body = options.recordings.body()) protocol.experiment.body = *body;
  if (options.amplitude_deg) {
    if (!std::holds_alternative<sim::Sequence>(protocol.experiment.stimulus))
      throw Error(Code::setting_conflict, "--amplitude",
                  "protocol '" + protocol.name + "' plays no ternary sequence, the tilt that it scales",
                  "leave it out, and give the amplitudes in the protocol's file");
    protocol.sequence().amplitude_deg = *options.amplitude_deg;
  }
  protocol.validate();
  return protocol;
}

void run_table(const FitOptions& options, const Command& command) {
  if (!is_root()) return;  // one answer, on one rank
  std::vector<std::string> inputs{options.frf};
  const sim::Protocol named =
      read_protocol(options.protocol.empty() ? "default" : options.protocol, options.common.quiet, &inputs);
  options.outputs.check(inputs);
  if (options.outputs.draws.ends_with(".csv"))
    throw Error(Code::setting_conflict, "--draws", "writes .npz for --frf", "give a name that ends in .npz");
  FrfFit asked{.table = options.frf,
               .output = options.outputs.json,
               .draws = options.outputs.draws,
               .page = options.outputs.page,
               .controllers = {},
               .truth = {},
               .particles = {.seed = options.request.settings.seed},
               .log_ratio = options.objective == "log-ratio",
               .json = options.common.json,
               .options = command.given(options_reported_elsewhere),
               .call = record_call(command, inputs),
               .body_assumed = !options.recordings.body() && named.experiment.body == sim::Body{}};
  sim::Protocol protocol = protocol_for(options, named);
  asked.call.seed = options.request.settings.seed;
  const std::vector<const sim::BodyModel*> controllers =
      controllers_to_fit(options.controllers, protocol, "--controller");
  for (const sim::BodyModel* controller : controllers) {
    protocol.experiment.body_model = controller;
    const posterior::Priors given{.parameters = parameter_priors(options.priors, protocol, controllers)};
    frf::Priors priors{.gain = options.prior_gain.value_or(frf::Priors{}.gain),
                       .error = options.prior_error,
                       .parameters = posterior::in_si_units(given, protocol).parameters};
    asked.controllers.push_back({protocol, std::move(priors)});
  }
  if (asked.log_ratio && !options.priors.normals.empty())
    throw Error(Code::setting_conflict, "--prior",
                "cannot be combined with --objective log-ratio, which uses ranges only", "give --range or --fix");
  for (const char* option : {"--prior-error", "--prior-gain"})
    if (asked.log_ratio && command.count(option) > 0)
      throw Error(Code::setting_conflict, option, "has no effect on --objective log-ratio, which uses no priors",
                  "leave it out");
  const sim::ParameterTable& parameters = asked.controllers.front().protocol.parameters();
  if (asked.controllers.size() == 1) asked.truth = options.recordings.known(parameters);
  if (asked.controllers.size() > 1 && command.count("--truth") > 0)
    throw Error(Code::setting_conflict, "--truth", "cannot be combined with several controllers",
                "name one with --controller");
  run_frf_fit(asked);
}

/// Opens the journal beside the output of several recordings. Returns nothing if there is no output or it is not a
/// regular file.
std::optional<FitJournal> journal_of(const FitOptions& options, const std::string& settings) {
  const std::string& output = options.outputs.json;
  if (options.resume && output.empty())
    throw Error(Code::setting_missing, "--resume", "needs --output", "name the file to continue");
  std::error_code ignored;
  const bool is_file = !path_exists(output) || std::filesystem::is_regular_file(output, ignored);
  if (output.empty() || options.recordings.files.size() < 2 || !is_file) return std::nullopt;
  return std::make_optional<FitJournal>(output + ".journal", settings, options.resume);
}

/// Returns the report of the recordings whose fit began, with the groups of the table of all recordings.
Report report_of_begun(const FitOptions& options, const PlanFitter& fitter, FitResults results, GroupTable groups,
                       std::vector<std::size_t>& places) {
  Report report = fitter.report();
  std::vector<GroupMember> members;
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (!results[i]) continue;
    places.push_back(i);
    report.recordings.push_back(std::move(*results[i]));
    if (options.groups.given()) members.push_back(groups.members[i]);
  }
  groups.members = std::move(members);
  warn_of_same_sway(report.recordings);
  if (options.groups.given()) report.groups = report_groups(std::move(groups), report);
  return report;
}

/// Completes options.request with the controllers after the first one, and with the priors of all.
void set_controllers(FitOptions& options, const std::vector<const sim::BodyModel*>& controllers,
                     sim::Protocol protocol) {
  for (const sim::BodyModel* controller : controllers) {
    protocol.experiment.body_model = controller;
    std::vector<posterior::ParameterPrior> priors =
        parameter_priors(options.priors, protocol, controllers, !options.recordings.study.empty());
    if (controller == controllers.front())
      options.request.priors.parameters = std::move(priors);
    else
      options.request.others.push_back({controller, std::move(priors)});
  }
}

/// Everything that a call of recordings reads, except options.request.
struct FitInput {
  Model model;
  sim::Protocol protocol{};
  std::vector<const sim::BodyModel*> controllers{};
  FreedParameters freed{};
  RecordingPlan plan{};
  GroupTable groups{};
  std::vector<std::string> files{};  ///< all that were read
};

/// Finds the recordings, reads all files except them, and completes options.request. Throws Error for options that
/// contradict each other or the recordings.
FitInput read_input(FitOptions& options) {
  if (!options.free.empty() && options.joint.empty())
    throw Error(Code::setting_conflict, "--free", "applies to recordings that are fitted together only",
                "give --joint too");
  if (!options.free.empty() && options.groups.given())
    throw Error(Code::setting_conflict, "--free",
                "cannot be combined with a comparison of participants: a person's joint fit counts once, with one "
                "value of each parameter",
                "leave it out to compare participants");
  RecordingFlags& recordings = options.recordings;
  ReadOptions reading = recordings.read_options();
  recordings.find_sources({options.model, options.protocol, options.groups.table, recordings.study},
                          options.outputs.files(), options.common.quiet);
  std::vector<std::string> inputs;
  std::optional<sim::Protocol> given;
  if (!options.protocol.empty()) given = read_protocol(options.protocol, options.common.quiet, &inputs);
  FitInput input{model_or_built_in(options.model)};
  input.protocol = protocol_for(options, given.value_or(input.model.protocol));
  input.controllers = controllers_to_fit(options.controllers, input.protocol, "--controller");
  input.protocol.experiment.body_model = input.controllers.front();
  set_controllers(options, input.controllers, input.protocol);
  if (!options.joint.empty() && input.controllers.size() > 1)
    throw Error(Code::setting_conflict, "--joint", "cannot be combined with several controllers",
                "name one with --controller");
  input.freed = read_freed(options.free, input.protocol.parameters());
  options.request.freed = input.freed.names;
  reading.truth = recordings.known(input.protocol.parameters());
  reading.body = recordings.body();
  // A protocol of one's own may describe it.
  if (!reading.body && given && given->experiment.body != sim::Body{}) reading.body = given->experiment.body;

  input.plan = recordings.plan(reading, options.common.quiet);
  input.files = recordings.distinct_files();
  input.files.insert(input.files.end(), inputs.begin(), inputs.end());
  input.files.insert(input.files.end(), {recordings.study, options.model, options.groups.table});
  options.outputs.check(input.files);
  input.groups = read_groups(options.groups, recordings, input.plan, options.common.quiet);
  if (!options.joint.empty()) {
    refuse_repeated(input.plan, "--joint");
    refuse_joint_cells(input.groups, joint_groups(input.plan, options.joint, input.freed.conditions));
  }
  return input;
}

/// Returns the settings that all results of a journal share.
std::string journal_settings(const FitInput& input, const Command& command) {
  Json names = Json::array();
  for (const sim::BodyModel* controller : input.controllers) names.push_back(controller->name);
  return print_json({{"version", version},
                     {"controllers", std::move(names)},
                     {"protocol", sim::to_json_object(input.protocol)},
                     {"model", nn::weights_sha256(input.model.network)},
                     {"options", command.given(options_reported_elsewhere)}});
}

void run_fit(FitOptions options, const Command& command) {
  FitInput input = read_input(options);
  const RecordingFlags& recordings = options.recordings;
  std::optional<FitJournal> journal = is_root() ? journal_of(options, journal_settings(input, command)) : std::nullopt;
  catch_interrupt();
  options.request.keeps_log_likelihood = options.outputs.draws.ends_with(".npz");
  PlanFitter fitter(&input.model, input.protocol, input.plan, options.request, &input.files);
  if (options.groups.given()) static_cast<void>(fitter.report().compared_parameters());  // throws if all are fixed
  FitResults results = fit_all(
      {recordings.sources, listed(recordings.files), options.joint, input.freed.conditions, options.common.quiet},
      fitter, input.plan, journal ? &*journal : nullptr);
  if (!is_root()) return;
  options.outputs.count = results.size();
  Report report = report_of_begun(options, fitter, std::move(results), input.groups, options.outputs.places);
  const std::vector<RecordingResult>& begun = report.recordings;
  report.model = model_name(options.model);
  report.model_sha256 = nn::weights_sha256(input.model.network);
  report.options = command.given(options_reported_elsewhere);
  report.call = record_call(command, input.files, recordings.named);
  report.call.seed = options.request.settings.seed;
  options.outputs.refuse_alone(report, options.common.json);
  options.outputs.write(report, options.common.json);
  const bool failed = std::ranges::any_of(begun, [](const RecordingResult& id) { return id.error.has_value(); });
  if (journal && !failed && begun.size() == options.outputs.count && !interrupted()) journal->remove();
  if (interrupted())
    throw std::runtime_error(format("stopped at recording %zu of %zu; decid wrote the draws until then%s", begun.size(),
                                    options.outputs.count, journal ? "; --resume continues" : ""));
  if (journal && failed && !options.common.quiet)
    std::cerr << "decid: correct these recordings, then --resume fits only them\n";
  tell_errors("fit", begun);
}

void run_fit_or_table(FitOptions& options, const Command& command) {
  check_kind(options, command);
  if (options.prior_gain) options.request.priors.gain = *options.prior_gain;
  options.request.settings.min_draws = std::min(options.request.settings.min_draws, options.request.settings.max_draws);
  if (options.frf.empty()) return run_fit(options, command);
  run_table(options, command);
}

}  // namespace

void add_fit(const Command& program) {
  auto options = std::make_shared<FitOptions>();
  const Command command = program.add_subcommand(
      "fit",
      "Sample the posterior of balance-control parameters from recordings; slower and more accurate than identify");
  add_recording_flags(command, options->recordings);
  add_study_option(command, options->recordings);
  add_truth_option(command, options->recordings);
  command.section("Input");
  command.add_option("--frf", options->frf,
                     "Fit this table of a frequency response instead of recordings: columns frequency_hz, gain, "
                     "phase_deg and, if known, sd, ci95, radius95, or coherence and cycles");
  command
      .add_option("--amplitude", options->amplitude_deg,
                  "Use this peak-to-peak tilt in degrees for --frf; default: the protocol's")
      .range(1e-3, 20.0);
  add_body_options(command, options->recordings);
  command.section("Model");
  command.add_option("--protocol", options->protocol,
                     "Use this protocol: default, short, or a JSON file; default: the model's");
  command.add_option(
      "--model", options->model,
      "Use this model file for the protocol, and for the estimate if the chains disagree and no parameter has another "
      "prior; default: the built-in model");
  command
      .add_option("--controller", options->controllers,
                  "Fit this controller: dec, dec2015 or ic; compare several, separated by commas, and report the "
                  "estimates of the first one; default: the protocol's")
      .shown_as("NAME,...");
  command.section("Advanced");
  command
      .add_option(
          "--objective", options->objective,
          "Fit an --frf table by its posterior, or by least squares of the log ratio of model and table, weighted "
          "by coherence over frequency (log-ratio); default: posterior")
      .one_of({"posterior", "log-ratio"});
  command
      .add_option("--joint", options->joint,
                  "Fit recordings together that have the same value in this column of the sheet, such as "
                  "participant_id; all: fit all recordings of a call without a sheet together")
      .shown_as("COLUMN");
  command
      .add_option("--free", options->free,
                  "Let these parameters of --joint fits differ between the values of a column of the sheet, such as "
                  "theta,Nv:condition")
      .shown_as("NAME,..:COLUMN");
  command
      .add_option("--prior-start", options->request.priors.start_s,
                  "Allow the recording to start up to this many seconds before or after the protocol; 0: both start "
                  "together; a tilt column overrides this")
      .range(0.0, 0.5);
  command
      .add_option("--prior-gain", options->prior_gain,
                  format("Expect this relative error of the sway sensor's scale (standard deviation of its logarithm); "
                         "0: exact; default: %g. With --frf, expect this relative error of all gains; default: %g",
                         posterior::Priors{}.gain, frf::Priors{}.gain))
      .range(0.0, 0.5);
  command
      .add_option("--prior-noise", options->request.priors.sensor_noise_deg,
                  "Expect this measurement noise in degrees, within a factor of 20")
      .range(1e-6, 10.0);
  add_prior_options(command, options->priors);
  command.add_flag("--moved-before", options->request.priors.moved_before,
                   "Assume that the platform played the end of a cycle before the recording; default: it rested");
  command
      .add_option("--prior-error", options->prior_error,
                  "Allow errors of an --frf table beyond its confidence intervals, as a fraction of the response, "
                  "within a factor of 3; default: 0.01, or 0.05 for a table without confidence intervals")
      .range(0.0, 1.0);
  command
      .add_option("--max-draws,--most-draws", options->request.settings.max_draws,
                  "Take at most this many draws per chain; decid stops earlier if fewer suffice")
      .range(8, 1'000'000);
  add_seed_option(command, options->request.settings.seed, "Seed the chains");
  add_report_options(command, options->outputs, true);
  add_group_options(command, options->groups);
  command.section("Output");
  command
      .add_flag("--resume", options->resume,
                "Continue a stopped call: skip the recordings that are done, which OUTPUT.journal holds")
      .unrecorded();
  command.footer(
      "Examples:\n"
      "  decid fit recording.csv --mass 70 --height 1.75 -o result.json --report report.html\n"
      "  decid fit recordings -o results.json --table results.csv --resume\n"
      "  decid fit --study participants.tsv -o results.json --long long.csv\n"
      "  decid fit recording.csv --range delay=0.05,0.2 --prior Kp/mgh=1,0.2 --draws draws.npz\n"
      "  decid fit --frf response.csv --amplitude 1 --mass 70 --height 1.75 --report response.html");
  run_with(command, options, true, run_fit_or_table);
}

}  // namespace decid::tools
