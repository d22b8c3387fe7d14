// decid identify: recordings in, parameters, JSON and report out.

#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/file.hpp"
#include "base/json_object.hpp"
#include "base/version.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/group_file.hpp"
#include "tools/decid/group_results.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/recording_files.hpp"
#include "tools/decid/recording_flags.hpp"
#include "tools/decid/results.hpp"
#include "tools/decid/results_table.hpp"
#include "tools/report/identify_page.hpp"

namespace decid::tools {
namespace {

struct IdentifyOptions {
  CommonOptions common;
  RecordingFlags recordings;
  std::string model, output, report, table, group;
};

void run_identify(IdentifyOptions options, const Command& command) {
  ReadOptions reading = options.recordings.read_options();
  RecordingFlags& recordings = options.recordings;
  recordings.files =
      recording_files(recordings.files, {options.model, options.output, options.report, options.table, options.group});
  std::vector<std::string> files = recordings.files;
  files.insert(files.end(), {options.model, options.group});
  for (const std::string& path : {options.output, options.report, options.table}) {
    refuse_same_file(path, files);
    files.push_back(path);
  }
  // Reports unwritable places before the work, not after.
  for (const std::string& path : {options.output, options.report, options.table})
    if (!path.empty()) PendingFile probe(path);
  const std::vector<std::string> groups =
      options.group.empty() ? std::vector<std::string>() : groups_of(options.group, recordings.files);

  const Model model = model_or_built_in(options.model);
  reading.truth = recordings.known(model.parameters());
  reading.body = recordings.body();
  Identifications all;
  {
    ProgressBar bar("identify", "recordings", static_cast<long long>(recordings.files.size()), options.common.quiet);
    all = identify_files(model, model_name(options.model), recordings.paths(), reading,
                         [&](std::size_t done) { bar.update(static_cast<long long>(done)); });
  }
  refuse_alone(all.recordings);
  Json list = identifications_list(all);
  const Json compared = groups.empty() ? Json(nullptr) : groups_json(list, groups, model.parameters());
  const MadeWith with{model_name(options.model), nn::weights_sha256(model.network), command.given(beside_answers)};
  const std::string json = recordings_json(with, all, list, compared);
  if (!options.report.empty())
    write_file(options.report,
               report_html({with.model, with.weights_sha256, version, with.options, model.recalibration.known()}, all,
                           page_groups(compared, list)));
  if (!options.table.empty()) write_file(options.table, results_table(list, model.parameters()));
  if (!options.output.empty()) write_file(options.output, json);
  std::cout << (options.common.json ? json : identifications_text(all) + groups_text(compared));
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
  add_table_option(command, options->table);
  add_group_option(command, options->group);
  add_common_options(command, options->common, true);
  command.footer(
      "Examples: decid identify recording.csv --mass 70 --height 1.75 -o result.json --report report.html\n"
      "          decid identify trial.mat --column COM_x --unit rad --detrend offset\n"
      "          decid identify lab.csv --tilt-column platform_deg --fill-gaps 0.1\n"
      "          decid identify subjects --table results.csv --group groups.csv\n"
      "A recording that cannot be used does not stop the others: it has an \"error\" in the JSON, and the exit code is "
      "2.");
  command.callback([options, command] {
    apply(options->common);
    run_identify(*options, command);
  });
}

}  // namespace decid::tools
