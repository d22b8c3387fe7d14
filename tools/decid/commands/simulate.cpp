// decid simulate: a trial with known parameters as CSV, of the single or the double inverted pendulum.
#include "sim/simulate.hpp"

#include <functional>
#include <iostream>
#include <memory>
#include <vector>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/text.hpp"
#include "sim/double_pendulum.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "sim/segments.hpp"
#include "sim/streams.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/commands/trial_csv.hpp"
#include "tools/decid/parameter_options.hpp"

namespace decid::tools {
namespace {

/// Returns the parameters of each joint of the double pendulum.
const sim::ParameterTable& joint_table() {
  return sim::single_pendulum().parameters;
}

struct SimulateOptions {
  CommonOptions common;
  ParameterOptions parameters;
  GivenParameters hip = GivenParameters(joint_table().size());
  std::uint64_t seed = 1;
  std::string model = "sip", protocol = "default", controller, output;
};

std::vector<double> zeros(int samples) {
  return std::vector<double>(static_cast<std::size_t>(samples));
}

void to_degrees(std::vector<double>& angles) {
  for (double& value : angles) value /= sim::rad_per_deg;
}

/// Returns the protocol without noise, on a platform that hardly moves.
sim::Protocol at_rest(sim::Protocol protocol) {
  sim::Sequence small;
  small.amplitude_deg = 1e-3;
  protocol.experiment.stimulus = small;
  protocol.noise.vestibular.scale_deg = 0.0;  // its band may hold no harmonic of this trial
  return protocol;
}

/// Throws Error if the body fell. The error gives the cause and the first remedy that keeps the body standing: less
/// noise, less tilt, or other gains. stands(protocol, without_noise): returns true if the same parameters keep the body
/// standing.
void require_standing(const sim::Outcome& outcome, const sim::Protocol& protocol,
                      const std::function<bool(const sim::Protocol&, bool without_noise)>& stands,
                      const std::string& other_gains) {
  if (outcome.valid) return;
  const bool fell = outcome.max_sway_rad > sim::sway_limit_rad;
  const std::string what =
      fell ? "the body leans by more than 5 degrees"
           : format("leg or trunk leans by more than %.0f degrees", sim::segment_limit_rad / sim::rad_per_deg);
  const std::string remedy =
      stands(protocol, true)            ? "it stands without vestibular noise: lower --nv or the noise's scale"
      : stands(at_rest(protocol), true) ? "it stands on a platform at rest: lower the amplitude of the tilt"
                                        : other_gains;
  throw Error(Code::body_falls, "simulate", format("%s after %.2f s", what.c_str(), outcome.end_s), remedy);
}

/// Returns time and tilt from the beginning of the recording.
std::vector<std::vector<double>> recorded_tilt(const sim::Protocol& protocol, const sim::Stimulus& stimulus,
                                               std::uint64_t seed) {
  auto columns = time_and_tilt(protocol, stimulus);
  const double start_s = sim::drawn(protocol.conditions, sim::Condition::start, seed, 0);
  if (start_s != 0.0) sim::begin_later(columns[1], start_s * protocol.experiment.sample_rate_hz);
  return columns;
}

void print_parameters(const char* title, const sim::ParameterTable& table, const sim::Parameters& parameters) {
  std::cerr << title;
  for (std::size_t i = 0; i < parameters.size(); ++i)
    std::cerr << format("%-8s %12.6g %s\n", table[i].name.c_str(), parameters[i], table[i].shown_unit().c_str());
}

void print_summary(const SimulateOptions& options, const sim::Protocol& protocol, const sim::Outcome& outcome) {
  const double noise_deg = sim::sensor_noise_level(protocol.noise.sensor, options.seed, 0) / sim::rad_per_deg;
  std::cerr << format("%d samples at %g Hz, largest sway %.3f degrees%s, seed %llu, written to %s\n",
                      protocol.samples(), protocol.experiment.sample_rate_hz, outcome.max_sway_rad / sim::rad_per_deg,
                      noise_deg > 0.0 ? format(" and %.4g of measurement noise", noise_deg).c_str() : "",
                      static_cast<unsigned long long>(options.seed), options.output.c_str());
}

/// Returns the remedy for a body that falls without noise and tilt too.
std::string remedy_by_gains(const sim::Coefficients& of, double mgh) {
  const double responses = of[sim::Coefficient::position] + of[sim::Coefficient::gravity],
               stiffness = of[sim::Coefficient::kp_pass] + responses * of[sim::Coefficient::kp];
  if (stiffness > mgh) return "change the gains or lower the delay";
  const std::string times = responses == 1.0 ? "" : responses == 2.0 ? "twice " : format("%g times ", responses);
  return format("passive stiffness and %s--kp, %s N m/rad, must exceed the body's m g h, %s: raise --kp", times.c_str(),
                sim::mgh_text(stiffness).c_str(), sim::mgh_text(mgh).c_str());
}

void simulate_single(const SimulateOptions& options, sim::Protocol protocol) {
  const sim::Simulator simulator(std::move(protocol));
  const sim::BodyModel& model = *simulator.protocol().experiment.body_model;
  const sim::Parameters parameters = filled(simulator.protocol().ranges().middle(), options.parameters.of(model));
  std::vector<double> sway = zeros(simulator.samples());
  const sim::Outcome outcome = simulator.run(parameters, Random(options.seed, sim::streams::vestibular_noise, 0), sway);
  require_standing(
      outcome, simulator.protocol(),
      [&](const sim::Protocol& other, bool without_noise) {
        const sim::Parameters same = without_noise ? model.family.without_noise(parameters) : parameters;
        const sim::Simulator again(other);
        std::vector<double> unused = zeros(again.samples());
        return again.run(same, Random(options.seed, sim::streams::vestibular_noise, 0), unused).valid;
      },
      remedy_by_gains(model.family.coefficients(parameters), simulator.protocol().experiment.body.mgh()));
  sim::record(simulator.protocol(), options.seed, 0, sway);
  to_degrees(sway);
  auto columns = recorded_tilt(simulator.protocol(), simulator.stimulus(), options.seed);
  columns.insert(columns.begin() + 1, std::move(sway));
  write_file(options.output, csv({"time", "com_sway_deg", "tilt_deg"}, columns, csv_digits));
  if (options.common.quiet) return;
  print_parameters("", model.parameters, parameters);
  print_summary(options, simulator.protocol(), outcome);
}

void simulate_double(const SimulateOptions& options, sim::Protocol protocol) {
  const sim::DoubleSimulator simulator(std::move(protocol));
  sim::DoubleParameters parameters = sim::default_double_parameters(simulator.segments());
  parameters = {filled(parameters.ankle, options.parameters.of(sim::single_pendulum())),
                filled(parameters.hip, options.hip)};
  std::vector<double> com = zeros(simulator.samples()), leg = com, trunk = com;
  const sim::Outcome outcome =
      simulator.run(parameters, Random(options.seed, sim::streams::vestibular_noise, 0), {com, leg, trunk});
  require_standing(
      outcome, simulator.protocol(),
      [&](const sim::Protocol& other, bool without_noise) {
        sim::DoubleParameters same = parameters;
        if (without_noise) same.ankle[sim::Nv] = same.hip[sim::Nv] = 0.0;
        const sim::DoubleSimulator again(other);
        std::vector<double> unused = zeros(again.samples()), leg_unused = unused, trunk_unused = unused;
        return again
            .run(same, Random(options.seed, sim::streams::vestibular_noise, 0), {unused, leg_unused, trunk_unused})
            .valid;
      },
      "shorten --delay or --hip-delay, or bring the gains of ankle and hip nearer to their defaults");
  sim::record(simulator.protocol(), options.seed, 0, com);
  auto columns = recorded_tilt(simulator.protocol(), simulator.stimulus(), options.seed);
  for (std::vector<double>* angles : {&com, &leg, &trunk}) to_degrees(*angles);
  columns.insert(columns.begin() + 1, std::move(com));
  columns.push_back(std::move(leg));
  columns.push_back(std::move(trunk));
  write_file(options.output, csv({"time", "com_sway_deg", "tilt_deg", "leg_deg", "trunk_deg"}, columns, csv_digits));
  if (options.common.quiet) return;
  print_parameters("ankle\n", joint_table(), parameters.ankle);
  print_parameters("hip\n", joint_table(), parameters.hip);
  print_summary(options, simulator.protocol(), outcome);
}

void simulate(const SimulateOptions& options, const Command& command) {
  for (const sim::ParameterInfo& info : joint_table()) {
    const std::string name = "--hip-" + info.option;
    if (options.model != "dip" && command.count(name) > 0)
      throw Error(Code::setting_conflict, name, "has no effect on the single pendulum, which has no hip",
                  "use it with --model dip");
  }
  std::vector<std::string> files;
  sim::Protocol protocol = read_protocol(options.protocol, options.common.quiet, &files, options.controller);
  refuse_same_file(options.output, files);
  if (options.model == "dip" && protocol.experiment.body_model != &sim::single_pendulum())
    throw Error(Code::setting_conflict, "--model dip",
                "has the controller dec at its joints, not " + protocol.experiment.body_model->name,
                "leave the other controller out, or simulate one segment");
  if (options.model == "dip" && protocol.gravity_dead_band_deg > 0.0)
    throw Error(Code::setting_conflict, "--model dip",
                "has no gravity dead band at its joints, and the protocol has one",
                "leave gravity_dead_band_deg out, or simulate one segment");
  options.model == "dip" ? simulate_double(options, std::move(protocol))
                         : simulate_single(options, std::move(protocol));
}

}  // namespace

void add_simulate(const Command& program) {
  auto options = std::make_shared<SimulateOptions>();
  const Command command = program.add_subcommand("simulate", "Simulate one trial with known parameters");
  command.section("Controller");
  const sim::DoubleParameters of_double = sim::default_double_parameters(sim::make_segments({}));
  add_controller_option(command, options->controller,
                        "Simulate this controller (decid info --controllers); default: the protocol's, else dec");
  options->parameters.add(command, [&](const sim::BodyModel& model, std::size_t i) {
    const sim::ParameterInfo& info = model.parameters[i];
    return format("Set the %s; usual range%s: %g to %g%s; default: ", in_sentence(info).c_str(),
                  &model == &sim::single_pendulum() ? "" : (" with " + model.name).c_str(), info.low, info.high,
                  info.unit_after().c_str()) +
           (&model == &sim::single_pendulum() ? format("%g, with --model dip %.4g", info.middle(), of_double.ankle[i])
                                              : format("%g", info.middle()));
  });
  add_seed_option(command, options->seed, "Seed the noise");
  command
      .add_option("--model", options->model,
                  "Simulate sip, a single inverted pendulum, or dip, leg and trunk with one controller at the ankle "
                  "(the options above) and one at the hip; measurement noise affects com_sway_deg only")
      .one_of({"sip", "dip"});
  for (std::size_t i = 0; i < joint_table().size(); ++i) {
    const sim::ParameterInfo& info = joint_table()[i];
    command
        .add_option("--hip-" + info.option, options->hip[i],
                    format("Set the hip's %s, with --model dip; default: %.4g%s", in_sentence(info).c_str(),
                           of_double.hip[i], info.unit_after().c_str()))
        .shown_as("FLOAT");
  }
  command.section("Input");
  command.add_option("--protocol", options->protocol, "Simulate this protocol: default, short, or a JSON file");
  add_output_option(command, "-o,--output", options->output, Written::csv,
                    "Write this CSV file: time,com_sway_deg,tilt_deg; with --model dip also leg_deg,trunk_deg")
      .required();
  command.footer(
      "Examples:\n"
      "  decid simulate -o trial.csv\n"
      "  decid simulate --kp 900 --delay 0.1 --nv 0.4 --seed 7 -o trial.csv\n"
      "  decid simulate --nv 0 --protocol short -o noise_free.csv\n"
      "  decid simulate --controller dec2015 --gravity-gain 0.55 -o person.csv\n"
      "  decid simulate --model dip --hip-delay 0.05 -o two_segments.csv\n"
      "Default gains are those of the default body; they scale with the m g h of the protocol's body.");
  run_with(command, options, false, simulate);
}

}  // namespace decid::tools
