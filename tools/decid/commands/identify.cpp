// decid identify: recordings in, parameters, JSON and report out.

#include <algorithm>
#include <memory>
#include <numeric>

#include "base/error.hpp"
#include "identify/result_archive.hpp"
#include "identify/study/study_results.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/group_file.hpp"
#include "tools/decid/progress.hpp"
#include "tools/decid/ranks.hpp"
#include "tools/decid/recording_flags.hpp"
#include "tools/decid/results/outputs.hpp"
#include "tools/decid/results/results.hpp"

namespace decid::tools {
namespace {

/// Large enough to keep all threads busy, small enough for frequent progress. An answer does not depend on the other
/// recordings of its batch.
constexpr std::size_t recordings_at_once = 32, recordings_of_rank = 4;

struct IdentifyOptions {
  CommonOptions common;
  RecordingFlags recordings;
  Outputs outputs;
  std::string model, controller, protocol;  ///< protocol: refused
  GroupFlags groups;
};

/// Returns the report of all recordings at rank 0, with the work shared by all ranks; at other ranks a report without
/// recordings. inputs: receives the names of the protocols' files, and no output may be one of them.
Report identify_all(const IdentifyOptions& options, const Model& model, const RecordingPlan& plan,
                    std::vector<std::string>& inputs) {
  const std::size_t count = plan.recordings.size();
  const std::size_t at_once = ranks() == nullptr ? recordings_at_once : recordings_of_rank;
  require_same("the list of recordings", listed(options.recordings.files), "give all hosts the same files");
  PlanIdentifier identifier(model, model_name(options.model), plan, std::min(count, at_once), &inputs);
  options.outputs.check(inputs);
  Report report = identifier.report();
  report.recordings.resize(is_root() ? count : 0);
  std::vector<std::size_t> order(count);  // recordings of one body one after the other
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return plan.recordings[i].setting; });
  ProgressBar bar("Analysing", "recordings", static_cast<long long>(count), options.common.quiet);
  long long done = 0;
  share_out<RecordingResult>(
      count, at_once,
      [&](std::size_t first, std::size_t last, const Give<RecordingResult>& give) {
        std::vector<RecordingResult> some = identifier.identify(std::span(order).subspan(first, last - first));
        for (std::size_t i = 0; i < some.size(); ++i) give(first + i, std::move(some[i]));
      },
      [&](std::size_t i, RecordingResult result) {
        set_planned(result, plan.recordings[order[i]]);
        report.recordings[order[i]] = std::move(result);
        bar.update(++done);
      },
      [] { return false; });
  return report;
}

void run_identify(IdentifyOptions options, const Command& command) {
  ReadOptions reading = options.recordings.read_options();
  RecordingFlags& recordings = options.recordings;
  if (recordings.files.empty() && recordings.study.empty())
    throw Error(Code::setting_missing, "identify", "no recording is named",
                "name CSV, MAT, C3D or .xlsx files, or a sheet with --study");
  const Model model = model_or_built_in(options.model);
  require_controller(options.controller, model.protocol, model_name(options.model));
  reading.truth = recordings.known(model.parameters());
  reading.body = recordings.body();
  recordings.find_sources({options.model, options.groups.table, recordings.study}, options.outputs.files(),
                          options.common.quiet);
  const RecordingPlan plan = recordings.plan(reading, options.common.quiet);
  std::vector<std::string> inputs = recordings.distinct_files();
  inputs.insert(inputs.end(), {recordings.study, options.model, options.groups.table});
  options.outputs.check(inputs);
  const GroupTable groups = read_groups(options.groups, recordings, plan, options.common.quiet);

  Report report = identify_all(options, model, plan, inputs);
  if (!is_root()) return;
  warn_of_same_sway(report.recordings);
  if (options.groups.given()) report.groups = report_groups(groups, report);
  report.model = model_name(options.model);
  report.options = command.given(options_reported_elsewhere);
  if (options.common.json || options.outputs.needs_hashes()) {
    report.model_sha256 = nn::weights_sha256(model.network);  // a millisecond that text does without
    report.call = record_call(command, inputs, recordings.named);
  }
  options.outputs.refuse_alone(report, options.common.json);
  options.outputs.write(report, options.common.json);
  tell_errors("identify", report.recordings);
}

}  // namespace

void add_identify(const Command& program) {
  auto options = std::make_shared<IdentifyOptions>();
  const Command command =
      program.add_subcommand("identify", "Estimate balance-control parameters from sway recordings");
  add_recording_flags(command, options->recordings);
  add_study_option(command, options->recordings);
  add_body_options(command, options->recordings);
  add_truth_option(command, options->recordings);
  command.section("Model");
  command.add_option("--model", options->model, "Use this model file; default: the built-in model");
  add_controller_of_model(command, options->controller);
  const auto refuse_protocol = [](std::string&) {
    return std::string(
        "--protocol: identify uses the protocol of its model; fit another one with decid fit --protocol, or give a "
        "model of it with --model");
  };
  command.add_option("--protocol", options->protocol, "").rewritten(refuse_protocol, "").section("").unrecorded();
  add_report_options(command, options->outputs, false);
  add_group_options(command, options->groups);
  command.footer(
      "Examples:\n"
      "  decid identify recording.csv --mass 70 --height 1.75 -o result.json --report report.html\n"
      "  decid identify trial.mat --column COM_x --unit rad --detrend offset\n"
      "  decid identify trial.c3d --hip HIP_x --shoulder ACROMION_x --ankle ANK_x --mass 70 --height 1.75\n"
      "  decid identify lab.csv --tilt-column platform_deg --fill-gaps 0.1\n"
      "  decid identify recordings --table results.csv --group groups.csv\n"
      "  decid identify long.csv --trial subject,trial --table results.csv\n"
      "  decid identify --study participants.tsv --table results.xlsx --long long.csv\n"
      "A recording that cannot be used does not stop the others: its JSON entry has \"error\", and the exit code is "
      "2.");
  run_with(command, options, true, run_identify);
}

}  // namespace decid::tools
