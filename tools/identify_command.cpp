// decid identify: recordings in, parameters, JSON and report out.
#include <iostream>
#include <memory>

#include "base/error.hpp"
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
  std::string model, column, unit, truth, output, report, tilt_column, tilt_unit, invert, detrend = "none";
  std::optional<double> rate, start;
  double fill_gaps = 0.0;
};

std::optional<dataset::Unit> unit_of(const std::string& name) {
  if (name.empty()) return {};
  return name == "rad" ? dataset::Unit::radian : dataset::Unit::degree;
}

IdentifyOptions what_to_do(const Options& options) {
  IdentifyOptions made;
  made.recording.column = options.column;
  made.recording.unit = unit_of(options.unit);
  made.recording.rate_hz = options.rate;
  made.recording.fill_gaps_s = options.fill_gaps;
  made.recording.tilt_column = options.tilt_column;
  made.recording.tilt_unit = unit_of(options.tilt_unit);
  made.recording.invert_sway = options.invert == "sway" || options.invert == "both";
  made.recording.invert_tilt = options.invert == "tilt" || options.invert == "both";
  made.trial.start_s = options.start;
  if (options.detrend == "offset") made.trial.detrend = dataset::Detrend::offset;
  if (options.detrend == "linear") made.trial.detrend = dataset::Detrend::linear;
  if (!options.truth.empty()) made.truth = parameters_from_text(options.truth, "--truth");
  if (options.tilt_column.empty() && (!options.tilt_unit.empty() || made.recording.invert_tilt)) {
    throw Error("--tilt-unit, --invert", "no tilt is read", "name its column with --tilt-column");
  }
  if (options.start && !options.tilt_column.empty()) {
    throw Error("--start", "the tilt tells where the protocol starts", "give --start or --tilt-column, not both");
  }
  return made;
}

void run_identify(const Options& options) {
  const IdentifyOptions todo = what_to_do(options);
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
  const std::vector<Identification> all = identify(model, files, todo);
  std::size_t failed = 0;
  for (const Identification& id : all) failed += id.error ? 1 : 0;
  // One recording alone is all or nothing; of several, the good ones are kept.
  if (failed == 1 && all.size() == 1) throw *all.front().error;
  const std::string json = identifications_json(model_name(options.model), all);
  if (!options.report.empty())
    write_file(options.report,
               report_html({model_name(options.model), nn::weights_sha256(model.network), version}, all));
  if (!options.output.empty()) write_file(options.output, json);
  if (options.common.json)
    std::cout << json;
  else if (!options.common.quiet)
    std::cout << identifications_text(all);
  for (const Identification& id : all) {
    if (id.error) std::cerr << "decid: " << one_line(id.error->what()) << '\n';
  }
  if (failed > 0) {
    throw Error("identify", std::to_string(failed) + " of " + std::to_string(all.size()) + " recordings failed",
                "see the lines above, or \"error\" in the JSON; the others are done");
  }
}

}  // namespace

void add_identify(CLI::App& program) {
  auto options = std::make_shared<Options>();
  CLI::App* command = program.add_subcommand("identify", "Identify the controller behind recordings of body sway");
  command->add_option("recordings", options->files, "CSV or MAT-files: a column of sway, usually one of time")
      ->required();
  command->add_option("--model", options->model, "Model file; default: the built-in model");
  command->add_option("--column", options->column, "Sway column, by name or number from 1; default: found by name");
  command->add_option("--unit", options->unit, "deg or rad; default: from the column's name, else degrees")
      ->check(CLI::IsMember({"deg", "rad"}));
  command->add_option("--rate", options->rate, "Sample rate in Hz, if there is no time column or it is wrong")
      ->check(CLI::Range(1.0, 100000.0));
  command
      ->add_option("--fill-gaps", options->fill_gaps,
                   "Interpolate missing values and lost samples up to so many seconds; default: refuse them")
      ->check(CLI::Range(0.0, 60.0));
  command->add_option("--start", options->start, "Where the protocol starts, in seconds after the first sample")
      ->check(CLI::Range(0.0, 1e6));
  command->add_option("--tilt-column", options->tilt_column,
                      "The platform's measured tilt, by name or number: it tells where the protocol starts");
  command->add_option("--tilt-unit", options->tilt_unit, "deg or rad; default: from the column's name, else degrees")
      ->check(CLI::IsMember({"deg", "rad"}));
  command->add_option("--invert", options->invert, "sway, tilt or both: positive against the protocol's direction")
      ->check(CLI::IsMember({"sway", "tilt", "both"}));
  command
      ->add_option("--detrend", options->detrend,
                   "offset: take off the mean of the whole cycles; linear: a drift too; default: none")
      ->check(CLI::IsMember({"none", "offset", "linear"}));
  command->add_option("--truth", options->truth,
                      "Known parameters, shown beside: Kp=..,Kd=..,Kp_pass=..,Kd_pass=..,Nv=..,theta=..,delay=..");
  command->add_option("-o,--output", options->output, "JSON file to write");
  command->add_option("--report", options->report, "HTML report to write: one page that opens offline");
  add_common_options(*command, options->common, true);
  command->footer(
      "Examples: decid identify recording.csv --rate 100 -o result.json --report report.html\n"
      "          decid identify trial.mat --column COM_x --unit rad --detrend offset\n"
      "          decid identify lab.csv --tilt-column platform_deg --fill-gaps 0.1\n"
      "Of several recordings those that cannot be used have an \"error\" in the JSON; the exit code is then 2.");
  command->callback([options] {
    apply(options->common);
    run_identify(*options);
  });
}

}  // namespace decid::tools
