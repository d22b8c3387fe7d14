// decid train: a model from a data set, or from trials simulated on the fly.
#include <sys/resource.h>

#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>

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

namespace decid::tools {
namespace {

struct TrainOptions {
  CommonOptions common;
  std::string data, preset = "best", architecture_file, image_file, output;
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

double peak_memory_mb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

void train(const TrainOptions& options) {
  if (options.data.empty() != options.stream)
    throw Error("train", "needs trials", "give either --data data.npz or --stream");
  const std::string checkpoint = options.output + ".checkpoint";
  const std::string log_path = options.output + ".log.csv";
  const std::string best_path = options.output + ".best";  // with patience: the model of the best epoch so far
  std::vector<std::string> files{options.data, options.architecture_file, options.image_file};
  const sim::Protocol protocol = options.stream ? options.protocol.load(&files) : sim::default_protocol();
  for (const std::string& path : {options.output, checkpoint, log_path, best_path}) refuse_same_file(path, files);
  // Reports unwritable places before the work, not after.
  for (const std::string& path : {options.output, checkpoint, log_path}) PendingFile probe(path);
  TrainingSettings settings = settings_from(options);
  const std::unique_ptr<dataset::TrialSource> source =
      options.stream ? dataset::stream_source(protocol, options.seed, options.stream_trials, options.validation_trials)
                     : dataset::stored_source(dataset::StoredDataset(options.data));
  if (options.image_file.empty()) settings.preset.image = image_for(settings.preset, source->protocol());
  const Origin origin = origin_of(settings, *source, std::string("decid ") + version);
  TrainingState state = options.resume ? load_checkpoint(checkpoint, origin, settings.preset.image, source->protocol())
                                       : start_training(*source, settings);
  state.model.origin = origin;
  Model& model = state.model;
  const double half_the_sum = 0.5 * static_cast<double>(model.parameters().size());  // MATLAB's loss over the MSE

  const Preset& preset = settings.preset;
  const int trials = source->trials(dataset::Part::training);
  const long long total = static_cast<long long>(trials) * (preset.epochs - static_cast<int>(state.log.size()));
  ProgressBar bar("train", "samples", total, options.common.quiet);
  bar.line(format("%s: %zu parameters, %.1f MFLOP a sample; %d training and %d validation trials; kernels %s",
                  preset.name.c_str(), model.network.parameter_count(),
                  static_cast<double>(model.network.flops()) * 1e-6, trials, source->trials(dataset::Part::validation),
                  nn::kernels<float>().name));
  if (!options.resume && std::filesystem::exists(checkpoint))
    bar.line("warning: " + checkpoint +
             " of an earlier training is there; this one replaces it when its first epoch is "
             "done, while --resume would go on from it");
  catch_interrupt();
  long long done_before = 0;
  auto epoch_start = std::chrono::steady_clock::now();
  const bool finished = run_training(
      *source, settings, state,
      [&](int done, int) {
        bar.update(done_before + done);
        return !interrupted();
      },
      [&] {
        done_before += trials;
        const EpochLog& last = state.log.back();
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - epoch_start).count();
        bar.line(
            format("epoch %3d of %d: training MSE %.4f, validation MSE %.4f (MATLAB's loss %.4f); %.0f samples/s, "
                   "peak memory %.0f MB",
                   last.epoch, preset.epochs, last.training_mse, last.validation_mse,
                   half_the_sum * last.validation_mse, trials / seconds, peak_memory_mb()));
        // The best one first, so that a checkpoint never lacks it; after a kill in between it is made anew, with the
        // same bits.
        if (settings.patience > 0 && best_epoch(state.log) == last.epoch) write_file(best_path, to_bytes(model));
        write_file(checkpoint, checkpoint_bytes(state));
        write_file(log_path, log_csv(state.log, model.parameters().size()));
        epoch_start = std::chrono::steady_clock::now();
      });
  const auto stop = [&] {
    throw std::runtime_error(state.log.empty() ? "stopped before the first epoch was done; nothing was written"
                                               : "stopped; the same command with --resume goes on after epoch " +
                                                     std::to_string(state.log.size()) + " (" + checkpoint + ")");
  };
  if (!finished) stop();
  const bool early = settings.patience > 0;
  if (early) {
    state.model = load_model(best_path);
    if (state.model.origin != origin)
      throw Error(best_path, "was made with other settings: " + difference(state.model.origin, origin),
                  "train without --resume");
  }
  model.familiarity = learn_familiarity(model, *source, preset.epochs);
  if (interrupted()) stop();
  model.recalibration = learn_recalibration(model, *source, preset.epochs);
  if (interrupted()) stop();
  write_file(options.output, to_bytes(model));
  for (const std::string& path : {checkpoint, best_path}) std::filesystem::remove(path);
  const EpochLog& last = early ? state.log.at(static_cast<std::size_t>(best_epoch(state.log)) - 1) : state.log.back();
  if (early)
    bar.line(format("%zu epochs done; kept epoch %d, validation MSE %.4f", state.log.size(), last.epoch,
                    last.validation_mse));
  bar.line(format("written to %s, log in %s, weights SHA-256 %s", options.output.c_str(), log_path.c_str(),
                  nn::weights_sha256(model.network).c_str()));
  if (!model.familiarity.known())
    bar.line("identify will not recognise unfamiliar recordings: " + why_no_familiarity(model, *source));
  if (model.gives_distribution() && !model.recalibration.known())
    bar.line("fewer than 1000 trials that it was not trained on: how sure the model says it is stays unchecked");
  if (options.common.json)
    std::cout << Json{{"model", options.output},
                      {"epochs", state.log.size()},
                      {"kept_epoch", last.epoch},
                      {"training_mse", last.training_mse},
                      {"validation_mse", last.validation_mse},
                      {"validation_matlab_loss", half_the_sum * last.validation_mse},
                      {"weights_sha256", nn::weights_sha256(model.network)}}
                     .dump(2)
              << '\n';
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
  command.add_flag("--resume", options->resume, "Go on from the checkpoint that a stopped training left");
  add_output_option(command, "-o,--output", options->output, Written::safetensors, "Model file to write (.safetensors)")
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
