// The options of decid train: see train_options.hpp.
#include "tools/decid/commands/train/train_options.hpp"

#include "base/files/file.hpp"
#include "base/text.hpp"
#include "dataset/image/image.hpp"
#include "identify/network/head.hpp"
#include "identify/training/presets.hpp"
#include "nn/training/schedule.hpp"

namespace decid::tools {

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
  settings.head = &chosen_head(preset.head, "--head");
  settings.seed = options.seed;
  settings.patience = options.patience;
  settings.average = options.average;
  settings.scaling_trials = options.stream ? 2000 : 0;
  return settings;
}

void add_train_options(const Command& command, TrainOptions& options) {
  command.section("Trials");
  const Option data = command.add_option("--data", options.data, "Train on this data set of decid dataset");
  command.add_flag("--stream", options.stream, "Simulate new trials for every epoch instead of reading a data set")
      .excludes(data);
  add_protocol_options(command, options.protocol);
  command.add_option("--stream-trials", options.stream_trials, "Simulate this many trials per epoch, with --stream")
      .range(16, 100'000'000);
  command
      .add_option("--validation-trials", options.validation_trials,
                  "Simulate this many validation trials, with --stream")
      .range(1, 1'000'000);
  command.section("Network and training");
  const std::string names = joined(presets(), "; ", [](const Preset& p) { return p.name + ": " + p.description; });
  command.add_option("--preset", options.preset,
                     "Use the network, input and training settings of this preset. " + names);
  command.add_option("--architecture", options.architecture_file,
                     "Use the layers in this text file, one per line, for example conv 32 3x3 stride 2x2 pad 1x1");
  command.add_option("--head", options.head,
                     "Interpret the outputs as point, the parameters, or 'mixture N', a density of N Gaussians; "
                     "default: the preset's");
  command.add_option("--image", options.image_file,
                     "Use the network input settings in this JSON file, as decid info MODEL --json shows them");
  command.add_option("--epochs", options.epochs, "Pass this many times over the training trials; default: the preset's")
      .range(1, 1'000'000);
  command
      .add_option("--patience", options.patience,
                  "Stop after this many epochs without a better validation error and keep the best epoch; default: "
                  "train all epochs and keep the last")
      .range(1, 1'000'000);
  command.add_option("--batch", options.batch, "Use this many samples per step; default: the preset's").range(1, 4096);
  command.add_option("--lr", options.learning_rate, "Set the learning rate; default: the preset's").range(1e-12, 1e3);
  command.add_option("--momentum", options.momentum, "Set the momentum; default: the preset's").range(0.0, 0.9999);
  command
      .add_option("--weight-decay", options.weight_decay,
                  "Set the L2 regularisation of the weights; default: the preset's")
      .range(0.0, 1.0);
  command.add_option("--schedule", options.schedule,
                     "Set the learning-rate schedule: constant, cosine or step:EPOCHS:FACTOR; default: the preset's");
  command
      .add_option("--average", options.average,
                  "Give the model the exponential moving average of its weights, with this decay per step, for example "
                  "0.99; default: the weights of the last step")
      .range(0.0, 0.999999);
  add_seed_option(command, options.seed, "Seed the weights, the shuffling and, with --stream, the trials");
  command.add_option("--from", options.from,
                     "Start with the weights and scalings of this model file, which has the same architecture, head "
                     "and network input");
  command.section("Output");
  command
      .add_flag("--resume", options.resume,
                "Continue a stopped training, or a finished one with more --epochs; fails if there is none")
      .unrecorded();  // the JSON has the extensions to more epochs
  command
      .add_flag("--stop-at-usr1", options.usr1,
                "Also stop with a checkpoint at SIGUSR1, which a cluster may send before the time limit")
      .unrecorded();
  add_output_option(command, "--report", options.report, Written::html,
                    "Update this HTML page after each epoch: training and validation error");
  add_output_option(
      command, "-o,--output", options.output, Written::safetensors,
      "Write this model file (.safetensors); until it is done, OUTPUT.checkpoint holds the state to resume from")
      .required();
  command.footer(
      "Examples:\n"
      "  decid train --data data.npz --preset best -o model.safetensors\n"
      "  decid train --stream --preset series --protocol mine.json --sensor-noise 0.001 0.1 -o mine.safetensors\n"
      "  decid train --stream --preset series --epochs 80 --resume -o mine.safetensors");
}

}  // namespace decid::tools
