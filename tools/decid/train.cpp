// decid train: a model from a data set, or from trials simulated on the fly.
#include <sys/resource.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include "base/disk_file.hpp"
#include "base/error.hpp"
#include "base/file.hpp"
#include "base/json_object.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "identify/training/checkpoint.hpp"
#include "nn/kernels/kernels.hpp"
#include "nn/schedule.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/interrupt.hpp"
#include "tools/decid/progress.hpp"
#include "tools/report/training_page.hpp"

namespace decid::tools {
namespace {

struct TrainOptions {
  CommonOptions common;
  std::string data, preset = "best", architecture_file, image_file, from, report, output;
  ProtocolOptions protocol;
  bool stream = false, resume = false;
  int stream_trials = 25600, validation_trials = 1000, patience = 0;
  std::uint64_t seed = 1;
  // Unset: the preset's.
  std::optional<std::string> head;
  std::optional<int> epochs, batch;
  std::optional<double> learning_rate, momentum, weight_decay;
  std::optional<std::string> schedule;
};

TrainingSettings settings_from(const TrainOptions& options) {
  TrainingSettings settings;
  settings.preset = preset_named(options.preset);
  Preset& preset = settings.preset;
  if (!options.architecture_file.empty()) preset.architecture = read_file(options.architecture_file, 1 << 20);
  if (!options.image_file.empty())
    preset.image = dataset::image_settings_from_json(read_file(options.image_file, 1 << 20), options.image_file);
  preset.epochs = options.epochs.value_or(preset.epochs);
  preset.batch = options.batch.value_or(preset.batch);
  preset.learning_rate = options.learning_rate.value_or(preset.learning_rate);
  preset.sgd.momentum = options.momentum.value_or(preset.sgd.momentum);
  preset.sgd.weight_decay = options.weight_decay.value_or(preset.sgd.weight_decay);
  preset.schedule = options.schedule.value_or(preset.schedule);
  nn::Schedule(preset.schedule, preset.learning_rate, 1, 1);  // reports a wrong one before the work, not after
  preset.head = options.head.value_or(preset.head);
  settings.head = &head_named(preset.head, "--head");
  settings.seed = options.seed;
  settings.patience = options.patience;
  settings.scaling_trials = options.stream ? 2000 : 0;
  return settings;
}

/// MATLAB's loss over the MSE.
double matlab_factor(const Model& model) {
  return 0.5 * static_cast<double>(model.parameters().size());
}

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

/// The files of a training: the model and what lies beside it.
struct TrainFiles {
  explicit TrainFiles(const std::string& output)
      : model(output),
        checkpoint(output + ".checkpoint"),
        log(output + ".log.csv"),
        best(output + ".best"),
        lock(output + ".lock") {}
  std::string model, checkpoint, log;
  std::string best;  ///< with patience: the model of the best epoch so far
  std::string lock;

  std::array<std::string, 5> all() const { return {model, checkpoint, log, best, lock}; }
};

/// Held while a training of that output runs: another one would write the same files.
class OutputLock {
 public:
  explicit OutputLock(const TrainFiles& files) : file_(files.lock, DiskFile::Access::write) {
    if (!file_.try_lock() || !file_.is_still_at_its_path())
      throw Error(files.model, "is being trained by another decid", "wait for it, or choose another output (-o)");
  }
  ~OutputLock() {
    std::error_code ignored;
    std::filesystem::remove(file_.path(), ignored);
  }
  OutputLock(const OutputLock&) = delete;
  OutputLock& operator=(const OutputLock&) = delete;

 private:
  DiskFile file_;
};

/// What files held before the work, to be put back if that turns out to be worth nothing.
class Before {
 public:
  explicit Before(const std::vector<std::string>& paths) {
    for (const std::string& path : paths)
      if (!path.empty())
        files_.emplace_back(path, std::filesystem::exists(path) ? std::optional(read_file(path)) : std::nullopt);
  }
  void put_back() const {
    for (const auto& [path, bytes] : files_) {
      if (bytes)
        write_file(path, *bytes);
      else
        std::filesystem::remove(path);
    }
  }

