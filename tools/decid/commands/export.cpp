// decid export: a model as C files for a firmware, or as ONNX, and sway as their input. export_controller.cpp has the
// controller.
#include "tools/decid/commands/export.hpp"

#include <bit>
#include <cctype>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/files/sha256.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "nn/predictor.hpp"
#include "recording/recording.hpp"
#include "recording/trial.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/network_alone.hpp"
#include "tools/decid/recording_flags.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/firmware/c_text.hpp"
#include "tools/firmware/quantise.hpp"
#include "tools/firmware/text.hpp"
#include "tools/onnx/onnx.hpp"
#include "tools/report/json/recording_json.hpp"

namespace decid::tools {
namespace {

namespace fs = std::filesystem;

struct ExportOptions {
  CommonOptions common;
  Call call = {};  ///< for the JSON
  std::string model, output, name;
  BodyFlags body;
  FirmwareOptions firmware;
};

/// Throws Error as write_exported() does.
void refuse_other_kind(const fs::path& stem, const std::string& name, ExportedKind kind) {
  const std::string other =
      name + "_self_test(" + (kind == ExportedKind::model ? name + "_state" : std::string("void"));
  for (const char* ending : {".h", ".c"}) {
    const std::string path = stem.string() + ending;
    if (fs::is_regular_file(path) && read_file(path).find(other) != std::string::npos)
      throw Error(Code::file_exists, path,
                  kind == ExportedKind::model ? "is a controller, which a model would replace"
                                              : "is a model, which a controller would replace",
                  "give another --name or folder");
  }
}

/// Returns the model file's name as an identifier.
std::string full_name(const std::string& model) {
  std::string name = model.empty() ? "decid_model" : fs::path(model).stem().string();
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  if (name.empty() || std::isalpha(static_cast<unsigned char>(name.front())) == 0 || is_c_header(name))
    name = "model_" + name;
  return name;
}

/// Returns the outputs that decid itself computes for the self-test's sway, with identify's network.
TestVector test_vector(const Model& model, const ForBody& body, const FirmwarePlan& plan) {
  TestVector test;
  std::vector<float> image(static_cast<std::size_t>(model.images().shape().size()));
  const std::vector<float> sway = test_sway(model.protocol.samples());
  model.make_input(dataset::Sway(sway, body.height), image);
  test.outputs.resize(static_cast<std::size_t>(model.network.output_shape().size()));
  if (plan.options.int8) {
    test.outputs = run_plan(plan, image);
  } else {
    nn::Predictor predictor(model.network, 1);
    std::vector<float> features(static_cast<std::size_t>(predictor.feature_count()));
    predictor.run(image, test.outputs, features);
    if (plan.options.ood_score) test.distance = model.ood_detector.distance(features) / model.ood_detector.usual;
  }
  for (const double value : body.from_model(model, model.decode(test.outputs)))
    test.parameters.push_back(static_cast<float>(value));
  if (const auto found = model.distribution(test.outputs, body.ranges))
    for (int p = 0; p < static_cast<int>(found->parameters()); ++p)
      test.stddevs.push_back(static_cast<float>(found->stddev(p)));
  return test;
}

/// Writes the files, and prints what was written; more: the JSON's keys between the sizes and the hash; rest: the text
/// behind the sizes.
void write_model(const ExportOptions& options, const std::string& name, const FirmwareFiles& files,
                 const FirmwarePlan& plan, const Json& more, const std::string& hash, const std::string& rest) {
  write_exported(options.output, name, ExportedKind::model, files);
  if (options.common.json) {
    Json json = written_json(name, files);
    json.update({{"weight_bytes", plan.weight_bytes()}, {"arena_bytes", plan.arena.bytes}});
    json.update(more);
    json["weights_sha256"] = hash;
    add_call(json, options.call);
    std::cout << print_json(json) << '\n';
  } else if (!options.common.quiet) {
    std::cout << format("%s.h and %s.c written to %s\n%lld bytes of weights, %lld of arena", name.c_str(), name.c_str(),
                        options.output.c_str(), plan.weight_bytes(), plan.arena.bytes)
              << rest << '\n';
  }
}

/// Exports a network without protocol, image and head: from its input to its outputs.
void export_alone(const ExportOptions& options, const nn::Network<float>& network, const std::string& name) {
  if (options.firmware.incremental || options.firmware.int8 || options.firmware.ood_score || options.body.mass_kg)
    throw Error(Code::setting_conflict, options.model,
                "is a network without a model, so --incremental, --int8, --ood-score and --mass cannot be used",
                "leave them out, or give a model");
  const std::string hash = nn::weights_sha256(network);
  const std::string origin = format("Made by decid %s from %s, weights SHA-256\n   %s.", version,
                                    comment(fs::path(options.model).filename()).c_str(), hash.c_str());
  const FirmwarePlan plan = plan_network(network);
  write_model(options, name, network_files(network, plan, name, origin), plan, Json::object(), hash, "");
}

void export_model(ExportOptions options, const Command& command) {
  const std::string name = options.name.empty() ? full_name(options.model) : options.name;
  check_firmware_name(name);
  if (options.common.json) options.call = record_call(command, {options.model}, {options.model});
  if (const std::optional<NetworkAlone> alone = network_alone(options.model))
    return export_alone(options, alone->network, name);
  const Model model = model_or_built_in(options.model);
  const ForBody body = for_body(model, model_name(options.model), options.body.body());
  FirmwarePlan plan = plan_firmware(model, options.firmware);
  if (options.firmware.int8) quantise(plan, model);
  const TestVector test = test_vector(model, body, plan);
  const std::string hash = nn::weights_sha256(model.network);
  const std::string origin =
      format("Made by decid %s from %s, weights SHA-256\n   %s%s%s.", version,
             options.model.empty() ? "its built-in model" : comment(fs::path(options.model).filename()).c_str(),
             hash.c_str(), options.firmware.int8 ? ", in 8-bit integers" : "",
             options.body.mass_kg
                 ? format(", for a body of %g kg and %g m", *options.body.mass_kg, *options.body.height_m).c_str()
                 : "");
  std::string rest = format("; all feature maps whole: %lld", plan.whole_map_bytes());
  if (plan.options.ood_score)
    rest += format("\n%lld bytes more for the feature distance of a trial", ood_score_bytes(model, plan));
  write_model(options, name, firmware_files(model, body, plan, test, name, origin), plan,
              {{"whole_map_bytes", plan.whole_map_bytes()},
               {"ood_score_bytes", ood_score_bytes(model, plan)},
               {"body", body_json(body.protocol.experiment.body, body.assumed)},
               {"lines", plan.stream_rows ? "rows" : "columns"},
               {"protocol", model.protocol.name}},
              hash, rest);
}

void add_export_c(const Command& parent) {
  auto options = std::make_shared<ExportOptions>();
  const Command command = parent.add_subcommand("c", "Write a model as one C file and its header");
  command
      .add_option("model", options->model,
                  "Export this file of a model, or of a network only; default: the built-in model")
      .unrecorded();
  add_output_option(command, "-o,--output", options->output, Written::folder,
                    "Write NAME.c and NAME.h to this folder, created if missing")
      .required();
  command.section("Output");
  command.add_option("--name", options->name, "Name the files and functions; default: the model file's name");
  command.add_flag("--incremental", options->firmware.incremental,
                   "Add functions that take samples as they arrive and spread the work");
  command.add_flag("--int8", options->firmware.int8, "Store weights and activations as 8-bit integers");
  command.add_flag("--ood-score,--familiarity", options->firmware.ood_score,
                   "Add a function that scores how far a trial is from the training trials");
  add_body_options(command, options->body);
  command.footer(
      "Examples:\n"
      "  decid export c models/firmware.safetensors -o firmware\n"
      "  decid export c models/firmware.safetensors --incremental -o firmware\n"
      "  decid export c models/firmware.safetensors --int8 --name sway -o firmware");
  run_with(command, options, true, export_model);
}

struct SwayOptions {
  CommonOptions common;
  RecordingFlags recordings;
  std::string model, output;
};

void export_sway(SwayOptions options) {
  ReadOptions reading = options.recordings.read_options();
  reading.body = options.recordings.body();
  options.recordings.find_sources({options.model}, {options.output}, options.common.quiet);
  std::vector<std::string> inputs = options.recordings.distinct_files();
  inputs.push_back(options.model);
  refuse_same_file(options.output, inputs);
  const Model model = model_or_built_in(options.model);
  std::string bytes;
  for (const RecordingResult& id : read_recordings(model.protocol, options.recordings.sources, reading)) {
    if (id.error) throw Error(*id.error);
    const std::vector<float>& sway_rad = id.trial.sway_rad();
    static_assert(std::endian::native == std::endian::little);
    bytes.append(reinterpret_cast<const char*>(sway_rad.data()), sway_rad.size() * sizeof(float));
    for (const Warning& warning : id.warnings) std::cerr << id.file << ": " << warning.text << '\n';
  }
  write_file(options.output, bytes);
  if (!options.common.quiet)
    std::cerr << format("%s of %d samples, float32, rad, written to %s\n",
                        counted(std::ssize(options.recordings.files), "trial").c_str(), model.protocol.samples(),
                        options.output.c_str());
}

void add_export_sway(const Command& parent) {
  auto options = std::make_shared<SwayOptions>();
  const Command command = parent.add_subcommand(
      "sway", "Write recordings as firmware input: float32 in rad at the model's rate, little-endian");
  add_recording_flags(command, options->recordings).required();
  add_body_options(command, options->recordings);
  command.section("Model");
  command.add_option("--model", options->model,
                     "Use the rate and protocol of this model file; default: the built-in model");
  add_output_option(command, "-o,--output", options->output, Written::samples, "Write the samples to this file")
      .required();
  command.footer(
      "Examples:\n"
      "  decid export sway trial.csv -o sway.bin\n"
      "  decid export sway trial.csv --model models/firmware.safetensors -o sway.bin\n"
      "  decid export sway trial.csv --column COM_x --unit rad -o sway.bin\n"
      "  decid export sway trial.c3d --hip HIP_x --shoulder ACROMION_x --mass 70 --height 1.75 -o sway.bin");
  run_with(command, options, false, export_sway);
}

struct OnnxOptions {
  CommonOptions common;
  std::string model, output;
};

void export_onnx(const OnnxOptions& options) {
  refuse_same_file(options.output, {options.model});
  if (const std::optional<NetworkAlone> alone = network_alone(options.model)) {
    write_file(options.output, onnx_bytes(alone->network));
    if (!options.common.quiet)
      std::cerr << format("the network of %s, to %d outputs, written to %s\n", options.model.c_str(),
                          alone->network.output_shape().size(), options.output.c_str());
    return;
  }
  const Model model = model_or_built_in(options.model);
  write_file(options.output, onnx_bytes(model));
  const nn::Shape in = model.network.input_shape();
  if (!options.common.quiet)
    std::cerr << format("the network of %s, from images of %d x %d x %d to %d outputs (%s), written to %s\n",
                        model_name(options.model).c_str(), in.channels, in.rows, in.columns,
                        model.network.output_shape().channels, model.head->name().c_str(), options.output.c_str());
}

void add_export_onnx(const Command& parent) {
  auto options = std::make_shared<OnnxOptions>();
  const Command command =
      parent.add_subcommand("onnx", "Write a model's network as ONNX: its inputs are the arrays of decid image");
  command.add_option("model", options->model,
                     "Export this file of a model, or of a network only; default: the built-in model");
  add_output_option(command, "-o,--output", options->output, Written::onnx, "Write this file (.onnx)").required();
  command.footer(
      "Examples:\n"
      "  decid export onnx -o model.onnx\n"
      "  decid export onnx mine.safetensors -o mine.onnx\n"
      "  decid export onnx models/ideal.safetensors -o ideal.onnx --quiet");
  run_with(command, options, false, export_onnx);
}

}  // namespace

Json written_json(const std::string& name, const FirmwareFiles& files) {
  return {{"files", {name + ".h", name + ".c"}}, {"files_sha256", {sha256(files.header), sha256(files.source)}}};
}

void write_exported(const std::string& folder, const std::string& name, ExportedKind kind, const FirmwareFiles& files) {
  make_output_folder(folder);
  const fs::path stem = fs::path(folder) / name;
  refuse_other_kind(stem, name, kind);
  PendingFile header(stem.string() + ".h"), source(stem.string() + ".c");
  write_file(header.path(), files.header);
  write_file(source.path(), files.source);
  header.commit();
  source.commit();
}

void add_export(const Command& program) {
  const Command command =
      program.add_subcommand("export", "Write a model or a controller as C for firmware, or a model as ONNX");
  command.require_subcommand();
  command.footer(
      "Examples:\n"
      "  decid export c models/firmware.safetensors -o firmware\n"
      "  decid export controller result.json -o firmware\n"
      "  decid export onnx model.safetensors -o model.onnx");
  add_export_c(command);
  add_export_controller(command);
  add_export_sway(command);
  add_export_onnx(command);
}

}  // namespace decid::tools
