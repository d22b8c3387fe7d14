// decid calibrate: posteriors of trials with known parameters, and their coverage of the true values.
#include "tools/decid/commands/calibrate/calibrate.hpp"

#include <algorithm>
#include <cmath>
#include <deque>
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "identify/evaluation/calibration_trials.hpp"
#include "sim/protocol/protocol_object.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/results/calibrated_trials.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/figures/calibration_figure.hpp"
#include "tools/report/json/recording_json.hpp"

namespace decid::tools {

Json settings_json(const CalibrateOptions& options, std::span<const sim::Protocol> protocols) {
  Json json{{"version", version},
            {"protocol", sim::to_json_object(protocols.front())},
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
  for (const sim::Protocol& other : protocols.subspan(1)) json["with"].push_back(sim::to_json_object(other));
  return json;
}

std::string known_number(double value, int digits) {
  return std::isnan(value) ? "-" : format("%.*f", digits, value);
}

std::string resuming_text(const std::string& path, std::size_t done, std::size_t all, const char* what) {
  return format("resuming: %s has %zu of %zu %s", path.c_str(), done, all, what);
}

std::string with_call(Json json, const Call& call) {
  add_call(json, call);
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

namespace {

/// Returns the line of the log scores; empty for trials of an earlier version, which have none.
std::string scores_text(const Calibration& found) {
  if (std::isnan(found.log_score)) return {};
  std::string text = format("\nlog score %.3f nats per parameter", found.log_score);
  if (!std::isnan(found.network_log_score)) text += format(", the network's %.3f", found.network_log_score);
  return text + "\n";
}

/// The trials, partitioned by a quantity that makes a recording easy or hard to fit.
struct Partition {
  const char *name, *title;
  std::vector<CalibrationPart> parts;
};

/// Returns no partitions of fewer than three trials.
std::vector<Partition> partitions(const std::vector<CalibratedTrial>& trials, const sim::Protocol& protocol,
                                  const sim::Parameters& stddev) {
  std::vector<Partition> all;
  if (trials.size() < 3) return all;
  if (const std::optional<std::size_t> theta = protocol.family().find_parameter(sim::Coefficient::theta))
    all.push_back({"theta", "theta (rad/s)",
                   calibration_by(trials, stddev, [&](const sim::Parameters& truth) { return truth[*theta]; })});
  all.push_back({"damping_ratio", "damping ratio", calibration_by(trials, stddev, [&](const sim::Parameters& truth) {
                   return damping_ratio(truth, protocol.experiment);
                 })});
  return all;
}

Json parts_json(const std::vector<Partition>& partitions, const sim::ParameterTable& table) {
  Json json = Json::object();
  for (const Partition& by : partitions)
    for (const CalibrationPart& part : by.parts)
      json[by.name].push_back({{"low", part.low}, {"high", part.high}, {"figures", figures_json(table, part.figures)}});
  return json;
}

std::string parts_text(const std::vector<Partition>& partitions) {
  std::string text;
  for (const Partition& by : partitions) {
    text +=
        format("\n| %s | trials | MSE | predicted variance | network | 90%% coverage |\n|---|---|---|---|---|---|\n",
               by.title);
    for (const CalibrationPart& part : by.parts) {
      const ParameterCalibration& all = part.figures.all;
      text += format("| %.3g to %.3g | %d | %.4f | %.4f | %s | %.3f |\n", part.low, part.high, part.figures.trials,
                     all.mse, all.predicted_variance, known_number(all.network_mse, 4).c_str(), all.coverage90);
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
                   known_number(of.network_mse, 4).c_str(), of.coverage50, of.coverage90, of.distance);
  };
  for (std::size_t p = 0; p < table.size(); ++p) line(table[p].name, found.parameters[p]);
  line("all", found.all);
  return text;
}

/// The trials of one calibration: their source, their posteriors and their views.
struct TrialsRun {
  const CalibrateOptions& options;
  const std::vector<sim::Protocol>& protocols;  ///< of the recordings of each person
  const Model& model;
  const Call& call;
  sim::ParameterTable table = protocols.front().ranges();
  sim::Parameters stddev = uniform_stddev(table);  ///< of the trials' prior
  NetworkAnswers network{model, protocols.front()};
  CalibrationTrials source{protocols, options.priors, options.seed};
  Json settings = settings_json(options, protocols);
  Json hash = network.sha256().empty() ? Json(nullptr) : Json(network.sha256());
  std::deque<posterior::Density> densities{};
  std::vector<CalibratedTrial> trials{};

  /// Continues from the trials in the output if the options say so.
  void prepare() {
    if (is_root() && options.resume && path_exists(options.output))
      trials = earlier_trials(options.output, settings, hash, table.size());
    trials = broadcast_value(std::move(trials));  // others need their numbers
    const posterior::Priors priors = posterior::with_conventions(options.priors, table);
    for (const sim::Protocol& one : protocols) densities.emplace_back(one, priors);
    for (CalibratedTrial& trial : trials) {
      source.seek(trial.attempt);
      const CalibrationTrials::Trial again = source.next();
      if (!trial.network) network.answer(again.sway_rad, trial);
    }
  }

  /// Fits up to `max_count` more trials at once. Returns false if it was interrupted.
  bool fit_batch(int max_count) {
    const int processes = ranks() != nullptr ? ranks()->size() : 1;
    // Several trials per thread, because some take far longer. The results do not depend on the number.
    const int at_once = 4 * thread_count() * processes;
    std::vector<CalibrationTrials::Trial> batch;
    for (int i = 0; i < std::min(at_once, max_count); ++i) batch.push_back(source.next());
    std::vector<CalibratedTrial> done(batch.size());
    const bool going = share_out<CalibratedTrial>(
        batch.size(), static_cast<std::size_t>(processes > 1 ? thread_count() : at_once),
        [&](std::size_t first, std::size_t last, const Give<CalibratedTrial>& give) {
          parallel_for(static_cast<int>(last - first), [&](int i) {
            const std::size_t place = first + static_cast<std::size_t>(i);
            if (auto trial = calibrate_trial(densities, batch[place], table, options.settings, interrupted))
              give(place, std::move(*trial));
          });
        },
        [&](std::size_t i, CalibratedTrial trial) { done[i] = std::move(trial); }, interrupted);
    if (!going) return false;
    if (is_root())
      for (std::size_t i = 0; i < batch.size(); ++i) network.answer(batch[i].sway_rad, done[i]);
    trials.insert(trials.end(), done.begin(), done.end());
    return true;
  }

  std::string document() const {
    Json all = Json::array();
    for (const CalibratedTrial& trial : trials) all.push_back(trial_json(trial));
    const bool some = std::ranges::any_of(trials, &CalibratedTrial::agreed);
    return with_call({{"settings", settings},
                      {"network", hash},
                      {"calibration", figures_json(table, compute_calibration(trials, stddev))},
                      {"parts", parts_json(partitions(trials, protocols.front(), stddev), table)},
                      {"agreeing", some ? figures_json(table, calibration_of_agreeing(trials, stddev)) : Json()},
                      {"trials", std::move(all)}},
                     call);
  }

  std::string text(const Calibration& found) const {
    return format(
               "%d trials, chains of %d agree\nBy chance, one parameter's distance from uniform is beyond %.3f "
               "in 5%% of calibrations, the largest beyond %.3f\n\n",
               found.trials, found.agreed, found.band, found.band_of_all) +
           figures_text(table, found) + scores_text(found) + parts_text(partitions(trials, protocols.front(), stddev));
  }
};

/// Fits the trials that the calibration does not have yet, and writes the output after each batch.
void fit_trials(TrialsRun& run) {
  const CalibrateOptions& options = run.options;
  if (const std::size_t done = run.trials.size(); done > static_cast<std::size_t>(options.trials))
    throw Error(Code::setting_conflict, "--trials",
                format("is %d, and %s has %zu trials", options.trials, options.output.c_str(), done),
                format("give --trials %zu or more, or another --output", done));
  ProgressBar bar("calibrate", "trials", options.trials, options.common.quiet);
  if (options.resume)
    bar.line(resuming_text(options.output, run.trials.size(), static_cast<std::size_t>(options.trials), "trials"));
  bar.go_on_from(static_cast<long long>(run.trials.size()));
  for (int left = 0; (left = options.trials - static_cast<int>(run.trials.size())) > 0 && run.fit_batch(left);) {
    if (!options.output.empty() && is_root()) write_file(options.output, run.document());
    bar.update(static_cast<long long>(run.trials.size()));
  }
}

void run_calibrate(const CalibrateOptions& options, const Command& command) {
  std::vector<std::string> inputs;
  std::vector<sim::Protocol> protocols{options.protocol.load(options.common.quiet, &inputs)};
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
  const Model model = model_or_built_in(options.model);
  if (!options.model.empty())
    require_same_experiment(model, options.model, protocols.front(), "protocol " + protocols.front().name);
  TrialsRun run{options, protocols, model, call};
  run.prepare();
  catch_interrupt();
  fit_trials(run);
  if (!is_root()) return;
  if (run.trials.empty()) throw std::runtime_error("stopped before the first trial was done");
  const Calibration found = compute_calibration(run.trials, run.stddev);
  std::cout << (options.common.json ? run.document() : run.text(found));
  if (!options.figure.empty()) write_file(options.figure, calibration_figure(run.table, run.trials, found.band_of_all));
  if (interrupted())
    throw std::runtime_error(format("stopped after %zu of %d trials%s", run.trials.size(), options.trials,
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
                     "Measure each recording artefact of this protocol alone, then all together");
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
  command.add_flag("--resume", options->resume, "Continue with the trials in the output file").unrecorded();
  command.footer(
      "Examples:\n"
      "  decid calibrate --trials 300 --sensor-noise 0.02 -o calibration.json\n"
      "  decid calibrate --trials 40 --sensor-noise 0.02 --with default --with default\n"
      "  decid calibrate --conditions examples/laboratory.json --sensor-noise 0.02 --trials 60\n"
      "  decid calibrate --faults --sensor-noise 0.02 --trials 60 -o artefacts.json --resume");
  run_with(command, options, true, run_calibrate_or_conditions);
}

}  // namespace decid::tools