 private:
  std::vector<std::pair<std::string, std::optional<std::string>>> files_;
};

/// What is there already of the training, from a checkpoint or a finished model; nothing if it is to begin. Throws
/// Error if it would overwrite those of another one.
std::optional<FinishedTraining> begun(const TrainFiles& files, TrainingRequest request) {
  const bool finished = std::filesystem::exists(files.model);
  if (std::filesystem::exists(files.checkpoint) || (request.more_epochs && !finished)) {
    FinishedTraining unfinished{load_checkpoint(files.checkpoint, request), false};
    request.more_epochs = true;  // the model is one for fewer epochs then, from which this training goes on
    if (finished) static_cast<void>(load_finished(files.model, request));
    return unfinished;
  }
  if (finished) return load_finished(files.model, request);
  return std::nullopt;
}

/// The epoch whose model is kept.
const EpochLog& kept_epoch(const std::vector<EpochLog>& log, int patience) {
  return patience > 0 ? log.at(static_cast<std::size_t>(best_epoch(log)) - 1) : log.back();
}

void print_summary(const TrainOptions& options, const Model& model) {
  Json json{{"model", options.output}, {"weights_sha256", nn::weights_sha256(model.network)}};
  if (!model.log.empty()) {
    const EpochLog& kept = kept_epoch(model.log, options.patience);
    json.update(Json{{"epochs", model.log.size()},
                     {"kept_epoch", kept.epoch},
                     {"training_mse", kept.training_mse},
                     {"validation_mse", kept.validation_mse},
                     {"validation_matlab_loss", matlab_factor(model) * kept.validation_mse}});
  }
  std::cout << json.dump(2) << '\n';
}

void write_report(const TrainOptions& options, const Model& model, const std::vector<EpochLog>& log, bool finished) {
  if (options.report.empty() || log.empty()) return;
  write_file(options.report, training_html({.model = options.output,
                                            .version = version,
                                            .protocol = model.protocol,
                                            .origin = model.origin,
                                            .log = log,
                                            .distribution = model.gives_distribution(),
                                            .finished = finished}));
}

void say_done(const TrainOptions& options, const Model& model) {
  if (!options.common.quiet)
    std::cerr << format(
        "%s is the model of this very training (%zu epochs, weights SHA-256 %s): done, nothing is left to do\n",
        options.output.c_str(), model.log.size(), nn::weights_sha256(model.network).c_str());
  write_report(options, model, model.log, true);
  if (options.common.json) print_summary(options, model);
}

/// Trains what is left, with a line, a checkpoint and a log each epoch. False: it was interrupted.
bool train_epochs(const TrainOptions& options, const TrainingSettings& settings, const dataset::TrialSource& source,
                  TrainingState& state, ProgressBar& bar) {
  const TrainFiles files(options.output);
  const int trials = source.trials(dataset::Part::training);
  const Before before({files.checkpoint, files.log, files.best, options.report});
  if (settings.patience > 0 && !state.log.empty() && !std::filesystem::exists(files.best))
    write_file(files.best, to_bytes(state.model));  // what goes on from a finished model goes on from its best
  long long done_before = 0;
  std::vector<double> validation;  // of the epochs done, for the curve
  for (const EpochLog& e : state.log) validation.push_back(e.validation_mse);
  auto epoch_start = std::chrono::steady_clock::now();
  const auto after_epoch = [&] {
    done_before += trials;
    const EpochLog& last = state.log.back();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - epoch_start).count();
    bar.line(
        format("epoch %3d of %d: training MSE %.4f, validation MSE %.4f (MATLAB's loss %.4f); %.0f samples/s, "
               "peak memory %.0f MB",
               last.epoch, settings.preset.epochs, last.training_mse, last.validation_mse,
               matlab_factor(state.model) * last.validation_mse, trials / seconds, peak_memory_mb()));
    // The best one first, so that a checkpoint never lacks it; after a kill in between it is made anew, with the
    // same bits.
    if (settings.patience > 0 && best_epoch(state.log) == last.epoch) write_file(files.best, to_bytes(state.model));
    write_file(files.checkpoint, checkpoint_bytes(state));
    write_file(files.log, log_csv(state.log, state.model.parameters().size()));
    write_report(options, state.model, state.log, false);
    validation.push_back(last.validation_mse);
    epoch_start = std::chrono::steady_clock::now();
  };
  try {
    return run_training(
        source, settings, state,
        [&](int done, int) {
          const bool drawn = bar.terminal() && !validation.empty();
          bar.update(done_before + done,
                     drawn ? format("validation MSE %.3f ", validation.back()) + curve(validation) : std::string());
          return !interrupted();
        },
        after_epoch);
  } catch (const Diverged&) {
    before.put_back();
    throw;
  }
}

/// The finished model: that of the last epoch or, with patience, of the best one.
Model finished_model(const TrainOptions& options, const TrainingSettings& settings, const dataset::TrialSource& source,
                     TrainingState& state) {
  const TrainFiles files(options.output);
  Model model = std::move(state.model);
  if (settings.patience > 0) {
    Model best = load_model(files.best);
    best.origin.epochs = model.origin.epochs;  // it may be of a training that went on to more of them
    best.origin.extensions = model.origin.extensions;
    if (best.origin != model.origin)
      throw Error(files.best, "was made with other settings: " + difference(best.origin, model.origin),
                  "delete it and " + files.checkpoint + " to begin anew");
    model = std::move(best);
  }
  model.log = std::move(state.log);
  model.familiarity = learn_familiarity(model, source, settings.preset.epochs);
  model.recalibration = learn_recalibration(model, source, settings.preset.epochs);
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
  if (!model.familiarity.known())
    bar.line("identify will not recognise unfamiliar recordings: " + why_no_familiarity(model, source));
  if (model.gives_distribution() && !model.recalibration.known())
    bar.line("fewer than 1000 trials that it was not trained on: how sure the model says it is stays unchecked");
}

void train(const TrainOptions& options) {
  if (options.data.empty() != options.stream)
    throw Error("train", "needs trials", "give either --data data.npz or --stream");
  const TrainFiles files(options.output);
  std::vector<std::string> read{options.data, options.architecture_file, options.image_file, options.from};
  const sim::Protocol protocol = options.stream ? options.protocol.load(&read) : sim::default_protocol();
  for (const std::string& path : files.all()) refuse_same_file(path, read);
  for (const std::string& path : files.all()) read.push_back(path);
  refuse_same_file(options.report, read);
  // Reports unwritable places before the work, not after.
  for (const std::string& path : {files.model, files.checkpoint, files.log, options.report})
    if (!path.empty()) PendingFile probe(path);
  TrainingSettings settings = settings_from(options);
  const OutputLock lock(files);
  const std::unique_ptr<dataset::TrialSource> source =
      options.stream ? dataset::stream_source(protocol, options.seed, options.stream_trials, options.validation_trials)
                     : dataset::stored_source(dataset::StoredDataset(options.data));
  if (options.image_file.empty()) settings.preset.image = image_for(settings.preset, source->protocol());
  const std::optional<Model> from = options.from.empty() ? std::nullopt : std::optional(load_model(options.from));
  std::optional<Origin::Start> start;
  if (from) start = start_from(from->origin, nn::weights_sha256(from->network));
  const Origin origin = origin_of(settings, *source, std::string("decid ") + version, start);
  std::optional<FinishedTraining> there =
      begun(files, {origin, settings.preset.image, source->protocol(), options.resume});
  if (there && there->done) {
    there->state.model.log = there->state.log;
    say_done(options, there->state.model);
    return;
  }
  TrainingState state = there  ? std::move(there->state)
                        : from ? start_training(*source, settings, *from, options.from)
                               : start_training(*source, settings);
  if (!there) state.model.origin = origin;

  const Preset& preset = settings.preset;
  const int trials = source->trials(dataset::Part::training);
  const long long total = static_cast<long long>(trials) * (preset.epochs - static_cast<int>(state.log.size()));
  ProgressBar bar("train", "samples", total, options.common.quiet);
  bar.line(format("%s: %zu parameters, %.1f MFLOP a sample; %d training and %d validation trials; kernels %s",
                  preset.name.c_str(), state.model.network.parameter_count(),
                  static_cast<double>(state.model.network.flops()) * 1e-6, trials,
                  source->trials(dataset::Part::validation), nn::kernels<float>().name));
  if (there) bar.line(format("resuming after epoch %zu of %d", state.log.size(), preset.epochs));
  catch_interrupt();
  const bool finished = train_epochs(options, settings, *source, state, bar);
  const std::size_t epochs = state.log.size();
  const auto stop_if = [&](bool stopped) {
    if (!stopped) return;
    throw std::runtime_error(
        std::filesystem::exists(files.checkpoint)
            ? format("stopped; the same command, with --resume or without, goes on after epoch %zu (%s)", epochs,
                     files.checkpoint.c_str())
            : "stopped before the first epoch was done; nothing was written");
  };
  stop_if(!finished);
  const Model model = finished_model(options, settings, *source, state);
  stop_if(interrupted());
  write_file(options.output, to_bytes(model));
  write_report(options, model, model.log, true);
  for (const std::string& path : {files.checkpoint, files.best}) std::filesystem::remove(path);
  say_finished(options, *source, model, bar);
  if (options.common.json) print_summary(options, model);
}

}  // namespace

