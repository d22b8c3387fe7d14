// Studies in C: the recordings of a sheet, identified or fitted, and the comparison of their participants, as JSON.
#include <filesystem>
#include <numeric>

#include "base/setting.hpp"
#include "bindings/c/handles.hpp"
#include "identify/compared_controllers.hpp"
#include "identify/study/find_recordings.hpp"
#include "identify/study/joint_groups.hpp"
#include "identify/study/plan_groups.hpp"
#include "identify/study/study_results.hpp"
#include "tools/report/json/report_json.hpp"

using namespace decid::c;

struct decid_study {
  std::string json;
};

namespace {

constexpr const char* study_where = "decid_study_run";

/// The options that change the results, as the program's options of the same meaning.
struct AskedStudy {
  std::vector<std::string> within, covariates;
  std::string joint, free;
  bool by_group, is_fit;
  std::vector<const decid::sim::BodyModel*> controllers;  // to fit
  const decid_study_options& options;

  AskedStudy(const decid_study_options& from, const decid::sim::Protocol& protocol)
      : within(decid::split_columns(text_or_empty(from.within))),
        covariates(decid::split_columns(text_or_empty(from.covariates))),
        joint(text_or_empty(from.joint)),
        free(text_or_empty(from.free)),
        by_group(from.by_group != 0),
        is_fit(from.fit != 0),
        controllers(
            decid::controllers_to_fit(text_or_empty(from.controllers), protocol, decid::setting("controllers"))),
        options(from) {
    if (!text_or_empty(from.controllers).empty() && !is_fit)
      throw decid::Error(decid::Code::setting_conflict, study_where, "controllers are only for fits", "set fit too");
    if (controllers.size() > 1 && !joint.empty())
      throw decid::Error(decid::Code::setting_conflict, study_where, "joint does not go with several controllers",
                         "fit them in calls of their own");
    if (!joint.empty() && !is_fit)
      throw decid::Error(decid::Code::setting_conflict, study_where, "joint is only for fits", "set fit too");
    if (!free.empty() && joint.empty())
      throw decid::Error(decid::Code::setting_conflict, study_where, "free is for recordings that are fitted together",
                         "set joint too");
    if (!free.empty() && compares())
      throw decid::Error(decid::Code::setting_conflict, study_where,
                         "free does not go with a comparison of participants, whose joint fit counts once",
                         "compare participants in a call without it");
  }
  bool compares() const { return by_group || !within.empty() || !covariates.empty(); }
};

decid::GroupTable make_groups(const AskedStudy& asked, const decid::RecordingPlan& plan, const std::string& sheet) {
  if (!asked.compares()) return {};
  decid::GroupTable groups = decid::groups_of_plan(plan, asked.by_group);
  decid::refuse_groups(groups.members, sheet, asked.within.empty() && asked.covariates.empty() ? 2 : 1, &plan);
  for (const std::string& column : asked.within) decid::compare_within(column, plan, groups);
  for (const std::string& column : asked.covariates) decid::add_covariate(column, plan, groups);
  return groups;
}

/// The fraction that is done of all fits, for a callback that may stop them.
class StudyProgress {
 public:
  StudyProgress(const decid_study_options& asked, std::size_t recordings) : asked_(asked), done_(recordings) {}

  bool operator()(std::size_t recording, const decid::posterior::Progress& now) {
    done_[recording] = now.done;
    const double all = std::accumulate(done_.begin(), done_.end(), 0.0) / static_cast<double>(done_.size());
    if (asked_.progress != nullptr && asked_.progress(asked_.user, all, now.stage) != 0) stopped_ = true;
    return !stopped_;
  }
  bool stopped() const { return stopped_; }

