// decid export controller: a posture controller as C files for a firmware.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <system_error>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/commands/export.hpp"
#include "tools/decid/parameter_options.hpp"
#include "tools/decid/results/identified.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/firmware/c_text.hpp"
#include "tools/firmware/controller.hpp"
#include "tools/report/json/recording_json.hpp"

namespace decid::tools {
namespace {

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
/// result. inputs: receives the names of the files that were read.
sim::Protocol controller_protocol(const ControllerOptions& options, const std::optional<sim::Body>& from,
                                  const std::string& controller, std::vector<std::string>& inputs) {
  const bool scales = !options.scale_to.empty(), is_result = !options.result.empty();
  sim::Protocol protocol =
      read_protocol(scales ? options.scale_to : options.protocol, options.common.quiet, &inputs, controller);
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

/// Returns true if a change of all gains by less than a tenth makes the loop unstable.
bool is_narrow(const frf::StabilityMargins& margins) {
  return margins.gain_low > 0.9 || margins.gain_high < 1.1;
}

Json controller_json(const ControllerOptions& options, const sim::Protocol& protocol, bool assumed,
                     int steps_per_second, const ControllerFiles& made) {
  const ControllerLimits& limits = made.limits;
  const frf::StabilityMargins& margins = limits.margins;
  Json json = written_json(options.name, made.files);
  json.update({{"protocol", protocol.name},
               {"body", body_json(protocol.experiment.body, assumed)},
               {"steps_per_second", steps_per_second},
               {"stable", margins.stable},
               {"delay_margin_s", margins.delay_s},
               {"gain_margin", {margins.gain_low, margins.gain_high}},
               {"peak_tilt_deg", limits.peak_tilt_rad / sim::rad_per_deg},
               {"peak_sway_deg", limits.peak_sway_rad / sim::rad_per_deg},
               {"peak_active_torque_nm", limits.peak_active_torque_nm}});
  return json;
}

/// Throws Error for a file that does not begin like JSON, such as a recording. remedy: which file to give.
void require_json(const std::string& path, const std::string& remedy) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return;
  const std::string text = read_file(path);
  const std::size_t first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first == std::string::npos || (text[first] != '{' && text[first] != '['))
    throw Error(Code::file_unsupported, path, "is not JSON", remedy);
}

void export_controller(ControllerOptions options, const Command& command) {
  require_json(options.result, "give the JSON that decid identify -o or decid fit -o writes");
  require_json(options.scale_to, "give a protocol: default, short or a JSON file");
  options.names_protocol = command.count("--protocol") > 0;
  check_firmware_name(options.name);
  const int steps_per_second = steps_per_second_of(options.step_s);
  const bool is_result = !options.result.empty();
  if (!is_result && command.count("--recording") > 0)
    throw Error(Code::setting_missing, "--recording", "there is no result whose recording it could be",
                "give the JSON of decid identify or decid fit, or leave it out");
  Identified chosen{.parameters = {}, .body = sim::Body{}, .which = {}, .caution = {}};
  if (is_result) chosen = identified(options.result, options.recording, options.force);
  if (is_result && !options.controller.empty() && options.controller != chosen.controller->name)
    throw Error(Code::setting_conflict, options.result,
                "has the controller " + chosen.controller->name + ", not " + options.controller,
                "leave --controller out");
  if (!chosen.caution.empty()) std::cerr << options.result << ": " << chosen.caution << '\n';
  std::vector<std::string> inputs{options.result};
  const sim::Protocol protocol =
      controller_protocol(options, chosen.body, is_result ? chosen.controller->name : options.controller, inputs);
  const sim::BodyModel& model = *protocol.experiment.body_model;
  if (!is_result) chosen.parameters = model.parameters.middle();
  const GivenParameters given = options.parameters.of(model);
  const sim::Body& body = protocol.experiment.body;
  const bool assumed = !chosen.body || (!is_result && !options.mass_kg && body == sim::Body{});
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
      version,
      options.result.empty() ? "" : (" from " + comment(std::filesystem::path(options.result).filename())).c_str());
  const ControllerFiles made = controller_files(parameters, protocol, options.name, origin, steps_per_second);
  warn(options, chosen.body.has_value(), body, made.limits);
  write_exported(options.output, options.name, ExportedKind::controller, made.files);
  if (options.common.json) {
    Json json = controller_json(options, protocol, assumed, steps_per_second, made);
    add_call(json, record_call(command, inputs, {options.result}));
    std::cout << print_json(json) << '\n';
  }
  if (options.common.quiet || options.common.json) return;
  std::cerr << format("%s.h and %s.c written to %s%s, for a body of %s\n", options.name.c_str(), options.name.c_str(),
                      options.output.c_str(), chosen.which.empty() ? "" : (", of " + chosen.which).c_str(),
                      shown(body).c_str());
  if (steps_per_second != sim::steps_per_second)
    std::cerr << format("call %s_step %d times per second\n", options.name.c_str(), steps_per_second);
  if (ratio != 1.0) std::cerr << format("gains are scaled by %.4g, as m g h is\n", ratio);
  if (!made.limits.margins.stable) return;
  for (const std::string& line : limits_text(made.limits)) std::cerr << line << '\n';
  if (is_narrow(made.limits.margins))
    std::cerr << "the gain margin is narrow: a body or an actuator that differs by a few percent may fall\n";
}

}  // namespace

void add_export_controller(const Command& parent) {
  auto options = std::make_shared<ControllerOptions>();
  const Command command =
      parent.add_subcommand("controller", "Write a posture controller as one C file and its header");
  command.section("Input");
  command
      .add_option("result", options->result,
                  "Use the estimates in this JSON of decid identify or decid fit; default: the middle of every range")
      .unrecorded();
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

}  // namespace decid::tools