void add_train(const Command& program) {
  auto options = std::make_shared<TrainOptions>();
  const Command command = program.add_subcommand("train", "Train a model");
  const Option data = command.add_option("--data", options->data, "Data set made by decid dataset");
  command.add_flag("--stream", options->stream, "Simulate fresh trials for every epoch instead").excludes(data);
  add_protocol_options(command, options->protocol);
  command.add_option("--stream-trials", options->stream_trials, "With --stream: trials an epoch")
      .show_default()
      .range(16, 100'000'000);
  command.add_option("--validation-trials", options->validation_trials, "With --stream: trials for validation")
      .show_default()
      .range(1, 1'000'000);
  std::string names;
  for (const Preset& p : presets()) names += (names.empty() ? "" : "; ") + p.name + ": " + p.description;
  command.add_option("--preset", options->preset, "Network, image and training settings. " + names).show_default();
  command.add_option("--architecture", options->architecture_file,
                     "A text file with other layers, one a line, e.g. "
                     "conv 32 3x3 stride 2x2 pad 1x1");
  command.add_option(
      "--head", options->head,
      "What the outputs mean: point, the parameters; 'mixture N', a distribution over them of N Gaussians, "
      "for 7 parameters 36 outputs each; default: the preset's");
  command.add_option("--image", options->image_file,
                     "A JSON file with other image settings, as decid info MODEL --json shows them");
  command.add_option("--epochs", options->epochs, "Passes over the training trials").range(1, 1'000'000);
  command
      .add_option(
          "--patience", options->patience,
          "Stop after so many epochs in a row without a better validation MSE, and keep the best epoch's model; "
          "default: all epochs, and the last one's model")
      .range(1, 1'000'000);
  command.add_option("--batch", options->batch, "Samples a step").range(1, 4096);
  command.add_option("--lr", options->learning_rate, "Learning rate").range(1e-12, 1e3);
  command.add_option("--momentum", options->momentum, "Momentum").range(0.0, 0.9999);
  command.add_option("--weight-decay", options->weight_decay, "L2 regularisation of the weights").range(0.0, 1.0);
  command.add_option("--schedule", options->schedule, "constant, cosine or step:EPOCHS:FACTOR");
  add_seed_option(command, options->seed, "Seed of weights, shuffling and, with --stream, trials");
  command.add_option("--from", options->from,
                     "A model file of the same architecture, head and image: begin with its weights and scalings "
                     "(fine tuning)");
  command.add_flag(
      "--resume", options->resume,
      "Go on from where a stopped training was, or a finished one to more --epochs; fails if there is none");
  add_output_option(command, "--report", options->report, Written::html,
                    "Page to write anew after each epoch: training and validation error over the epochs (.html)");
  add_output_option(command, "-o,--output", options->output, Written::safetensors,
                    "Model file to write (.safetensors). Meanwhile there is OUTPUT.checkpoint, from which the same "
                    "command goes on; the files of other trainings are not overwritten")
      .required();
  add_common_options(command, options->common, true);
  command.footer("Example: decid train --data data.npz --preset best -o model.safetensors");
  command.callback([options, command] {
    for (const char* name : {"--protocol", "--sensor-noise", "--stream-trials", "--validation-trials"})
      if (!options->stream && command.count(name) > 0)
        throw Error(name, "has no effect on a data set, which was simulated already", "use it with --stream");
    apply(options->common);
    train(*options);
  });
}

}  // namespace decid::tools
