// decid identify: recordings in, parameters, JSON and report out.
#include <iostream>
#include <memory>

#include "base/file.hpp"
#include "tools/command.hpp"
#include "tools/identify.hpp"
#include "tools/report.hpp"
#include "tools/text.hpp"
#include "tools/version.hpp"

namespace decid::tools {
namespace {

struct Options {
  CommonOptions common;
  std::vector<std::string> files;
  std::string model, column, unit, truth, output, report;
  std::optional<double> rate;
};

void run_identify(const Options& options) {
  dataset::RecordingOptions recording;
  recording.column = options.column;
  recording.rate_hz = options.rate;
  if (!options.unit.empty()) recording.unit = options.unit == "rad" ? dataset::Unit::radian : dataset::Unit::degree;
  std::optional<sim::Parameters> truth;
  if (!options.truth.empty()) truth = parameters_from_text(options.truth, "--truth");
  std::vector<std::string> inputs = options.files;
  inputs.push_back(options.model);
  refuse_same_file(options.output, inputs);
  inputs.push_back(options.output);
  refuse_same_file(options.report, inputs);
  // Unwritable places are told before the work, not after.
  for (const std::string& path : {options.output, options.report})
    if (!path.empty()) PendingFile probe(path);

  Model model = model_or_built_in(options.model);
  const std::vector<std::filesystem::path> files(options.files.begin(), options.files.end());
  const std::vector<Identification> all = identify(model, files, recording, truth);
  const std::string json = identifications_json(model_name(options.model), all);
  if (!options.report.empty())
    write_file(options.report,
               report_html({model_name(options.model), nn::weights_sha256(model.network), version}, all));
  if (!options.output.empty()) write_file(options.output, json);
  if (options.common.json)
    std::cout << json;
  else if (!options.common.quiet)
    std::cout << identifications_text(all);
}

}  // namespace

void add_identify(CLI::App& program) {
  auto options = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("identify", "Identify the controller behind recordings of body sway");
  command->add_option("recordings", options->files, "CSV files: a column of sway, usually one of time")->required();
  command->add_option("--model", options->model, "Model file; default: the built-in model");
  command->add_option("--column", options->column, "Sway column, by name or number from 1; default: found by name");
  command->add_option("--unit", options->unit, "deg or rad; default: from the column's name, else degrees")
      ->check(CLI::IsMember({"deg", "rad"}));
  command->add_option("--rate", options->rate, "Sample rate in Hz, if there is no time column or it is wrong")
      ->check(CLI::Range(1.0, 100000.0));
  command->add_option("--truth", options->truth,
                      "Known parameters, shown beside: Kp=..,Kd=..,Kp_pass=..,Kd_pass=..,Nv=..,theta=..,delay=..");
  command->add_option("-o,--output", options->output, "JSON file to write");
  command->add_option("--report", options->report, "HTML report to write: one page that opens offline");
  add_common_options(*command, options->common, true);
  command->footer("Example: decid identify recording.csv --rate 100 -o result.json --report report.html");
  command->callback([options] {
    apply(options->common);
    run_identify(*options);
  });
}

}  // namespace decid::tools
