// decid stimulus: a protocol's tilt as CSV, as a page with charts, and the protocol itself as a file to start from.
#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/commands/trial_csv.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/stimulus_page.hpp"

namespace decid::tools {
namespace {

struct StimulusOptions {
  CommonOptions common;
  std::string protocol = "default", output, plot, written_protocol;
};

void stimulus(const StimulusOptions& options, const Command& command) {
  if (options.output.empty() && options.plot.empty() && options.written_protocol.empty())
    throw Error(Code::setting_missing, "stimulus", "has nothing to write",
                "give -o stimulus.csv, --plot page.html or --write-protocol p.json");
  std::vector<std::string> files;
  const sim::Protocol protocol = read_protocol(options.protocol, options.common.quiet, &files);
  const Call call = record_call(command, files);
  for (const std::string& path : {options.output, options.plot, options.written_protocol}) {
    refuse_same_file(path, files);
    if (path.empty()) continue;
    files.push_back(path);
    PendingFile probe(path);  // reports unwritable places before anything is written
  }
  const sim::Stimulus played = sim::make_stimulus(protocol.experiment);
  if (!options.output.empty())
    write_file(options.output, csv({"time", "tilt_deg"}, time_and_tilt(protocol, played), csv_digits));
  if (!options.plot.empty()) write_file(options.plot, stimulus_html(protocol, version, call));
  if (!options.written_protocol.empty()) write_file(options.written_protocol, sim::to_json(protocol) + "\n");
  if (options.common.quiet) return;
  std::string degrees = format("%.4g", played.peak_to_peak_rad() / sim::rad_per_deg);
  degrees += degrees == "1" ? " degree" : " degrees";
  std::cerr << format("protocol '%s': %d samples at %g Hz, %g s, tilt %s peak to peak\n", protocol.name.c_str(),
                      protocol.samples(), protocol.experiment.sample_rate_hz, protocol.duration_s(), degrees.c_str());
}

}  // namespace

void add_stimulus(const Command& program) {
  auto options = std::make_shared<StimulusOptions>();
  const Command command = program.add_subcommand("stimulus", "Write and plot the platform's tilt");
  command.section("Input");
  command.add_option("--protocol", options->protocol, "Use this protocol: default, short, or a JSON file");
  add_output_option(command, "-o,--output", options->output, Written::csv,
                    "Write the tilt to this CSV file: time,tilt_deg at the sample rate");
  add_output_option(command, "--plot", options->plot, Written::html,
                    "Plot tilt, velocity and amplitude spectrum on this HTML page");
  add_output_option(command, "--write-protocol", options->written_protocol, Written::json,
                    "Write the protocol with every setting, and a measured tilt with its samples, to this JSON file, "
                    "as a start for your own");
  command.footer(
      "Examples:\n"
      "  decid stimulus -o stimulus.csv\n"
      "  decid stimulus --protocol short --plot stimulus.html\n"
      "  decid stimulus --write-protocol mine.json");
  run_with(command, options, false, stimulus);
}

}  // namespace decid::tools