 private:
  const decid_study_options& asked_;
  std::vector<double> done_;
  bool stopped_ = false;
};

decid::Report fit(const decid_model& model, const decid::sim::Protocol& protocol, const decid::RecordingPlan& plan,
                  const AskedStudy& asked, const std::vector<std::string>& freed,
                  const std::vector<decid::FitGroup>& joint, std::vector<std::string>& inputs) {
  decid::FitRequest request;
  request.freed = freed;
  set_sampler(request.settings, asked.options.seed, asked.options.max_draws, study_where);
  for (const decid::sim::BodyModel* other : std::span(asked.controllers).subspan(1)) request.others.push_back({other});
  decid::PlanFitter fitter(&model.model, protocol, plan, request, &inputs);
  decid::Report report = fitter.report();
  std::vector<std::size_t> places(plan.recordings.size());
  std::iota(places.begin(), places.end(), std::size_t{0});
  report.recordings = fitter.read(places);
  StudyProgress progress(asked.options, places.size());
  fitter.fit(
      report.recordings, [&](std::size_t i, const decid::posterior::Progress& now) { return progress(i, now); }, {},
      joint);
  if (progress.stopped()) throw Stopped{study_where};
  decid::warn_of_same_sway(report.recordings);
  return report;
}

/// Returns the path of the model's file; empty for the built-in one.
std::string path_of(const decid_model& model) {
  return model.name == decid::model_name({}) ? std::string() : model.name;
}

/// Sets the call of the program that gives the same results, and its options.
void set_call(const AskedStudy& asked, const std::string& sheet, const decid_model& model,
              const std::vector<std::string>& inputs, decid::Report& report) {
  report.call = {asked.is_fit ? "fit" : "identify", {}, decid::tools::hash_inputs(inputs), {}};
  const auto add = [&](const std::string& option, const std::string& value, bool is_answers = false) {
    if (value.empty()) return;
    report.call.arguments.push_back(option + "=" + value);
    if (is_answers) report.options.push_back(option + " " + value);
  };
  add("--study", sheet);
  add("--model", path_of(model));
  add("--controller", text_or_empty(asked.options.controllers));
  add("--joint", asked.joint, true);
  add("--free", asked.free, true);
  if (asked.is_fit) {
    report.call.seed = asked.options.seed;
    add("--max-draws", std::to_string(asked.options.max_draws), true);
    add("--seed", std::to_string(asked.options.seed), true);
  }
  add("--group", asked.by_group ? sheet : std::string());
  add("--within", text_or_empty(asked.options.within));
  add("--covariates", text_or_empty(asked.options.covariates));
}

std::unique_ptr<decid_study> run_study(const decid_model& model, const std::string& sheet, const AskedStudy& asked) {
  const std::filesystem::path folder = std::filesystem::path(sheet).parent_path();
  const decid::RecordingPlan plan =
      make_plan(decid::read_sheet(sheet), decid::make_sources(decid::recordings_below(folder), {}),
                decid::Choice::by_sheet, decid::ReadOptions{});
  decid::GroupTable groups = make_groups(asked, plan, sheet);
  decid::sim::Protocol protocol = model.model.protocol;
  protocol.experiment.body_model = asked.controllers.front();
  const decid::FreedParameters freed = decid::read_freed(asked.free, protocol.parameters());
  const std::vector<decid::FitGroup> joint =
      asked.joint.empty() ? std::vector<decid::FitGroup>() : decid::joint_groups(plan, asked.joint, freed.conditions);
  decid::refuse_joint_cells(groups, joint);
  std::vector<std::string> inputs;
  for (const decid::PlannedRecording& one : plan.recordings) inputs.push_back(one.source.file.string());
  inputs.insert(inputs.end(), {sheet, path_of(model)});
  decid::Report report = asked.is_fit ? fit(model, protocol, plan, asked, freed.names, joint, inputs)
                                      : decid::identify_plan(model.model, model.name, plan, &inputs);
  if (asked.compares()) report.groups = report_groups(std::move(groups), report);
  report.model = model.name;
  report.model_sha256 = model.sha256;
  set_call(asked, sheet, model, inputs, report);
  return std::make_unique<decid_study>(decid_study{decid::tools::report_json(report)});
}

}  // namespace

void decid_study_defaults(decid_study_options* options, size_t size) {
  const decid::FitRequest request;
  decid_study_options defaults{};
  defaults.max_draws = request.settings.max_draws;
  defaults.seed = request.settings.seed;
  set_defaults(options, size, defaults);
}
decid_status decid_study_run(const decid_model* model, const char* sheet, const decid_study_options* options,
                             decid_study** study) {
  return made(study, study_where, [&] {
    const decid_study_options all = options_of(options, decid_study_defaults, study_where);
    const decid_model& answering = given(model, study_where, "model");
    return run_study(answering, &given(sheet, study_where, "sheet"), AskedStudy(all, answering.model.protocol));
  });
}
void decid_study_free(decid_study* study) {
  delete study;
}
const char* decid_study_json(const decid_study* study) {
  return study == nullptr ? nullptr : study->json.c_str();
}
