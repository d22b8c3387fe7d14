// decid export: a model, or a controller, as C files for a firmware; a model's network as ONNX.
#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "nn/predictor.hpp"
#include "recording/recording.hpp"
#include "recording/trial.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/network_alone.hpp"
#include "tools/decid/parameter_options.hpp"
#include "tools/decid/recording_flags.hpp"
#include "tools/decid/results/identified.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/firmware/c_text.hpp"
#include "tools/firmware/controller.hpp"
#include "tools/firmware/quantise.hpp"
#include "tools/firmware/text.hpp"
#include "tools/onnx/onnx.hpp"

namespace decid::tools {
namespace {

namespace fs = std::filesystem;

struct ExportOptions {
  CommonOptions common;
  std::string model, output, name;
  BodyFlags body;
  FirmwareOptions firmware;
};

enum class Kind { model, controller };

/// Throws Error if NAME.h or NAME.c is exported C of the other kind, whose self-test takes another argument.
void refuse_other_kind(const fs::path& stem, const std::string& name, Kind kind) {
  const std::string other = name + "_self_test(" + (kind == Kind::model ? name + "_state" : std::string("void"));
  for (const char* ending : {".h", ".c"}) {
    const std::string path = stem.string() + ending;
    if (fs::is_regular_file(path) && read_file(path).find(other) != std::string::npos)
      throw Error(Code::file_exists, path,
                  kind == Kind::model ? "is a controller, which a model would replace"
                                      : "is a model, which a controller would replace",
                  "give another --name or folder");
  }
}

/// Writes the files in a folder, which it creates if it is missing.
void write_files(const std::string& folder, const std::string& name, Kind kind, const FirmwareFiles& files) {
  make_output_folder(folder);
  const fs::path stem = fs::path(folder) / name;
  refuse_other_kind(stem, name, kind);
  PendingFile header(stem.string() + ".h"), source(stem.string() + ".c");
  write_file(header.path(), files.header);
  write_file(source.path(), files.source);
  header.commit();
  source.commit();
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

/// Prints what was written; more: the JSON's keys between the sizes and the hash; rest: the text behind the sizes.
void print_written(const ExportOptions& options, const std::string& name, const FirmwarePlan& plan, const Json& more,
                   const std::string& hash, const std::string& rest) {
  if (options.common.json) {
    Json json{{"files", {name + ".h", name + ".c"}},
              {"weight_bytes", plan.weight_bytes()},
              {"arena_bytes", plan.arena.bytes}};
    json.update(more);
    json["weights_sha256"] = hash;
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
  write_files(options.output, name, Kind::model, network_files(network, plan, name, origin));
  print_written(options, name, plan, Json::object(), hash, "");
}

void export_model(const ExportOptions& options) {
  const std::string name = options.name.empty() ? full_name(options.model) : options.name;
  check_firmware_name(name);
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
  write_files(options.output, name, Kind::model, firmware_files(model, body, plan, test, name, origin));
  std::string rest = format("; all feature maps whole: %lld", plan.whole_map_bytes());
  if (plan.options.ood_score)
    rest += format("\n%lld bytes more for the feature distance of a trial", ood_score_bytes(model, plan));
  print_written(options, name, plan,
                {{"whole_map_bytes", plan.whole_map_bytes()},
                 {"ood_score_bytes", ood_score_bytes(model, plan)},
                 {"body", body_json(body.protocol.experiment.body, body.assumed)},
                 {"lines", plan.stream_rows ? "rows" : "columns"}},
                hash, rest);
}

void add_export_c(const Command& parent) {
  auto options = std::make_shared<ExportOptions>();
  const Command command = parent.add_subcommand("c", "Write a model as one C file and its header");
  command.add_option("model", options->model,
                     "Export this file of a model, or of a network only; default: the built-in model");
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

struct ControllerOptions {
  CommonOptions common;
  std::string result, output, name = "decid_controller", protocol = "default", scale_to, controller;
  std::optional<double> mass_kg, com_height_m, inertia_kgm2;
  double step_s = sim::integration_step_s;
  int recording = 1;
  bool force = false, names_protocol = false;
  ParameterOptions parameters;
};

std::string shown(const sim::Body& body) {
  return format("%.4g kg at %.4g m (m g h %.4g N m/rad)", body.mass_kg, body.com_height_m, body.mgh());
}

/// Returns true if two bodies agree to 0.1%: the user may have typed rounded values that decid printed.
bool are_one_body(const sim::Body& a, const sim::Body& b) {
  const auto near = [](double x, double y) { return std::abs(x - y) <= 1e-3 * y; };
  return near(a.mass_kg, b.mass_kg) && near(a.com_height_m, b.com_height_m) && near(a.inertia_kgm2, b.inertia_kgm2);
}

/// Returns the body of --mass, --com-height and --inertia, if they were given. `like`: the body whose build it has if
/// there is no inertia.
std::optional<sim::Body> given_body(const ControllerOptions& options, const sim::Body& like) {
  if (options.mass_kg.has_value() != options.com_height_m.has_value() || (options.inertia_kgm2 && !options.mass_kg))
    throw Error(Code::setting_missing, "export controller", "has an incomplete body",
                "give --mass and --com-height together, and --inertia with both or not at all");
  if (!options.mass_kg) return {};
  const double mass = *options.mass_kg, height = *options.com_height_m;
  const double per_mass = like.inertia_kgm2 / (like.mass_kg * like.com_height_m * like.com_height_m);
  return sim::Body{mass, height, options.inertia_kgm2.value_or(per_mass * mass * height * height)};
}

/// Returns the controller's protocol: its controller, its tilt, and the body for which decid exports the gains. `from`:
/// the body of the gains so far. This is the result's body, nothing if nobody gave it, or the default body without a
/// result.
sim::Protocol controller_protocol(const ControllerOptions& options, const std::optional<sim::Body>& from,
                                  const std::string& controller) {
  const bool scales = !options.scale_to.empty(), is_result = !options.result.empty();
  sim::Protocol protocol =
      read_protocol(scales ? options.scale_to : options.protocol, options.common.quiet, nullptr, controller);
  sim::Body& body = protocol.experiment.body;
  const std::optional<sim::Body> given = given_body(options, from.value_or(sim::Body{}));
  const auto refuse_unknown = [&] {
    throw Error(Code::setting_missing, options.result, "does not say whose body its gains are for",
                "identify the recording again with --mass and --height, or fit it with a --protocol that has the body");
  };
  if (!from && (scales || (!given && !are_one_body(body, sim::Body{})))) refuse_unknown();
  if (given) {
    body = *given;
  } else if (is_result && from && !scales) {
    if (options.names_protocol && !are_one_body(body, *from))
      throw Error(Code::setting_conflict, options.result,
                  "has gains for a body of " + shown(*from) + ", and protocol " + options.protocol + " another one, " +
                      shown(body),
                  "give --scale-to " + options.protocol +
                      " to scale them by m g h, or leave --protocol out to keep the result's body");
    body = *from;
  }
  protocol.validate();
  if (given) protocol.refuse_implausible();
  if (!from && !are_one_body(body, sim::Body{})) refuse_unknown();
  return protocol;
}

/// Warns of gains for a body that nobody gave, and of a loop that is unstable, although its body stands in the
/// self-test's trial. Throws Error for such a loop without --force.
void warn(const ControllerOptions& options, bool knows_body, const sim::Body& body, const ControllerLimits& limits) {
  if (!limits.margins.stable && !options.force)
    throw Error(Code::body_falls, "export controller",
                "the loop is unstable, although the body stands for this protocol: a small lean grows without limit",
                "change the gains or lower the delay, or write it with --force");
  if (!knows_body)
    std::cerr << options.result << ": does not say whose body its gains are for: they fit the default body only, "
              << shown(body) << "; give identify --mass and --height, or fit a --protocol that has the body\n";
  if (!limits.margins.stable)
    std::cerr << "the loop is unstable, although the body stands for this protocol: a small lean grows without limit; "
                 "change the gains or lower the delay\n";
}

Json controller_json(const ControllerOptions& options, const sim::Body& body, bool assumed, int steps_per_second,
                     const ControllerLimits& limits) {
  const frf::StabilityMargins& margins = limits.margins;
  return Json{{"files", {options.name + ".h", options.name + ".c"}},
              {"body", body_json(body, assumed)},
              {"steps_per_second", steps_per_second},
              {"stable", margins.stable},
              {"delay_margin_s", margins.delay_s},
              {"gain_margin", {margins.gain_low, margins.gain_high}},
              {"peak_tilt_deg", limits.peak_tilt_rad / sim::rad_per_deg},
              {"peak_sway_deg", limits.peak_sway_rad / sim::rad_per_deg},
              {"peak_active_torque_nm", limits.peak_active_torque_nm}};
}

void export_controller(ControllerOptions options, const Command& command) {
  options.names_protocol = command.count("--protocol") > 0;
  check_firmware_name(options.name);
  const int steps_per_second = steps_per_second_of(options.step_s);
  const bool is_result = !options.result.empty();
  Identified chosen{.parameters = {}, .body = sim::Body{}, .which = {}, .caution = {}};
  if (is_result) chosen = identified(options.result, options.recording, options.force);
  if (is_result && !options.controller.empty() && options.controller != chosen.controller->name)
    throw Error(Code::setting_conflict, options.result,
                "has the controller " + chosen.controller->name + ", not " + options.controller,
                "leave --controller out");
  if (!chosen.caution.empty()) std::cerr << options.result << ": " << chosen.caution << '\n';
  const sim::Protocol protocol =
      controller_protocol(options, chosen.body, is_result ? chosen.controller->name : options.controller);
  const sim::BodyModel& model = *protocol.experiment.body_model;
  if (!is_result) chosen.parameters = model.parameters.middle();
  const GivenParameters given = options.parameters.of(model);
  const sim::Body& body = protocol.experiment.body;
  const double ratio = chosen.body ? body.mgh() / chosen.body->mgh() : 1.0;
  sim::Parameters parameters = chosen.parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    if (model.parameters[i].scales_with_mgh) parameters[i] *= ratio;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const sim::ParameterInfo& info = model.parameters[i];
    if (!given[i] && parameters[i] < info.min)  // a network may answer a little less
      std::cerr << format("%s = %.4g is below %g: the controller has %g\n", info.name.c_str(), parameters[i], info.min,
                          info.min);
    parameters[i] = given[i].value_or(std::max(parameters[i], info.min));
  }
  const std::string origin = format(
      "The %s posture controller, made by decid %s%s.", &model == &sim::single_pendulum() ? "DEC" : model.name.c_str(),
      version, options.result.empty() ? "" : (" from " + comment(fs::path(options.result).filename())).c_str());
  const ControllerFiles made = controller_files(parameters, protocol, options.name, origin, steps_per_second);
  warn(options, chosen.body.has_value(), body, made.limits);
  write_files(options.output, options.name, Kind::controller, made.files);
  if (options.common.json)
    std::cout << print_json(controller_json(options, body, !chosen.body, steps_per_second, made.limits)) << '\n';
  if (options.common.quiet || options.common.json) return;
  std::cerr << format("%s.h and %s.c written to %s%s, for a body of %s\n", options.name.c_str(), options.name.c_str(),
                      options.output.c_str(), chosen.which.empty() ? "" : (", of " + chosen.which).c_str(),
                      shown(body).c_str());
  if (steps_per_second != sim::steps_per_second)
    std::cerr << format("call %s_step %d times per second\n", options.name.c_str(), steps_per_second);
  if (ratio != 1.0) std::cerr << format("gains are scaled by %.4g, as m g h is\n", ratio);
  if (!made.limits.margins.stable) return;
  for (const std::string& line : limits_text(made.limits)) std::cerr << line << '\n';
}

void add_export_controller(const Command& parent) {
  auto options = std::make_shared<ControllerOptions>();
  const Command command =
      parent.add_subcommand("controller", "Write a posture controller as one C file and its header");
  command.section("Input");
  command.add_option(
      "result", options->result,
      "Use the estimates in this JSON of decid identify or decid fit; default: the middle of every range");
  command.add_option("--recording", options->recording, "Use this recording of the result, counted from 1");
  command.section("Controller");
  add_controller_option(command, options->controller,
                        "Write this controller (decid info --controllers); default: the result's or the protocol's");
  options->parameters.add(command, [](const sim::BodyModel& model, std::size_t i) {
    if (model.family.find_parameter(sim::Coefficient::nv) == i) return std::string();  // a machine has its own noise
    const sim::ParameterInfo& info = model.parameters[i];
    return "Use this " + in_sentence(info) + (info.unit == "1" ? "" : " in " + info.unit) + " instead of the estimate";
  });
  command.section("Input");
  const Option protocol =
      command.add_option("--protocol", options->protocol,
                         "Use this protocol's tilt for the self-test, and its body, which must be the "
                         "result's: default, short or a JSON file");
  Option scale_to = command.add_option(
      "--scale-to", options->scale_to,
      "Scale the result's gains by m g h to the body of this protocol; gains given as options are not scaled");
  command
      .add_option("--mass", options->mass_kg,
                  "Scale the gains to a body of this mass in kg above the ankles, with --com-height")
      .range(0.01, 500.0)
      .excludes(scale_to);
  command
      .add_option("--com-height", options->com_height_m, "Set the height in m of its centre of mass above the ankles")
      .range(0.01, 5.0)
      .excludes(scale_to);
  command
      .add_option("--inertia", options->inertia_kgm2,
                  "Set its moment of inertia in kg m2 about the ankles; default: scaled from the result's body")
      .excludes(scale_to);
  scale_to.excludes(protocol);
  command.section("Output");
  add_output_option(command, "-o,--output", options->output, Written::folder,
                    "Write NAME.c and NAME.h to this folder, created if missing")
      .required();
  command.add_option("--step", options->step_s,
                     "Set the time in s from call to call, 0.0005 to 0.01, with a whole number of calls per second");
  command.add_option("--name", options->name, "Name the files and functions");
  command.add_flag("--force", options->force, "Accept estimates that are not usable, and an unstable loop")
      .section("Advanced");
  command.footer(
      "Examples:\n"
      "  decid export controller result.json -o firmware\n"
      "  decid export controller result.json --scale-to robot.json -o firmware\n"
      "  decid export controller result.json --step 0.002 -o firmware\n"
      "  decid export controller --kp 900 --kd 280 --name ankle -o firmware");
  run_with(command, options, true, export_controller);
}

struct SwayOptions {
  CommonOptions common;
  RecordingFlags recordings;
  std::string model, output;
};

void export_sway(SwayOptions options) {
  ReadOptions reading = options.recordings.read_options();
  reading.body = options.recordings.body();
  options.recordings.find_sources({options.model, options.output}, options.common.quiet);
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
