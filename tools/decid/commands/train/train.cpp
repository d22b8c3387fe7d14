// decid train: a model from a data set, or from trials simulated on the fly.
#include <sys/resource.h>

#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <utility>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "identify/training/checkpoint.hpp"
#include "nn/kernels/kernels.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/commands/train/train_files.hpp"
#include "tools/decid/commands/train/train_options.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/json/recording_json.hpp"
#include "tools/report/training_page.hpp"

namespace decid::tools {
namespace {

/// Returns the ratio of MATLAB's loss to the MSE.
double matlab_factor(const Model& model) {
  return 0.5 * static_cast<double>(model.parameters().size());
}

double peak_memory_mb() {
#if defined(__wasm__)
  return static_cast<double>(__builtin_wasm_memory_size(0)) / 16.0;  // pages of 64 KiB
#else
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
#endif
}

/// Returns " and 640 trials" for an epoch that was stopped in its middle.
std::string part_text(const TrainingState& state) {
  return state.part.trials > 0 ? format(" and %d trials", state.part.trials) : std::string();
}

/// Returns the state that a checkpoint or a finished model holds; nothing if the training has not begun. Throws Error
/// if the training would overwrite the files of another training.
std::optional<FinishedTraining> begun(const TrainFiles& files, TrainingRequest request) {
  const bool finished = std::filesystem::exists(files.model);
  const bool has_epoch = std::filesystem::exists(files.checkpoint), has_part = std::filesystem::exists(files.stopped);
  if (request.more_epochs && !finished && !has_epoch && !has_part)
    throw Error(Code::file_missing, "--resume", "finds neither " + files.checkpoint + " nor " + files.model,
                "leave --resume out to begin the training, or give the --output that it had");
  if (has_epoch || has_part) {
    FinishedTraining unfinished{load_checkpoint(!has_epoch && has_part ? files.stopped : files.checkpoint, request),
                                false};
    TrainingState& state = unfinished.state;
    if (has_epoch && has_part) {
      TrainingState later = state_from_bytes(read_file(files.stopped, max_own_file_bytes), files.stopped);
      // Use the later state only if it belongs to the next epoch and no extension to more epochs changed its schedule.
      if (later.model.origin == state.model.origin && later.log == state.log) state = std::move(later);
    }
    request.more_epochs = true;  // the model is one for fewer epochs then, from which this training continues
    if (finished) static_cast<void>(load_finished(files.model, request));
    return unfinished;
  }
  if (finished) return load_finished(files.model, request);
  return std::nullopt;
}

void print_summary(const TrainOptions& options, const Model& model) {
  Json json{{"model", options.output},
            {"weights_sha256", nn::weights_sha256(model.network)},
            {"protocol", model.protocol.name}};
  if (!model.log.empty()) {
    const EpochLog& kept = kept_epoch(model.log, options.patience);
    json.update(Json{{"epochs", model.log.size()},
                     {"kept_epoch", kept.epoch},
                     {"training_mse", kept.training_mse},
                     {"validation_mse", kept.validation_mse},
                     {"validation_matlab_loss", matlab_factor(model) * kept.validation_mse}});
  }
  for (const Origin::Extension& one : model.origin.extensions)
    json["extensions"].push_back({{"after", one.after}, {"planned", one.planned}});
  add_call(json, options.call);
  std::cout << print_json(json) << '\n';
}

void write_report(const TrainOptions& options, const Model& model, const std::vector<EpochLog>& log, bool finished) {
  if (options.report.empty() || log.empty()) return;
  write_file(options.report, training_html({.model = options.output,
                                            .version = version,
                                            .protocol = model.protocol,
                                            .origin = model.origin,
                                            .log = log,
                                            .distribution = model.gives_distribution(),
                                            .finished = finished,
                                            .call = options.call}));
}

void say_done(const TrainOptions& options, const Model& model) {
  if (!options.common.quiet)
    std::cerr << format(
        "%s is already the model of this training (%zu epochs, weights SHA-256 %s): nothing is left to do\n",
        options.output.c_str(), model.log.size(), nn::weights_sha256(model.network).c_str());
  write_report(options, model, model.log, true);
  if (options.common.json) print_summary(options, model);
}

/// Trains the remaining epochs, with a line, a checkpoint and a log each epoch. Returns false if the training was
/// interrupted.
bool train_epochs(const TrainOptions& options, const TrainingSettings& settings, const dataset::TrialSource& source,
                  TrainingState& state, ProgressBar& bar) {
  const TrainFiles files(options.output);
  const int trials = source.trials(dataset::Part::training);
  std::vector<std::string> written = files.of_epochs();
  written.push_back(options.report);
  const Before before(is_root() ? written : std::vector<std::string>());
  if (is_root() && settings.patience > 0 && !state.log.empty() && state.part.trials == 0 &&
      !std::filesystem::exists(files.best))
    write_file(files.best, to_bytes(trained_model(state)));  // a finished model is its best one: continue from it
  long long done_before = 0;
  int part = state.part.trials;    // trials of the first epoch that were done before
  std::vector<double> validation;  // of the epochs done, for the curve
  for (const EpochLog& e : state.log) validation.push_back(e.validation_mse);
  auto epoch_start = std::chrono::steady_clock::now();
  const auto after_epoch = [&] {
    done_before += trials - std::exchange(part, 0);
    const EpochLog& last = state.log.back();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - epoch_start).count();
    bar.line(
        format("epoch %3d of %d: training MSE %.4f, validation MSE %.4f (MATLAB's loss %.4f); %.0f samples/s, "
               "peak memory %.0f MB",
               last.epoch, settings.preset.epochs, last.training_mse, last.validation_mse,
               matlab_factor(state.model) * last.validation_mse, trials / seconds, peak_memory_mb()));
    validation.push_back(last.validation_mse);
    epoch_start = std::chrono::steady_clock::now();
    if (!is_root()) return;
    // Write the best model first, so that no checkpoint lacks it. After a kill in between, decid makes the model again
    // with the same bits.
    if (settings.patience > 0 && best_epoch(state.log) == last.epoch)
      write_file(files.best, to_bytes(trained_model(state)));
    write_file(files.checkpoint, checkpoint_bytes(state));
    std::filesystem::remove(files.stopped);
    write_file(files.log, log_csv(state.log, state.model.parameters().size()));
    write_report(options, state.model, state.log, false);
  };
  try {
    return run_training(
        source, settings, state,
        [&](int done, int) {
          const bool drawn = bar.terminal() && !validation.empty();
          bar.update(done_before + done - part,
                     drawn ? format("validation MSE %.3f ", validation.back()) + curve(validation) : std::string());
          return !interrupted();
        },
        after_epoch);
  } catch (const Diverged&) {
    before.put_back();
    throw;
  }
}

/// Returns the model of the best epoch, at all ranks.
Model load_best(const TrainFiles& files) {
  const std::string bytes =
      broadcast_text(ranks(), is_root() ? read_file(files.best, max_own_file_bytes) : std::string());
  return model_from_bytes(bytes, files.best);
}

/// Returns the finished model: the model of the last epoch or, with patience, of the best epoch.
Model finished_model(const TrainOptions& options, const TrainingSettings& settings, const dataset::TrialSource& source,
                     TrainingState& state) {
  const TrainFiles files(options.output);
  Model model = trained_model(state);
  if (settings.patience > 0) {
    Model best = load_best(files);
    best.origin.epochs = model.origin.epochs;  // it may be of a training that went on to more of them
    best.origin.extensions = model.origin.extensions;
    if (best.origin != model.origin)
      throw Error(Code::file_differs, files.best,
                  "was made with other settings: " + difference(best.origin, model.origin),
                  "delete it and " + files.checkpoint + " to start again");
    model = std::move(best);
  }
  model.log = std::move(state.log);
  model.ood_detector = learn_ood_detector(model, source, settings.preset.epochs, ranks());
  model.recalibration = learn_recalibration(model, source, settings.preset.epochs, ranks());
  return model;
}

void say_finished(const TrainOptions& options, const dataset::TrialSource& source, const Model& model,
                  ProgressBar& bar) {
  const EpochLog& kept = kept_epoch(model.log, options.patience);
  if (options.patience > 0)
    bar.line(format("%zu epochs done; kept epoch %d, validation MSE %.4f", model.log.size(), kept.epoch,
                    kept.validation_mse));
  bar.line(format("written to %s, log in %s, weights SHA-256 %s", options.output.c_str(),
                  TrainFiles(options.output).log.c_str(), nn::weights_sha256(model.network).c_str()));
  if (!model.ood_detector.known()) bar.line("identify gives no OOD score: " + why_no_ood_detector(model, source));
  if (model.gives_distribution() && !model.recalibration.known())
    bar.line("fewer than 1000 trials that it was not trained on: decid did not check the intervals");
}

/// The state in which a training begins, as rank 0 finds it.
struct Beginning {
  std::optional<TrainingState> state;  ///< of other ranks, and of a training that is done: none
  bool resumed = false;
};

Beginning beginning(const TrainOptions& options, const TrainingSettings& settings, const dataset::TrialSource& source,
                    const Origin& origin, const std::optional<Model>& from) {
  std::optional<FinishedTraining> there =
      begun(TrainFiles(options.output), {origin, settings.preset.image, source.protocol(), options.resume});
  if (there && there->done) {
    there->state.model.log = there->state.log;
    say_done(options, there->state.model);
    return {{}, true};
  }
  if (there) return {std::move(there->state), true};
  Beginning fresh{from ? start_training(source, settings, *from, options.from) : start_training(source, settings)};
  fresh.state->model.origin = origin;
  return fresh;
}

/// Rejects files that would be lost and paths that decid cannot write: before the work, not after.
void check_files(const TrainOptions& options, std::vector<std::string> read) {
  const TrainFiles files(options.output);
  for (const std::string& path : files.all()) refuse_same_file(path, read);
  for (const std::string& path : files.all()) read.push_back(path);
  refuse_same_file(options.report, read);
  for (const std::string& path : {files.model, files.checkpoint, files.log, options.report})
    if (!path.empty()) PendingFile probe(path);
}

/// Throws Error unless the trials are a data set's or a stream's, with the options of either.
void check_trials(const TrainOptions& options, const Command& command) {
  for (const char* name : {"--protocol", "--controller", "--sensor-noise", "--stream-trials", "--validation-trials"})
    if (!options.stream && command.count(name) > 0)
      throw Error(Code::setting_conflict, name, "has no effect on a data set, which was simulated already",
                  "use it with --stream");
  if (options.data.empty() != options.stream)
    throw Error(Code::setting_missing, "train", "needs trials", "give either --data data.npz or --stream");
}

/// Fits the preset to the trials: its outputs to their parameters, its network input to their protocol.
void adapt_preset(const TrainOptions& options, const sim::Protocol& protocol, Preset& preset) {
  if (options.architecture_file.empty())
    preset = with_head(preset, preset.head, protocol.parameters().size(), "--head");
  if (options.image_file.empty()) preset.image = image_for(preset, protocol);
}

/// Finds the state in which the training begins, at all ranks. Returns no state if the training is done.
Beginning begin_together(const TrainOptions& options, const TrainingSettings& settings,
                         const dataset::TrialSource& source) {
  const std::optional<Model> from = options.from.empty() ? std::nullopt : std::optional(load_model(options.from));
  std::optional<Origin::Start> start;
  if (from) start = start_from(from->origin, nn::weights_sha256(from->network));
  const Origin origin = make_origin(settings, source, std::string("decid ") + version, start);
  require_same("the training", to_json(origin) + sim::to_json(source.protocol()), "give all hosts the same files");
  Beginning begin = is_root() ? beginning(options, settings, source, origin, from) : Beginning{};
  const std::string how = broadcast_text(ranks(), !begin.state ? "done" : begin.resumed ? "resumed" : "fresh");
  begin.resumed = how == "resumed";
  if (how != "done" && ranks() != nullptr) share_state(*ranks(), begin.state);
  return begin;
}

long long samples_left(const Preset& preset, const dataset::TrialSource& source, const TrainingState& state) {
  const long long trials = source.trials(dataset::Part::training);
  return trials * (preset.epochs - static_cast<int>(state.log.size())) - state.part.trials;
}

/// Returns a line about the network and the trials.
std::string begin_text(const Preset& preset, const dataset::TrialSource& source, const nn::Network<float>& network) {
  return format("%s: %zu parameters, %.1f MFLOP per sample; %d training and %d validation trials; kernels %s",
                preset.name.c_str(), network.parameter_count(), static_cast<double>(network.flops()) * 1e-6,
                source.trials(dataset::Part::training), source.trials(dataset::Part::validation),
                nn::kernels<float>().name);
}

void train(TrainOptions options, const Command& command) {
  check_trials(options, command);
  const TrainFiles files(options.output);
  std::vector<std::string> read{options.data, options.architecture_file, options.image_file, options.from};
  const sim::Protocol protocol =
      options.stream ? options.protocol.load(options.common.quiet, &read) : sim::default_protocol();
  if (is_root()) check_files(options, read);
  if (is_root() && (options.common.json || !options.report.empty())) options.call = record_call(command, read);
  options.call.seed = options.seed;
  TrainingSettings settings = settings_from(options);
  settings.ranks = ranks();
  std::optional<OutputLock> lock;
  if (is_root()) lock.emplace(files);
  const std::unique_ptr<dataset::TrialSource> source =
      options.stream ? dataset::stream_source(protocol, options.seed, options.stream_trials, options.validation_trials)
                     : dataset::stored_source(dataset::StoredDataset(options.data));
  adapt_preset(options, source->protocol(), settings.preset);
  Beginning begin = begin_together(options, settings, *source);
  if (!begin.state) return;
  TrainingState state = std::move(*begin.state);

  const Preset& preset = settings.preset;
  ProgressBar bar("train", "samples", samples_left(preset, *source, state), options.common.quiet);
  bar.line(begin_text(preset, *source, state.model.network));
  if (begin.resumed)
    bar.line(format("resuming after epoch %zu of %d%s", state.log.size(), preset.epochs, part_text(state).c_str()));
  catch_interrupt(options.usr1);
  const bool finished = train_epochs(options, settings, *source, state, bar);
  const std::string where = format("after epoch %zu", state.log.size()) + part_text(state);
  const std::string& kept = state.part.trials > 0 ? files.stopped : files.checkpoint;
  if (!finished && is_root()) write_file(kept, checkpoint_bytes(state));
  const auto stop_if = [&](bool stopped) {
    if (stopped)
      throw std::runtime_error("stopped; the same command, with --resume or without, continues " + where + " (" + kept +
                               ")");
  };
  stop_if(!finished);
  const Model model = finished_model(options, settings, *source, state);
  if (!is_root()) return;
  stop_if(interrupted());
  if (begin.resumed)
    write_file(files.log, log_csv(model.log, model.parameters().size()));  // the last one may have failed
  write_file(options.output, to_bytes(model));
  write_report(options, model, model.log, true);
  for (const std::string& path : {files.checkpoint, files.stopped, files.best}) std::filesystem::remove(path);
  say_finished(options, *source, model, bar);
  if (options.common.json) print_summary(options, model);
}

}  // namespace

void add_train(const Command& program) {
  auto options = std::make_shared<TrainOptions>();
  const Command command = program.add_subcommand("train", "Train a model");
  add_train_options(command, *options);
  run_with(command, options, true, train);
}

}  // namespace decid::tools
