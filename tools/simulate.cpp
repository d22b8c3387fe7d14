// decid simulate and decid stimulus: a trial with known parameters, and the platform's tilt alone, as CSV.
#include "sim/simulate.hpp"

#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/file.hpp"
#include "dataset/protocol_json.hpp"
#include "tools/command.hpp"
#include "tools/text.hpp"

namespace decid::tools {
namespace {

constexpr int digits = 10;

struct Options {
  CommonOptions common;
  sim::Parameters parameters = sim::middle_parameters();
  std::uint64_t seed = 1;
  std::string protocol = "default";
  std::string output;
};

/// Time and tilt of every sample.
std::vector<std::vector<double>> time_and_tilt(const sim::Protocol& protocol, const sim::Stimulus& stimulus) {
  std::vector<std::vector<double>> columns(2);
  for (int k = 0; k < protocol.samples(); ++k) {
    columns[0].push_back(k / protocol.sample_rate_hz);
    columns[1].push_back(stimulus.tilt_at(k * protocol.steps_per_sample()) / sim::rad_per_deg);
  }
  return columns;
}

void simulate(const Options& options) {
  const sim::Simulator simulator(dataset::load_protocol(options.protocol));
  std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
  const sim::Outcome outcome =
      simulator.run(options.parameters, Random(options.seed, Stream::vestibular_noise, 0), sway);
  if (!outcome.valid)
    throw Error("simulate",
                format("the body leaves 5 degrees after %.2f s: these parameters do not stand", outcome.end_s),
                "shorten --delay, lower --kp or raise --kd");
  sim::add_sensor_noise(simulator.protocol().sensor_noise, options.seed, 0, sway);
  for (double& value : sway) value /= sim::rad_per_deg;
  auto columns = time_and_tilt(simulator.protocol(), simulator.stimulus());
  columns.insert(columns.begin() + 1, std::move(sway));
  write_file(options.output, csv({"time", "com_sway_deg", "tilt_deg"}, columns, digits));
  if (options.common.quiet) return;
  for (std::size_t i = 0; i < sim::parameter_count; ++i)
    std::cerr << format("%-8s %12.6g %s\n", sim::parameter_info[i].name, options.parameters[i],
                        sim::parameter_info[i].unit);
  std::cerr << format("%d samples at %g Hz, largest sway %.3f degrees, seed %llu, written to %s\n", simulator.samples(),
                      simulator.protocol().sample_rate_hz, outcome.largest_sway_rad / sim::rad_per_deg,
                      static_cast<unsigned long long>(options.seed), options.output.c_str());
}

void add_protocol_and_output(CLI::App& command, Options& options) {
  command.add_option("--protocol", options.protocol, "default, short, or a JSON file")->capture_default_str();
  command.add_option("-o,--output", options.output, "CSV file to write")->required();
}

}  // namespace

void add_simulate(CLI::App& program) {
  auto options = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("simulate", "Simulate one trial with known parameters");
  for (std::size_t i = 0; i < sim::parameter_count; ++i) {
    const sim::ParameterInfo& info = sim::parameter_info[i];
    command
        ->add_option(std::string("--") + info.option, options->parameters[i],
                     format("%s, %s; usual range %g to %g", info.description, info.unit, info.low, info.high))
        ->capture_default_str();
  }
  command->add_option("--seed", options->seed, "Seed of the noise")
      ->capture_default_str()
      ->check(CLI::NonNegativeNumber);
  command->add_option("--model", "Body: sip, the single inverted pendulum")
      ->check(CLI::IsMember({"sip"}))
      ->default_str("sip");
  add_protocol_and_output(*command, *options);
  add_common_options(*command, options->common, false);
  command->footer("Example: decid simulate --kp 900 --delay 0.1 --nv 0.4 --seed 7 -o trial.csv");
  command->callback([options] {
    apply(options->common);
    simulate(*options);
  });
}

void add_stimulus(CLI::App& program) {
  auto options = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("stimulus", "Write the platform's tilt over a trial");
  add_protocol_and_output(*command, *options);
  add_common_options(*command, options->common, false);
  command->footer("Example: decid stimulus --protocol short -o stimulus.csv");
  command->callback([options] {
    apply(options->common);
    const sim::Protocol protocol = dataset::load_protocol(options->protocol);
    write_file(options->output,
               csv({"time", "tilt_deg"}, time_and_tilt(protocol, sim::make_stimulus(protocol)), digits));
  });
}

}  // namespace decid::tools
