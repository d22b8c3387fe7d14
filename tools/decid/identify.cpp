// decid identify: recordings in, parameters, JSON and report out.

#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/file.hpp"
#include "base/version.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/recording_flags.hpp"
#include "tools/decid/results.hpp"
#include "tools/report/identify_page.hpp"

namespace decid::tools {
namespace {

struct IdentifyOptions {
  CommonOptions common;
  RecordingFlags recordings;
  std::string model, output, report;
};

void run_identify(const IdentifyOptions& options) {
  ReadOptions reading = options.recordings.read_options();
  std::vector<std::string> inputs = options.recordings.files;
  inputs.push_back(options.model);
  refuse_same_file(options.output, inputs);
  inputs.push_back(options.output);
  refuse_same_file(options.report, inputs);
  // Reports unwritable places before the work, not after.
  for (const std::string& path : {options.output, options.report})
    if (!path.empty()) PendingFile probe(path);

  const Model model = model_or_built_in(options.model);
  reading.truth = options.recordings.known(model.parameters());
  reading.body = options.recordings.body();
  Identifications all = identify_files(model, model_name(options.model), options.recordings.paths(), reading);
  recognise_tables(all.recordings);
  refuse_alone(all.recordings);
  const std::string json = identifications_json(model_name(options.model), all);
  if (!options.report.empty())
    write_file(options.report, report_html({model_name(options.model), nn::weights_sha256(model.network), version,
                                            model.recalibration.known()},
                                           all));
  if (!options.output.empty()) write_file(options.output, json);
  std::cout << (options.common.json ? json : identifications_text(all));
  tell_errors("identify", all.recordings);
}

}  // namespace

void add_identify(const Command& program) {
  auto options = std::make_shared<IdentifyOptions>();
  const Command command = program.add_subcommand("identify", "Identify the controller behind recordings of body sway");
  add_recording_flags(command, options->recordings).required();
  add_body_options(command, options->recordings);
  add_truth_option(command, options->recordings);
  command.add_option("--model", options->model, "Model file; default: the built-in model");
  add_output_option(command, "-o,--output", options->output, Written::json, "JSON file to write");
  add_output_option(command, "--report", options->report, Written::html,
                    "HTML report to write: one page that opens offline");
  add_common_options(command, options->common, true);
  command.footer(
      "Examples: decid identify recording.csv --mass 70 --height 1.75 -o result.json --report report.html\n"
      "          decid identify trial.mat --column COM_x --unit rad --detrend offset\n"
      "          decid identify lab.csv --tilt-column platform_deg --fill-gaps 0.1\n"
      "A recording that cannot be used does not stop the others: it has an \"error\" in the JSON, and the exit code is "
      "2.");
  command.callback([options] {
    apply(options->common);
    run_identify(*options);
  });
}

}  // namespace decid::tools
