// decid calibrate: posteriors of trials with known parameters, and their coverage of the true values.
#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "identify/evaluation/calibration_trials.hpp"
#include "identify/evaluation/fit_conditions.hpp"
#include "sim/protocol/protocol_object.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/results/calibrated_trials.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/figures/calibration_figure.hpp"
#include "tools/report/json/parameters_json.hpp"
#include "tools/report/json/recording_json.hpp"

namespace decid::tools {
namespace {

struct CalibrateOptions {
  CommonOptions common;
  ProtocolOptions protocol;
  int trials = 300;
  std::uint64_t seed = 2026;
  bool resume = false, faults = false;
  std::string output, figure, model, conditions;
  std::vector<std::string> with, only;
  posterior::Priors priors{.start_s = 0.0, .gain = 0.0};
  posterior::Settings settings;
};

/// Returns the settings that all trials of one calibration share.
Json settings_json(const CalibrateOptions& options, const sim::Protocol& protocol,
                   std::span<const sim::Protocol> others = {}) {
  Json json{{"version", version},
            {"protocol", sim::to_json_object(protocol)},
            {"seed", options.seed},
            {"prior_start_s", options.priors.start_s},
            {"prior_gain", options.priors.gain},
            {"standing_s", options.priors.standing_s},
            {"max_steps", options.settings.max_steps},
            {"groups", options.settings.groups},
            {"max_leapfrog_steps", options.settings.max_leapfrog_steps},
            {"rounds", options.settings.rounds},
            {"trial_draws", options.settings.trial_draws},
            {"min_draws", options.settings.min_draws},
            {"max_draws", options.settings.max_draws}};
  for (const sim::Protocol& other : others) json["with"].push_back(sim::to_json_object(other));
  return json;
}

Json figures_json(const sim::ParameterTable& table, const Calibration& found) {
  const auto one = [](const ParameterCalibration& of) {
    return Json{{"mse", of.mse},
                {"predicted_variance", of.predicted_variance},
                {"network_mse", number_or_null(of.network_mse)},
                {"coverage50", of.coverage50},
                {"coverage90", of.coverage90},
                {"distance", of.distance}};
  };
  Json json{{"trials", found.trials},
            {"agreed", found.agreed},
            {"band", found.band},
            {"band_of_all", found.band_of_all},
            {"log_score", number_or_null(found.log_score)},
            {"network_log_score", number_or_null(found.network_log_score)},
            {"all", one(found.all)}};
  for (std::size_t p = 0; p < table.size(); ++p) json["parameters"][table[p].name] = one(found.parameters[p]);
  return json;
}

std::string network_text(const ParameterCalibration& of) {
  return std::isnan(of.network_mse) ? "-" : format("%.4f", of.network_mse);
}

/// Returns the line of the log scores; empty for trials of an earlier version, which have none.
std::string scores_text(const Calibration& found) {
  if (std::isnan(found.log_score)) return {};
  std::string text = format("\nlog score %.3f nats per parameter", found.log_score);
  if (!std::isnan(found.network_log_score)) text += format(", the network's %.3f", found.network_log_score);
  return text + "\n";
}

/// The quantities that partition the trials: they make a recording easy or hard to fit.
struct Key {
  const char *name, *title;
  std::function<double(const sim::Parameters& truth)> of;
};
std::vector<Key> keys(const sim::Protocol& protocol) {
  std::vector<Key> all;
  if (const std::optional<std::size_t> theta = protocol.family().find_parameter(sim::Coefficient::theta))
    all.push_back({"theta", "theta (rad/s)", [i = *theta](const sim::Parameters& truth) { return truth[i]; }});
  all.push_back({"damping_ratio", "damping ratio", [experiment = protocol.experiment](const sim::Parameters& truth) {
                   return damping_ratio(truth, experiment);
                 }});
  return all;
}

Json parts_json(const std::vector<CalibratedTrial>& trials, const sim::Protocol& protocol,
                const sim::Parameters& stddev) {
  Json json = Json::object();
  if (trials.size() < 3) return json;
  for (const Key& key : keys(protocol)) {
    for (const CalibrationPart& part : calibration_by(trials, stddev, key.of))
      json[key.name].push_back(
          {{"low", part.low}, {"high", part.high}, {"figures", figures_json(protocol.parameters(), part.figures)}});
  }
  return json;
}

std::string parts_text(const std::vector<CalibratedTrial>& trials, const sim::Protocol& protocol,
                       const sim::Parameters& stddev) {
  std::string text;
  if (trials.size() < 3) return text;
  for (const Key& key : keys(protocol)) {
    text +=
        format("\n| %s | trials | MSE | predicted variance | network | 90%% coverage |\n|---|---|---|---|---|---|\n",
               key.title);
    for (const CalibrationPart& part : calibration_by(trials, stddev, key.of)) {
      const ParameterCalibration& all = part.figures.all;
      text += format("| %.3g to %.3g | %d | %.4f | %.4f | %s | %.3f |\n", part.low, part.high, part.figures.trials,
                     all.mse, all.predicted_variance, network_text(all).c_str(), all.coverage90);
    }
  }
  return text;
}

std::string figures_text(const sim::ParameterTable& table, const Calibration& found) {
  std::string text =
      "| | MSE | predicted variance | network | 50% coverage | 90% coverage | distance "
      "|\n|---|---|---|---|---|---|---|\n";
  const auto line = [&](const std::string& name, const ParameterCalibration& of) {
    text += format("| %s | %.4f | %.4f | %s | %.3f | %.3f | %.3f |\n", name.c_str(), of.mse, of.predicted_variance,
                   network_text(of).c_str(), of.coverage50, of.coverage90, of.distance);
  };
  for (std::size_t p = 0; p < table.size(); ++p) line(table[p].name, found.parameters[p]);
  line("all", found.all);
  return text;
}

Json condition_json(const FitConditionFigures& row, const sim::ParameterTable& table) {
  return {{"condition", row.fault.name},  {"size", row.fault.size},
          {"trials", row.trials},         {"figures", row.figures ? figures_json(table, *row.figures) : Json(nullptr)},
          {"usable", row.usable},         {"caution", row.caution},
          {"not_usable", row.not_usable}, {"usable_far_off", row.usable_far_off},
          {"codes", row.codes},           {"from_network", row.from_network},
          {"mean_s", row.mean_s},         {"max_s", row.max_s}};
}

std::string conditions_text(const Json& rows) {
  std::string text =
      "| condition | size | trials | MSE | predicted | network's MSE | coverage of 90% | usable | caution |"
      " not usable | usable, beyond 5 sd | network's answer | mean s | longest s |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Json& row : rows) {
    const bool known = !row.at("figures").is_null();
    const auto figure = [&](const char* key) {
      const Json value = known ? row.at("figures").at("all").at(key) : Json(nullptr);
      return value.is_null() ? std::string("-") : format("%.3f", value.get<double>());
    };
    text += format("| %s | %g | %d | %s | %s | %s | %s | %d | %d | %d | %d | %d | %.1f | %.1f |\n",
                   row.at("condition").get<std::string>().c_str(), row.at("size").get<double>(),
                   row.at("trials").get<int>(), figure("mse").c_str(), figure("predicted_variance").c_str(),
                   figure("network_mse").c_str(), figure("coverage90").c_str(), row.at("usable").get<int>(),
                   row.at("caution").get<int>(), row.at("not_usable").get<int>(), row.at("usable_far_off").get<int>(),
                   row.at("from_network").get<int>(), row.at("mean_s").get<double>(), row.at("max_s").get<double>());
  }
  return text;
}

bool begin_with(const Json& rows, const std::vector<FitCondition>& conditions) {
  if (!rows.is_array() || rows.size() > conditions.size()) return false;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Fault& fault = conditions[i].fault;
    if (!rows[i].is_object() || rows[i].value("condition", Json()) != fault.name ||
        rows[i].value("size", Json()) != fault.size)
      return false;
  }
  return true;
}

