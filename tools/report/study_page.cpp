// The report of decid study: see study_page.hpp. page.cpp makes the page, study.js fills it.
#include "tools/report/study_page.hpp"

#include <cmath>

#include "base/files/json_object.hpp"
#include "base/math/statistics.hpp"
#include "base/text.hpp"
#include "embedded/method_table_js.hpp"
#include "embedded/study_js.hpp"
#include "identify/network/origin_object.hpp"
#include "tools/report/comparison_page.hpp"
#include "tools/report/json/parameters_json.hpp"
#include "tools/report/json/recording_json.hpp"
#include "tools/report/page.hpp"

namespace decid::tools {
namespace {

Json bins_json(const sim::ParameterTable& table, const std::vector<Bin>& bins) {
  Json list = Json::array();
  for (const Bin& bin : bins)
    list.push_back({{"low", bin.low},
                    {"high", bin.high},
                    {"trials", bin.trials},
                    {"mse", number_or_null(mean(bin.mse))},
                    {"mse_per_parameter", by_parameter(table, bin.mse)},
                    {"mean_guess_mse", number_or_null(mean(bin.baseline))}});
  return list;
}

Json known_json(const sim::ParameterTable& table, const KnownTrial& trial) {
  return {{"true", by_parameter(table, trial.truth)},
          {"identified", by_parameter(table, trial.identified)},
          {"squared_error", trial.squared_error()},
          {"mean_squared_error", trial.squared_error() / static_cast<double>(table.size())},
          {"peak_to_peak_rad", trial.peak_to_peak_rad}};
}

Json distribution_json(const sim::ParameterTable& table, const dataset::TrialDistributions& trials) {
  Json json;
  for (std::size_t p = 0; p < table.size(); ++p)
    json[table[p].name] = {{"mean", trials.parameters[p].mean()}, {"sd", trials.parameters[p].stddev()}};
  return json;
}

Json data_json(const sim::ParameterTable& table, const StudyData& data) {
  return {{"file", data.file},
          {"seed", data.seed},
          {"trials", data.training.trials + data.validation.trials},
          {"training_trials", data.training.trials},
          {"validation_trials", data.validation.trials},
          {"base_trials", data.base},
          {"before_enrichment", distribution_json(table, data.before)},
          {"after_enrichment", distribution_json(table, data.all)}};
}

bool has_papers_controller(const ModelStudy& study) {
  return study.protocol.experiment.body_model == &sim::single_pendulum();
}

/// Returns the paper's figures; those of parameters are empty if the model has others.
Json paper_json(const ModelStudy& study) {
  const sim::ParameterTable& table = study.protocol.parameters();
  const auto of_parameters = [&](const auto& values) {
    return has_papers_controller(study) ? by_parameter(table, values) : Json::object();
  };
  return {{"trials", paper::trials},
          {"half", paper::half},
          {"max_epochs", paper::max_epochs},
          {"validation_loss", paper::validation_loss},
          {"training_loss", paper::training_loss},
          {"double_pendulum_squared_error", paper::double_pendulum_squared_error},
          {"human_peak_to_peak_deg", paper::human_peak_to_peak_deg},
          {"mean", of_parameters(paper::mean)},
          {"sd", of_parameters(paper::stddev)}};
}

/// Returns the squared error of a parameter as the paper counts it: over the standard deviation that its table 1
/// prints; NaN if that has no such parameters.
double by_paper(const ModelStudy& study, const Scores& mse_per_parameter, std::size_t p) {
  if (!has_papers_controller(study)) return std::nan("");
  const double ratio = study.target_stddev[p] / paper::stddev[p];
  return mse_per_parameter[p] * ratio * ratio;
}

double mean_by_paper(const ModelStudy& study, const Scores& mse_per_parameter) {
  std::vector<double> errors(mse_per_parameter.size());
  for (std::size_t p = 0; p < errors.size(); ++p) errors[p] = by_paper(study, mse_per_parameter, p);
  return mean(errors);
}

std::string shown(double value, const char* how = "%.4f") {
  return std::isfinite(value) ? format(how, value) : "n/a";
}

/// Rows of the table: what, ours by MSE, by MATLAB's loss and by the paper's standard deviations (or one figure), the
/// paper's.
struct Row {
  std::string what, ours, ours_matlab, ours_by_paper, paper;
};

Row error_row(const ModelStudy& study, const std::string& what, const Evaluation& error, const std::string& paper) {
  return {what, format("%.4f", error.mse()), format("%.4f", error.matlab_loss()),
          shown(mean_by_paper(study, error.mse_per_parameter)), paper};
}

std::vector<Row> study_rows(const ModelStudy& study) {
  std::vector<Row> rows;
  const Evaluation& fresh = study.levels.front().all;
  if (study.data) {
    const StudyData& data = *study.data;
    rows.push_back(
        {"trials", format("%d", data.training.trials + data.validation.trials), "", "", format("%d", paper::trials)});
    rows.push_back({"  training, validation", format("%d, %d", data.training.trials, data.validation.trials), "", "",
                    format("%d, %d", paper::half, paper::half)});
  }
  if (!study.log.empty()) {
    rows.push_back({"epochs", format("%zu", study.log.size()), "", "", format("at most %d", paper::max_epochs)});
    rows.push_back({"  kept", format("%d", kept_epoch(study.log, study.origin.patience).epoch), "", "", ""});
  }
  if (study.data) {
    rows.push_back(error_row(study, "validation half", study.data->validation, format("%.4f", paper::validation_loss)));
    rows.push_back(error_row(study, "training half", study.data->training, format("%.4f", paper::training_loss)));
  }
  for (const NoiseLevel& level : study.levels)
    rows.push_back(
        error_row(study, format("test trials, %g deg measurement noise", level.sensor_noise_deg), level.all, ""));
  const Evaluation& of = study.data ? study.data->validation : fresh;
  const sim::ParameterTable& table = study.protocol.parameters();
  for (std::size_t p = 0; p < table.size(); ++p)
    rows.push_back({format("%s %s", study.data ? "validation," : "test,", table[p].name.c_str()),
                    format("%.4f", of.mse_per_parameter[p]), format("%.4f", 0.5 * of.mse_per_parameter[p]),
                    shown(by_paper(study, of.mse_per_parameter, p)), ""});
  rows.push_back({"guessing the mean", "1", format("%g", 0.5 * static_cast<double>(table.size())),
                  shown(mean_by_paper(study, Scores(table.size(), 1))), ""});
  if (study.dip) {
    const KnownTrial& trial = study.dip->trial;
    const std::string paper = format("%.4f", paper::double_pendulum_squared_error);
    rows.push_back({"double pendulum, SE", format("%.4f", trial.squared_error()), "", "", paper});
    rows.push_back({format("  mean of the %zu", table.size()),
                    format("%.4f", trial.squared_error() / static_cast<double>(table.size())), "", "", ""});
    rows.push_back({format("  SE, mean of %zu trials", study.dip->squared_errors.size()),
                    format("%.4f", mean(study.dip->squared_errors)), "", "", ""});
  }
  if (study.recording)
    rows.push_back({"recording, peak to peak (deg)", format("%.4f", study.recording->peak_to_peak_deg()), "", "",
                    format("%.4f", paper::human_peak_to_peak_deg)});
  for (const auto& [name, seconds] : study.seconds)
    rows.push_back({"time, " + name, duration_text(seconds), "", "", "not given"});
  return rows;
}

/// Columns of the table of faults, after what they are.
std::vector<std::string> fault_cells(const FaultFigures& row) {
  std::vector<std::string> cells{shown(row.errors.mse(), "%.3f")};
  if (row.calibration) {
    cells.push_back(shown(row.calibration->all.predicted_variance, "%.3f"));
    cells.push_back(shown(row.calibration->all.coverage90, "%.3f"));
  } else {
    cells.insert(cells.end(), 2, "n/a");
  }
  cells.push_back(format("%.3f", row.warned));
  return cells;
}

Json faults_json(const sim::ParameterTable& table, const std::vector<FaultFigures>& rows) {
  Json list = Json::array();
  for (const FaultFigures& row : rows) {
    Json entry{{"fault", row.fault.name},
               {"size", row.fault.size},
               {"what", row.fault.text},
               {"trials", row.errors.trials},
               {"mse", number_or_null(row.errors.mse())},
               {"mse_per_parameter", by_parameter(table, row.errors.mse_per_parameter)},
               {"warned", row.warned}};
    if (row.calibration) {
      entry["predicted_variance"] = row.calibration->all.predicted_variance;
      entry["coverage50"] = row.calibration->all.coverage50;
      entry["coverage90"] = row.calibration->all.coverage90;
    }
    list.push_back(std::move(entry));
  }
  return list;
}

std::string faults_convention(const ModelStudy& study) {
  return format(
      "%d test trials of the protocol's own body with %g degrees of measurement noise and one fault each, the same "
      "trials in every row. With twice the tilt: only trials that stand. Leg and trunk: one body with different noise. "
      "Predicted: predicted variance, which should equal the MSE. Cover: coverage of the 90%% interval. Warned: "
      "fraction of recordings with a caution or invalid warning; the first row has the false alarms.",
      study.faults.front().errors.trials, study.faults_noise_deg);
}

std::string convention(const ModelStudy& study) {
  const std::size_t count = study.protocol.parameters().size();
  std::string text = format(
      "MSE: mean over trials and the %zu z-scored parameters, guessing the mean gives 1. MATLAB's loss: half the sum "
      "over the %zu, guessing gives %g; a parameter's share of it is half its MSE. ",
      count, count, 0.5 * static_cast<double>(count));
  if (!has_papers_controller(study))
    return text + format("The paper has the controller dec, this model %s: its figures do not compare.",
                         study.protocol.experiment.body_model->name.c_str());
  return text +
         "The paper does not say which its losses are: as MATLAB's, its 0.2851 is an MSE of 0.0815, and as an MSE a "
         "loss of 0.9979. SE: sum of the 7 squared errors of one trial. By the paper's sd: the MSE with each error "
         "over the standard deviation that the paper's table 1 prints, most of them larger than a uniform range has; "
         "the paper z-scores its targets, so this column compares with its losses.";
}

Json double_pendulum_json(const ModelStudy& study) {
  if (!study.dip) return nullptr;
  Json json = known_json(study.protocol.parameters(), study.dip->trial);
  json["squared_errors"] = study.dip->squared_errors;
  json["squared_error_mean"] = mean(study.dip->squared_errors);
  return json;
}

Json recording_json(const ModelStudy& study) {
  if (!study.recording) return nullptr;
  const RecordingResult& recording = *study.recording;
  return {{"file", recording.file},
          {"identified", by_parameter(study.protocol.parameters(), recording.estimate.parameters)},
          {"peak_to_peak_deg", recording.peak_to_peak_deg()},
          {"rms_residual_deg", number_or_null(recording.explanation.rms_residual_deg)},
          {"variance_accounted_for", number_or_null(recording.explanation.variance_accounted_for)},
          {"warnings", warnings_json(recording.warnings)}};
}

Json level_json(const sim::ParameterTable& table, const NoiseLevel& level) {
  Json json{{"sensor_noise_deg", level.sensor_noise_deg}};
  json.update(evaluation_json(table, level.all));
  json["by_amplitude_deg"] = bins_json(table, level.by_amplitude_deg);
  json["by_nv"] = bins_json(table, level.by_nv);
  return json;
}

/// Returns the errors over the standard deviations that the paper prints.
Json by_paper_json(const ModelStudy& study) {
  const auto error = [&](const Scores& mse) { return number_or_null(mean_by_paper(study, mse)); };
  return {{"training", study.data ? error(study.data->training.mse_per_parameter) : Json(nullptr)},
          {"validation", study.data ? error(study.data->validation.mse_per_parameter) : Json(nullptr)},
          {"fresh", error(study.levels.front().all.mse_per_parameter)},
          {"mean_guess", error(Scores(study.protocol.parameters().size(), 1))}};
}

Json page_data(const ModelStudy& study, const std::vector<Figure>& figures) {
  Json data = study_json(study);
  data["protocol"] = protocol_figures(study.protocol);
  data["convention"] = convention(study);
  data["rows"] = Json::array();
  for (const Row& row : study_rows(study))
    data["rows"].push_back({row.what, row.ours, row.ours_matlab, row.ours_by_paper, row.paper});
  data["faults_convention"] = study.faults.empty() ? "" : faults_convention(study);
  data["fault_rows"] = Json::array();
  for (const FaultFigures& row : study.faults) data["fault_rows"].push_back({row.fault.text, fault_cells(row)});
  data["figures"] = Json::array();
  for (const Figure& f : figures)
    data["figures"].push_back({{"id", f.id}, {"title", f.title}, {"caption", f.caption}, {"svg", f.svg}});
  return data;
}

}  // namespace

Json study_json(const ModelStudy& study) {
  const sim::ParameterTable& table = study.protocol.parameters();
  Json json{{"model", study.model},
            {"weights_sha256", study.sha256},
            {"version", study.version},
            {"origin", to_json_object(study.origin)},
            {"architecture", study.architecture},
            {"network_parameters", study.network_parameters},
            {"data_set", study.data ? data_json(table, *study.data) : Json(nullptr)},
            {"training", nullptr}};
  if (!study.log.empty())
    json["training"] = {{"epochs", study.log.size()},
                        {"kept_epoch", kept_epoch(study.log, study.origin.patience).epoch}};
  json["errors"] = {{"training", study.data ? evaluation_json(table, study.data->training) : Json(nullptr)},
                    {"validation", study.data ? evaluation_json(table, study.data->validation) : Json(nullptr)},
                    {"fresh", evaluation_json(table, study.levels.front().all)}};
  json["sample"] = known_json(table, study.sample.trial);
  json["sample"]["from"] = study.sample.from;
  json["sample"]["index"] = study.sample.index;
  json["double_pendulum"] = double_pendulum_json(study);
  json["recording"] = recording_json(study);
  json["worth"] = Json::array();
  for (const NoiseLevel& level : study.levels) json["worth"].push_back(level_json(table, level));
  json["faults"] = faults_json(table, study.faults);
  json["faults_sensor_noise_deg"] = study.faults_noise_deg;
  json["fresh_seed"] = study.fresh_seed;
  json["learning_curve"] = Json::array();
  for (const LearningPoint& p : study.learning_curve)
    json["learning_curve"].push_back({{"trials", p.trials}, {"mse", p.mse}});
  json["comparisons"] = Json::array();
  for (const ComparisonFigures& comparison : study.comparisons)
    json["comparisons"].push_back(comparison_json(comparison));
  json["mse_by_paper_sd"] = by_paper_json(study);
  json["seconds"] = Json::object();
  for (const auto& [name, seconds] : study.seconds) json["seconds"][name] = seconds;
  json["notes"] = study.notes;
  json["paper"] = paper_json(study);
  return json;
}

std::string study_text(const ModelStudy& study) {
  std::string text = format("%s\n\n%-30s %20s %14s %14s %14s\n", study.model.c_str(), "", "MSE or figure",
                            "MATLAB's loss", "by paper's sd", "the paper");
  for (const Row& row : study_rows(study))
    text += format("%-30s %20s %14s %14s %14s\n", row.what.c_str(), row.ours.c_str(), row.ours_matlab.c_str(),
                   row.ours_by_paper.c_str(), row.paper.c_str());
  if (study.data) {
    text += format("\n%-30s %20s %14s %14s %14s\n", "after enrichment", "mean", "sd", "paper's mean", "paper's sd");
    for (std::size_t p = 0; p < study.protocol.parameters().size(); ++p) {
      const dataset::Distribution& d = study.data->all.parameters[p];
      const bool papers = has_papers_controller(study);
      text += format("%-30s %20.5g %14.5g %14s %14s\n", study.protocol.parameters()[p].name.c_str(), d.mean(),
                     d.stddev(), papers ? shown(paper::mean[p], "%.5g").c_str() : "n/a",
                     papers ? shown(paper::stddev[p], "%.5g").c_str() : "n/a");
    }
  }
  text += "\n" + convention(study) + "\n";
  if (!study.faults.empty()) {
    text += format("\n%-44s %9s %9s %9s %9s\n", "recordings with faults", "MSE", "predicted", "90% cover", "warned");
    for (const FaultFigures& row : study.faults) {
      text += format("%-44s", row.fault.text.c_str());
      for (const std::string& cell : fault_cells(row)) text += format(" %9s", cell.c_str());
      text += "\n";
    }
    text += "\n" + faults_convention(study) + "\n";
  }
  for (const ComparisonFigures& comparison : study.comparisons) text += "\n" + comparison_text(comparison);
  for (const std::string& note : study.notes) text += "Note: " + note + "\n";
  return text;
}

std::string study_html(const ModelStudy& study, const std::vector<Figure>& figures, const Call& call) {
  Json data = page_data(study, figures);
  data["call"] = call_json(call, study.protocol.name);
  const std::string script = std::string(embedded::method_table_js()) + std::string(embedded::study_js());
  return page_html({.title = "Study of a model",
                    .lead = "The paper's results beside this program's, its figures redrawn, and the accuracy of the "
                            "estimates.",
                    .script = script},
                   data);
}

}  // namespace decid::tools
