// decid identify: recordings in, parameters, JSON and report out.

#include <iostream>
#include <memory>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/version.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/group_file.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/recording_flags.hpp"
#include "tools/decid/results/group_results.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/decid/results/results_table.hpp"
#include "tools/report/identify_page.hpp"
#include "tools/report/other_answer.hpp"

namespace decid::tools {
namespace {

struct IdentifyOptions {
  CommonOptions common;
  RecordingFlags recordings;
  std::string model, output, report, table, group;

  bool wants_json() const { return common.json || !output.empty(); }
  /// Something is made of the recordings' objects.
  bool wants_list() const { return wants_json() || !table.empty() || !group.empty(); }
};

/// What the outputs hold of recordings, and what these have in common.
struct Answers {
  Identifications common;  ///< of each recording its name and error alone
  Json list = Json::array();
  std::string text;
  std::vector<Json> pages;
};

void add_answer(Answers& answers, Json recording, const std::string& text, Json page) {
  answers.list.push_back(std::move(recording));
  answers.text += text;
  if (!page.is_null()) answers.pages.push_back(std::move(page));
}

Identification named(const std::string& file, const std::optional<Error>& error) {
  Identification id;
  id.file = file;
  id.error = error;
  return id;
}

/// The recording's object, if something is made of it.
Json object_of(const IdentifyOptions& options, const Identification& id, const Identifications& all) {
  return options.wants_list() ? recording_json(id, all.protocol) : Json(nullptr);
}

/// The page's part of a recording, if there is to be a page.
Json page_of(const IdentifyOptions& options, const Identification& id, const Identifications& all) {
  return options.report.empty() || id.error ? Json(nullptr) : report_recording(id, all);
}

Answers identify_alone(const IdentifyOptions& options, const Model& model, const ReadOptions& reading) {
  ProgressBar bar("identify", "recordings", static_cast<long long>(options.recordings.files.size()),
                  options.common.quiet);
  Answers answers;
  answers.common = identify_files(model, model_name(options.model), options.recordings.sources, reading,
                                  [&](std::size_t done) { bar.update(static_cast<long long>(done)); });
  const Identifications& all = answers.common;
  for (const Identification& id : all.recordings)
    add_answer(answers, object_of(options, id, all), identification_text(id, all.protocol), page_of(options, id, all));
  return answers;
}

/// Some recordings at a time to each rank; what the outputs hold of them comes back.
Answers identify_together(const IdentifyOptions& options, const Model& model, const ReadOptions& reading) {
  const std::vector<RecordingSource>& sources = options.recordings.sources;
  const std::string name = model_name(options.model);
  require_same("the list of recordings", listed(options.recordings.files), "give all hosts the same files");
  const auto identify_some = [&](std::size_t first, std::size_t last) {
    const std::vector<RecordingSource> some(sources.begin() + static_cast<std::ptrdiff_t>(first),
                                            sources.begin() + static_cast<std::ptrdiff_t>(last));
    const Identifications all = identify_files(model, name, some, reading);
    std::vector<std::string> results;
    for (const Identification& id : all.recordings) {
      Json result{{"recording", object_of(options, id, all)},
                  {"text", identification_text(id, all.protocol)},
                  {"page", page_of(options, id, all)}};
      if (id.error) result["error"] = {id.error->where(), id.error->problem(), id.error->remedy()};
      std::string bytes;
      Json::to_cbor(result, bytes);
      results.push_back(std::move(bytes));
    }
    return results;
  };
  ProgressBar bar("identify", "recordings", static_cast<long long>(sources.size()), options.common.quiet);
  long long done = 0;
  std::vector<Json> results(sources.size());
  share_out(
      sources.size(), 4, identify_some,
      [&](std::size_t i, const std::string& bytes) {
        results[i] = Json::from_cbor(bytes);
        bar.update(++done);
      },
      [] { return false; });
  Answers answers;
  if (!is_root()) return answers;
  answers.common = identify_files(model, name, {}, reading);
  for (std::size_t i = 0; i < results.size(); ++i) {
    Json& result = results[i];
    std::optional<Error> error;
    if (result.contains("error")) error = Error(result["error"][0], result["error"][1], result["error"][2]);
    answers.common.recordings.push_back(named(options.recordings.files[i], error));
    add_answer(answers, std::move(result["recording"]), result["text"], std::move(result["page"]));
  }
  return answers;
}

void run_identify(IdentifyOptions options, const Command& command) {
  ReadOptions reading = options.recordings.read_options();
  RecordingFlags& recordings = options.recordings;
  recordings.find_sources({options.model, options.output, options.report, options.table, options.group},
                          options.common.quiet);
  std::vector<std::string> files = recordings.distinct_files();
  files.insert(files.end(), {options.model, options.group});
  for (const std::string& path : {options.output, options.report, options.table}) {
    refuse_same_file(path, files);
    files.push_back(path);
  }
  // Reports unwritable places before the work, not after.
  for (const std::string& path : {options.output, options.report, options.table})
    if (!path.empty() && is_root()) PendingFile probe(path);
  const GroupTable groups = groups_of(options.group, recordings, options.common.quiet);

  const Model model = model_or_built_in(options.model);
  reading.truth = recordings.known(model.parameters());
  reading.body = recordings.body();
  Answers answers =
      ranks() == nullptr ? identify_alone(options, model, reading) : identify_together(options, model, reading);
  if (!is_root()) return;
  const Identifications& all = answers.common;
  refuse_alone(all.recordings);
  Json& list = answers.list;
  const Json compared = options.group.empty() ? Json(nullptr) : groups_json(list, groups, model.parameters());
  const bool names_weights = options.wants_json() || !options.report.empty();
  const MadeWith with{model_name(options.model), names_weights ? nn::weights_sha256(model.network) : std::string(),
                      command.given(beside_answers), beside_identify};
  const std::string json = options.wants_json() ? recordings_json(with, all, list, compared) : std::string();
  std::vector<std::string> failed;
  for (const Identification& id : all.recordings)
    if (id.error) failed.emplace_back(id.error->what());
  if (!options.report.empty())
    write_file(options.report,
               report_html({with.model, with.weights_sha256, version, with.options, model.recalibration.known()}, all,
                           std::move(answers.pages), failed, page_groups(compared, list)));
  if (!options.table.empty()) write_file(options.table, results_table(list, model.parameters()));
  if (!options.output.empty()) write_file(options.output, json);
  std::cout << (options.common.json ? json : answers.text + body_text(all) + groups_text(compared));
  tell_errors("identify", all.recordings);
}

}  // namespace

void add_identify(const Command& program) {
  auto options = std::make_shared<IdentifyOptions>();
  const Command command =
      program.add_subcommand("identify", "Estimate balance-control parameters from sway recordings");
  add_recording_flags(command, options->recordings).required();
  add_body_options(command, options->recordings);
  add_truth_option(command, options->recordings);
  command.section("Model");
  command.add_option("--model", options->model, "Use this model file; default: the built-in model");
  add_output_option(command, "-o,--output", options->output, Written::json, "Write the results to this JSON file");
  add_output_option(command, "--report", options->report, Written::html,
                    "Write a report to this HTML page, which opens offline");
  add_table_option(command, options->table);
  add_group_option(command, options->group);
  add_common_options(command, options->common, true);
  command.footer(
      "Examples:\n"
      "  decid identify recording.csv --mass 70 --height 1.75 -o result.json --report report.html\n"
      "  decid identify trial.mat --column COM_x --unit rad --detrend offset\n"
      "  decid identify trial.c3d --hip HIP_x --shoulder C7_x --ankle ANK_x --mass 70 --height 1.75\n"
      "  decid identify lab.csv --tilt-column platform_deg --fill-gaps 0.1\n"
      "  decid identify subjects --table results.csv --group groups.csv\n"
      "  decid identify long.csv --trial subject,trial --table results.csv\n"
      "A recording that cannot be used does not stop the others: its JSON entry has \"error\", and the exit code is "
      "2.");
  command.callback([options, command] {
    apply(options->common);
    run_identify(*options, command);
  });
}

}  // namespace decid::tools