/// Returns the rows that an earlier call wrote. Throws Error for the rows of another call.
Json earlier_rows(const std::string& path, const Json& settings, const std::vector<FitCondition>& conditions) {
  const Json earlier = parse_json(read_file(path), path);
  if (!earlier.is_object() || !earlier.contains("settings") || !earlier.contains("conditions"))
    throw Error(Code::file_unsupported, path, "is not a table of decid calibrate",
                "give the file that --faults or --conditions wrote");
  require_same_settings(earlier["settings"], settings, path);
  if (!begin_with(earlier["conditions"], conditions))
    throw Error(Code::file_differs, path, "has other rows than this call makes", "delete it, or give another --output");
  return earlier["conditions"];
}

/// Returns "resuming: faults.json has 3 of 18 rows", also if the file does not exist yet.
std::string resuming_text(const std::string& path, std::size_t done, std::size_t all, const char* what) {
  return format("resuming: %s has %zu of %zu %s", path.c_str(), done, all, what);
}

/// Returns the rows with one of these names; all rows if there are no names. Throws Error for a name without a row.
std::vector<FitCondition> chosen_rows(std::vector<FitCondition> rows, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (std::ranges::any_of(rows, [&](const FitCondition& row) { return row.fault.name == name; })) continue;
    std::string all;
    for (const FitCondition& row : rows)
      if (all.find(row.fault.name) == std::string::npos) all += (all.empty() ? "" : ", ") + row.fault.name;
    throw Error(Code::setting_unknown, "--only", "'" + name + "' is not a row of this table", "name one of " + all);
  }
  if (!names.empty())
    std::erase_if(rows,
                  [&](const FitCondition& row) { return std::ranges::find(names, row.fault.name) == names.end(); });
  return rows;
}

