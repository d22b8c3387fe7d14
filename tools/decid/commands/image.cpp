// decid image: a data set's trials as a network sees them, for NumPy and other engines.
#include <memory>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "dataset/image/image_object.hpp"
#include "dataset/npz/arrays.hpp"
#include "identify/network/for_body.hpp"
#include "identify/training/training.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/progress.hpp"

namespace decid::tools {
namespace {

struct ImageOptions {
  CommonOptions common;
  std::string data, model, preset, image_file, output;
};

/// Returns the model for the trials: a file's, the built-in one, or the initial model of a training on these trials.
Model viewer(const ImageOptions& options, const dataset::StoredDataset& stored) {
  if (options.preset.empty() && options.image_file.empty()) return model_or_built_in(options.model);
  TrainingSettings settings;
  settings.preset = preset_named(options.preset.empty() ? "best" : options.preset);
  settings.head = &head_named(settings.preset.head, "--preset");
  if (options.image_file.empty())
    settings.preset.image = image_for(settings.preset, stored.about().protocol);
  else
    settings.preset.image =
        dataset::image_settings_from_json(read_file(options.image_file, 1 << 20), options.image_file);
  // Images need no network; this one takes every shape.
  settings.preset.architecture =
      format("globalavgpool; fc %zu", settings.head->outputs(stored.about().protocol.parameters().size()));
  return start_training(*dataset::stored_source(stored), settings).model;
}

std::string description(const ImageOptions& options, const Model& model) {
  const bool fresh = !options.preset.empty() || !options.image_file.empty();
  const auto list = [](const sim::Parameters& values) { return std::vector<double>(values.begin(), values.end()); };
  return print_json({{"program", std::string("decid ") + version},
                     {"model", fresh ? Json() : Json(model_name(options.model))},
                     {"image", dataset::to_json_object(model.image())},
                     {"parameters", model.parameters().names()},
                     {"targets", {{"mean", list(model.targets.mean)}, {"deviation", list(model.targets.stddev)}}}});
}

void write_images(const ImageOptions& options, const Model& model, const dataset::StoredDataset& stored,
                  dataset::ArrayWriter& writer) {
  const dataset::Dataset& data = stored.about();
  const ForBody body = for_trials(model, model_name(options.model), data.protocol, options.data);
  const auto trials = static_cast<std::size_t>(data.trials());
  const dataset::ImageShape shape = model.images().shape();
  const auto extent = [](int count) { return static_cast<std::size_t>(count); };
  writer.begin<float>("images", {trials, extent(shape.channels), extent(shape.rows), extent(shape.columns)});
  ProgressBar bar("image", "trials", data.trials(), options.common.quiet);
  const auto values = static_cast<std::size_t>(shape.size());
  const int at_once = static_cast<int>(std::clamp(std::size_t{8 << 20} / values, std::size_t{1}, std::size_t{1024}));
  std::vector<float> images;
  for (int first = 0; first < data.trials(); first += at_once) {
    const int count = std::min(at_once, data.trials() - first);
    images.resize(static_cast<std::size_t>(count) * values);
    const auto produce = [&](const dataset::SwaySink& take) {
      stored.take(first, count, [&](std::size_t i, std::span<const float> sway) { take(i, {sway, body.height}); });
    };
    dataset::encode_all(model.encoding(), produce, images);
    writer.write(std::span<const float>(images));
    bar.update(first + count);
  }
  const std::size_t parameters = model.parameters().size();
  writer.begin<float>("targets", {trials, parameters});
  for (const sim::Parameters& of_trial : data.parameters)
    writer.write(std::span<const float>(model.targets.scale(body.to_model(model, of_trial))));
  writer.begin<double>("parameters", {trials, parameters});
  for (const sim::Parameters& of_trial : data.parameters)
    writer.write(std::span<const double>(of_trial.begin(), of_trial.end()));
  writer.begin<std::uint8_t>("split", {trials});
  writer.write(std::span<const std::uint8_t>(data.split));
  if (!model.rows.mean.empty()) {
    const std::vector<std::size_t> rows{extent(shape.channels), extent(shape.rows)};
    writer.begin<float>("row_mean", rows);
    writer.write(std::span<const float>(model.rows.mean));
    writer.begin<float>("row_deviation", rows);
    writer.write(std::span<const float>(model.rows.stddev));
  }
  writer.add_text("decid.json", description(options, model));
  writer.commit();
  bar.line(format("%s of %d x %d x %d written to %s", counted(data.trials(), "image").c_str(), shape.channels,
                  shape.rows, shape.columns, options.output.c_str()));
}

void make_images(const ImageOptions& options) {
  if (!options.model.empty() && !(options.preset.empty() && options.image_file.empty()))
    throw Error(Code::setting_conflict, "--model", "has images of its own",
                "leave out --preset and --image, or give them without --model");
  refuse_same_file(options.output, {options.data, options.model, options.image_file});
  dataset::ArrayWriter writer(options.output);  // reports an unwritable place before the work, not after
  const dataset::StoredDataset stored(options.data);
  write_images(options, viewer(options, stored), stored, writer);
}

}  // namespace

void add_image(const Command& program) {
  auto options = std::make_shared<ImageOptions>();
  const Command command = program.add_subcommand("image", "Write a data set's trials as network input");
  command.section("Input");
  command.add_option("data", options->data, "Convert this data set of decid dataset").required();
  command.add_option("--model", options->model, "Use this model file; default: the built-in model");
  command.add_option("--preset", options->preset,
                     "Use the network input of this preset of decid train instead of a model's, scaled as training on "
                     "this data set would");
  command.add_option("--image", options->image_file,
                     "Use the network input settings in this JSON file instead of the preset's");
  add_output_option(command, "-o,--output", options->output, Written::npz,
                    "Write this .npz file: images (trials x channels x rows x columns, float32), targets (z-scored), "
                    "parameters, split")
      .required();
  command.footer(
      "Examples:\n"
      "  decid image data.npz -o images.npz\n"
      "  decid image data.npz --model mine.safetensors -o images.npz\n"
      "  decid image data.npz --preset best -o images.npz");
  run_with(command, options, false, make_images);
}

}  // namespace decid::tools