std::string with_call(Json json, const Call& call) {
  add_call(json, call);
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// Makes the table of recording conditions or artefacts: fits as users run them, with start and gain unknown.
void run_conditions(const CalibrateOptions& options, const Command& command) {
  if (ranks() != nullptr)
    throw Error(Code::not_supported, "--conditions", "runs in one process", "start it without mpirun");
  std::vector<std::string> inputs;
  ProtocolOptions named = options.protocol;
  if (!options.conditions.empty()) named.name = options.conditions;
  sim::Protocol protocol = named.load(options.common.quiet, &inputs);
  inputs.push_back(options.model);
  refuse_same_file(options.output, inputs);
  if (!options.output.empty()) PendingFile probe(options.output);  // reports an unwritable place before the work
  FitRequest request{{}, options.settings};  // with fit's own priors, except for those that are given
  if (command.count("--prior-start") > 0) request.priors.start_s = options.priors.start_s;
  if (command.count("--prior-gain") > 0) request.priors.gain = options.priors.gain;
  if (command.count("--standing") > 0) request.priors.standing_s = options.priors.standing_s;
  if (protocol.standing_s == 0.0) protocol.standing_s = request.priors.standing_s;
  const Model model = model_or_built_in(options.model);
  CalibrateOptions used = options;
  used.priors = request.priors;
  Json settings = settings_json(used, protocol);
  settings["trials"] = options.trials;
  settings["faults"] = options.faults;
  settings["network"] = nn::weights_sha256(model.network);
  const std::vector<FitCondition> conditions =
      chosen_rows(options.faults ? fit_faults(protocol, request.priors) : fit_conditions(protocol), options.only);
  Json rows = Json::array();
  if (options.resume && path_exists(options.output)) rows = earlier_rows(options.output, settings, conditions);
  if (options.resume && !options.common.quiet)
    std::cerr << "calibrate: " << resuming_text(options.output, rows.size(), conditions.size(), "rows") << '\n';
  Call call = record_call(command, inputs);
  call.seed = options.seed;
  const auto document = [&] { return with_call({{"settings", settings}, {"conditions", rows}}, call); };
  catch_interrupt();
  for (std::size_t i = rows.size(); i < conditions.size() && !interrupted(); ++i) {
    const Fault& fault = conditions[i].fault;
    if (!options.common.quiet)
      std::cerr << format("calibrate: row %zu of %zu, %s\n", i + 1, conditions.size(), fault.text.c_str());
    const FitConditionFigures row =
        fit_condition(model, protocol, conditions[i], request, options.trials, options.seed,
                      [](std::size_t, const posterior::Progress&) { return !interrupted(); });
    if (row.trials == 0) break;
    rows.push_back(condition_json(row, protocol.parameters()));
    if (!options.output.empty()) write_file(options.output, document());
  }
  std::cout << (options.common.json ? document() : conditions_text(rows));
  if (rows.size() < conditions.size())
    throw std::runtime_error(format("stopped after %zu of %zu rows%s", rows.size(), conditions.size(),
                                    options.output.empty() ? "" : "; --resume continues"));
}

void run_calibrate(const CalibrateOptions& options, const Command& command) {
  std::vector<std::string> inputs;
  const sim::Protocol protocol = options.protocol.load(options.common.quiet, &inputs);
  std::vector<sim::Protocol> protocols{protocol};
  for (const std::string& name : options.with) {
    ProtocolOptions other = options.protocol;
    other.name = name;
    protocols.push_back(other.load(options.common.quiet, &inputs));
  }
  inputs.push_back(options.model);
  refuse_same_file(options.output, inputs);
  Call call = record_call(command, inputs);
  call.seed = options.seed;
  inputs.push_back(options.output);
  refuse_same_file(options.figure, inputs);
  for (const std::string& path : {options.output, options.figure})
    if (!path.empty() && is_root()) PendingFile probe(path);
  const Json settings = settings_json(options, protocol, std::span(protocols).subspan(1));
  const Model model = model_or_built_in(options.model);
  if (!options.model.empty()) require_same_experiment(model, options.model, protocol, "protocol " + protocol.name);
  NetworkAnswers network(model, protocol);
  const Json hash = network.sha256().empty() ? Json(nullptr) : Json(network.sha256());
  const std::size_t parameters = protocol.parameters().size();
  std::vector<CalibratedTrial> trials;
  if (is_root() && options.resume && path_exists(options.output))
    trials = earlier_trials(options.output, settings, hash, parameters);
  trials = broadcast_value(std::move(trials));  // others need their numbers
  const posterior::Priors priors = posterior::with_conventions(options.priors, protocol.ranges());
  std::deque<posterior::Density> densities;
  for (const sim::Protocol& one : protocols) densities.emplace_back(one, priors);
  CalibrationTrials source(protocols, options.priors, options.seed);
  for (CalibratedTrial& trial : trials) {
    source.seek(trial.attempt);
    const CalibrationTrials::Trial again = source.next();
    if (!trial.network) network.answer(again.sway_rad, trial);
  }
  const sim::ParameterTable table = protocol.ranges();
  const sim::Parameters stddev = uniform_stddev(table);

  const auto document = [&] {
    Json all = Json::array();
    for (const CalibratedTrial& trial : trials) all.push_back(trial_json(trial));
    Json json{{"settings", settings},
              {"network", hash},
              {"calibration", figures_json(table, compute_calibration(trials, stddev))}};
    const bool some = std::ranges::any_of(trials, &CalibratedTrial::agreed);
    json["parts"] = parts_json(trials, protocol, stddev);
    json["agreeing"] = some ? figures_json(table, calibration_of_agreeing(trials, stddev)) : Json(nullptr);
    json["trials"] = std::move(all);
    return with_call(std::move(json), call);
  };
  catch_interrupt();
  {
    ProgressBar bar("calibrate", "trials", options.trials, options.common.quiet);
    if (options.resume)
      bar.line(resuming_text(options.output, trials.size(), static_cast<std::size_t>(options.trials), "trials"));
    bar.go_on_from(static_cast<long long>(trials.size()));
    const int processes = ranks() != nullptr ? ranks()->size() : 1;
    bool going = true;
    while (static_cast<int>(trials.size()) < options.trials && going) {
      // Several trials per thread, because some take far longer. The results do not depend on the number.
      std::vector<CalibrationTrials::Trial> batch;
      const int most = 4 * thread_count() * processes;
      for (int i = 0; i < most && static_cast<int>(trials.size() + batch.size()) < options.trials; ++i)
        batch.push_back(source.next());
      std::vector<CalibratedTrial> done(batch.size());
      going = share_out<CalibratedTrial>(
          batch.size(), static_cast<std::size_t>(processes > 1 ? thread_count() : most),
          [&](std::size_t first, std::size_t last, const Give<CalibratedTrial>& give) {
            parallel_for(static_cast<int>(last - first), [&](int i) {
              const std::size_t place = first + static_cast<std::size_t>(i);
              if (auto trial = calibrate_trial(densities, batch[place], table, options.settings, interrupted))
                give(place, std::move(*trial));
            });
          },
          [&](std::size_t i, CalibratedTrial trial) { done[i] = std::move(trial); }, interrupted);
      if (!going) break;
      if (is_root())
        for (std::size_t i = 0; i < batch.size(); ++i) network.answer(batch[i].sway_rad, done[i]);
      trials.insert(trials.end(), done.begin(), done.end());
      if (!options.output.empty() && is_root()) write_file(options.output, document());
      bar.update(static_cast<long long>(trials.size()));
    }
  }
  if (!is_root()) return;
  if (trials.empty()) throw std::runtime_error("stopped before the first trial was done");
  const Calibration found = compute_calibration(trials, stddev);
  if (options.common.json) {
    std::cout << document();
  } else {
    std::cout << format(
                     "%d trials, chains of %d agree\nBy chance, one parameter's distance from uniform is beyond %.3f "
                     "in 5%% of calibrations, the largest beyond %.3f\n\n",
                     found.trials, found.agreed, found.band, found.band_of_all)
              << figures_text(table, found) << scores_text(found) << parts_text(trials, protocol, stddev);
  }
  if (!options.figure.empty()) write_file(options.figure, calibration_figure(table, trials, found.band_of_all));
  if (interrupted())
    throw std::runtime_error(format("stopped after %zu of %d trials%s", trials.size(), options.trials,
                                    options.output.empty() ? "" : "; --resume continues"));
}

void run_calibrate_or_conditions(CalibrateOptions& options, const Command& command) {
  options.settings.min_draws = std::min(options.settings.min_draws, options.settings.max_draws);
  if (options.faults && !options.conditions.empty())
    throw Error(Code::setting_conflict, "--faults", "cannot be combined with --conditions", "give one of them");
  if (!options.with.empty() && (options.faults || !options.conditions.empty()))
    throw Error(Code::setting_conflict, "--with", "cannot be combined with --faults or --conditions", "leave it out");
  if (!options.only.empty() && !options.faults && options.conditions.empty())
    throw Error(Code::setting_conflict, "--only", "chooses rows of --conditions or --faults", "add one of them");
  if (options.resume && options.output.empty())
    throw Error(Code::setting_missing, "--resume", "needs --output", "name the file to continue");
  if (options.faults || !options.conditions.empty()) return run_conditions(options, command);
  run_calibrate(options, command);
}

}  // namespace

void add_calibrate(const Command& program) {
  auto options = std::make_shared<CalibrateOptions>();
  const Command command = program.add_subcommand("calibrate", "Measure errors and coverage of fit on simulated trials");
  command.section("Trials");
  command.add_option("--trials", options->trials, "Simulate this many trials").range(1, 1'000'000);
  add_protocol_options(command, options->protocol);
  add_seed_option(command, options->seed, "Seed the trials");
  command.add_option("--model", options->model,
                     "Compare with the network of this model file; default: the built-in model");
  command
      .add_option("--prior-start", options->priors.start_s,
                  "Shift each trial's start by up to this many seconds, which fit has to estimate; 0: known")
      .range(0.0, 0.5);
  command
      .add_option("--prior-gain", options->priors.gain,
                  "Scale each trial's sway by a random factor, which fit has to estimate, with this standard deviation "
                  "of its logarithm; 0: known")
      .range(0.0, 0.5);
  command
      .add_option("--standing", options->priors.standing_s,
                  "Let the body stand and sway for this many seconds before each trial; 0: it starts at rest")
      .range(0.0, 60.0);
  command
      .add_option("--with", options->with,
                  "Record each simulated person once more, with this protocol, and fit the recordings together; may be "
                  "repeated")
      .repeatable()
      .shown_as("PROTOCOL");
  command.add_option("--conditions", options->conditions,
                     "Measure each recording condition of this protocol alone, then all together");
  command.add_flag("--faults", options->faults,
                   "Measure one recording artefact per table row, with unknown start and gain");
  command
      .add_option("--only", options->only,
                  "Measure only the rows of --conditions or --faults with this name; may be repeated")
      .repeatable()
      .shown_as("NAME");
  command.section("Advanced");
  command.add_option("--max-draws,--most-draws", options->settings.max_draws, "Take at most this many draws per chain")
      .range(8, 1'000'000);
  command.add_option("--groups", options->settings.groups, "Run this many groups of eight chains").range(1, 64);
  add_output_option(command, "-o,--output", options->output, Written::json,
                    "Write the results to this JSON file, which is updated every few trials");
  add_output_option(command, "--figure", options->figure, Written::svg,
                    "Draw the ranks of the true values among the draws to this SVG file");
  command.section("Output");
  command.add_flag("--resume", options->resume, "Continue with the trials in the output file");
  command.footer(
      "Examples:\n"
      "  decid calibrate --trials 300 --sensor-noise 0.02 -o calibration.json\n"
      "  decid calibrate --trials 40 --sensor-noise 0.02 --with default --with default\n"
      "  decid calibrate --conditions examples/laboratory.json --sensor-noise 0.02 --trials 60\n"
      "  decid calibrate --faults --sensor-noise 0.02 --trials 60 -o artefacts.json --resume");
  run_with(command, options, true, run_calibrate_or_conditions);
}

}  // namespace decid::tools
