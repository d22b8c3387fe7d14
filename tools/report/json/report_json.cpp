// Reports as JSON: see report_json.hpp.
#include "tools/report/json/report_json.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <set>
#include <vector>

#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/files/sha256.hpp"
#include "identify/compared_controllers.hpp"
#include "identify/study/sidecar.hpp"
#include "recording/formats/motion_bids.hpp"
#include "sim/protocol/protocol_object.hpp"
#include "sim/segments.hpp"
#include "tools/report/json/frf.hpp"
#include "tools/report/json/groups_json.hpp"
#include "tools/report/json/parameters_json.hpp"
#include "tools/report/json/posterior_results.hpp"
#include "tools/report/json/recording_json.hpp"

namespace decid::tools {
namespace {

using posterior::Density;
using posterior::Posterior;

Json diagnostics_json(const Posterior& found, const sim::ParameterTable& table) {
  Json json = common_diagnostics(found, table.names(), {"sensor_noise_deg", "start_s", "gain"});
  for (std::size_t p = 0; p < table.size(); ++p) {
    json["tail_effective_draws"][table[p].name] = number_or_null(found.tail_effective_draws(static_cast<int>(p)));
    json["monte_carlo_error"][table[p].name] = number_or_null(found.monte_carlo_error(static_cast<int>(p)));
  }
  json["divergences"] = found.divergences();
  json["energy_fraction"] = number_or_null(found.energy_fraction());
  json["restarts"] = found.restarts();
  json["gradients"] = found.leapfrog_steps();
  return json;
}

Json check_json(const PredictiveCheck& check) {
  Json figures = Json::array();
  for (const CheckedFigure& figure : check.figures)
    figures.push_back({{"name", figure.name},
                       {"unit", figure.in_degrees ? "deg" : "1"},
                       {"recorded", number_or_null(figure.recorded)},
                       {"simulated", number_or_null(figure.middle)},
                       {"simulated_interval90", {number_or_null(figure.low), number_or_null(figure.high)}},
                       {"p", figure.p}});
  return {{"trials", PredictiveCheck::trials}, {"standing", check.standing}, {"figures", std::move(figures)}};
}

Json left_out_json(const FitFigures& fitted) {
  const posterior::LeaveOneOut& left_out = fitted.inferred.left_out;
  return {{"value", left_out.log_density},
          {"standard_error", left_out.standard_error},
          {"effective_parameters", left_out.effective_parameters},
          {"blocks", fitted.inferred.recorded_blocks.size()},
          {"block_s", fitted.block_s},
          {"max_shape", number_or_null(left_out.max_shape)},
          {"unreliable_blocks", left_out.unreliable}};
}

/// The values, ranges and priors of the parameters, and their uncertainty.
Json parameters_of(const RecordingResult& id, const Report& report, const sim::ParameterTable& table) {
  const double mgh = report.protocol_for(id).experiment.body.mgh();
  const std::vector<posterior::ParameterPrior> priors = report.priors_for(id).parameters;
  Json list = parameters_json(table, id.estimate.parameters, mgh, id.truth);
  for (std::size_t p = 0; p < table.size(); ++p) {
    list[p]["range"] = {table[p].low, table[p].high};
    const auto prior = std::ranges::find(priors, table[p].name, &posterior::ParameterPrior::name);
    if (prior != priors.end() && prior->normal)
      list[p]["prior"] = {{"mean", prior->normal->mean}, {"sd", prior->normal->sd}};
    if (prior != priors.end() && prior->fixed) list[p]["fixed"] = true;
  }
  use_distribution(id, [&](const auto& found) {
    for (std::size_t p = 0; p < table.size(); ++p) add_found(list[p], found, p, table[p], mgh);
  });
  return list;
}

sim::Protocol with_controller(sim::Protocol protocol, const std::string& name) {
  protocol.experiment.body_model = &sim::find_body_model(name, "controller");
  return protocol;
}

Json compared_json(const std::string& controller, const posterior::ComparedModel& compared, bool comparable) {
  return {{"controller", controller},
          {"comparable", comparable},
          {"log_predictive_density", compared.log_density},
          {"difference", compared.difference},
          {"difference_standard_error", compared.standard_error},
          {"weight", compared.weight}};
}

/// All fitted controllers, the one that answers first; the others with their parameters.
Json controllers_json(const FitFigures& fitted, const sim::Protocol& protocol) {
  Json list = Json::array({compared_json(protocol.experiment.body_model->name, *fitted.compared, fitted.comparable)});
  const double mgh = protocol.experiment.body.mgh();
  for (const ControllerFit& other : fitted.others) {
    Json& json = list.emplace_back(compared_json(other.controller, other.compared, other.comparable));
    const sim::Protocol of_other = with_controller(protocol, other.controller);
    const sim::ParameterTable table = of_other.ranges();
    sim::Parameters means(table.size());
    for (std::size_t p = 0; p < table.size(); ++p) means[p] = other.posterior.mean(static_cast<int>(p));
    json["parameters"] = parameters_json(table, means, mgh, {});
    for (std::size_t p = 0; p < table.size(); ++p) add_found(json["parameters"][p], other.posterior, p, table[p], mgh);
    json["correlations"] = correlations_json(other.posterior, table.size());
    json["diagnostics"] = diagnostics_json(other.posterior, table);
    json["predictive_check"] = check_json(other.check);
    json["warnings"] = warnings_json(other.warnings);
  }
  return list;
}

void add_fit(Json& recording, const FitFigures& fitted, const sim::Protocol& protocol,
             const sim::ParameterTable& table) {
  const Posterior& found = fitted.posterior;
  recording["sensor_noise_deg"] = quantity_json(found, Density::sensor_noise);
  recording["sensor_noise_deg"]["of_samples"] = fitted.samples_noise_deg;
  // Chains hold the memory, and the ratio of this noise to the white one, while they draw: no interval.
  recording["slow_noise_deg"] = {{"value", found.mean(Density::slow_noise)},
                                 {"memory_s", found.mean(Density::slow_memory)}};
  recording["start_s"] = quantity_json(found, Density::start);
  recording["gain"] = quantity_json(found, Density::gain);
  recording["diagnostics"] = diagnostics_json(found, table);
  recording["predictive_check"] = check_json(fitted.check);
  recording["log_predictive_density"] = left_out_json(fitted);
  recording["fit"]["answer"] = name(fitted.answer);
  if (fitted.compared) recording["controllers"] = controllers_json(fitted, protocol);
  if (fitted.joint) {
    recording["joint"] = {{"recordings", fitted.joint->files}, {"free", fitted.joint->freed}};
    if (!fitted.joint->freed.empty()) recording["joint"]["condition"] = fitted.joint->condition;
  }
}

/// The study's columns of a recording, and its own body and protocol.
Json sheet_json(const RecordingResult& id, const Report& report) {
  Json columns = Json::object();
  for (std::size_t i = 0; i < report.sheet->columns.size(); ++i)
    columns[report.sheet->columns[i]] = text_or_null(id.entry.cells.at(i));
  Json json{{"participant_id", text_or_null(id.entry.participant)},
            {"session", text_or_null(id.entry.session)},
            {"group", text_or_null(id.entry.group)},
            {"condition", text_or_null(id.entry.condition)},
            {"columns", std::move(columns)}};
  if (id.error) return json;
  json["protocol"] = report.protocol_for(id).name;
  json["body"] = body_json(report.protocol_for(id).experiment.body, report.setting_of(id).body_assumed);
  return json;
}

/// The sheet, and the protocols of its recordings, without their bodies' differences.
Json study_sheet_json(const Report& report) {
  Json protocols = Json::object();
  for (const RecordingResult& id : report.recordings)
    if (!id.error && !protocols.contains(report.protocol_for(id).name))
      protocols[report.protocol_for(id).name] = sim::to_json_object(report.protocol_for(id));
  return {
      {"sheet", report.sheet->file.string()}, {"columns", report.sheet->columns}, {"protocols", std::move(protocols)}};
}

/// A recording's object.
Json recording_json(const RecordingResult& id, const Report& report) {
  Json recording{{"file", id.file}};
  if (report.sheet) recording.update(sheet_json(id, report));
  if (id.error) {
    recording["error"] = id.error->what();
    recording["code"] = name(id.error->code());
    return recording;
  }
  const sim::ParameterTable table = report.ranges_for(id);
  const Explanation& explanation = id.explanation;
  recording["parameters"] = parameters_of(id, report, table);
  recording["fit"] = {{"rms_residual_deg", number_or_null(explanation.rms_residual_deg)},
                      {"variance_accounted_for", number_or_null(explanation.variance_accounted_for)}};
  recording["peak_to_peak_deg"] = id.peak_to_peak_deg();
  recording["response_ratio"] = number_or_null(explanation.response_ratio);
  recording["ood_score"] = number_or_null(explanation.ood_score);
  if (id.trial.tilt) recording["tilt"] = tilt_to_json(id, number_or_null);
  recording["gaps"] = Json::array();
  for (const SampleRange& gap : id.trial.gaps) {
    const double rate_hz = report.protocol_for(id).experiment.sample_rate_hz;
    recording["gaps"].push_back(
        {{"begin_s", static_cast<double>(gap.first) / rate_hz}, {"end_s", static_cast<double>(gap.end) / rate_hz}});
  }
  if (const std::optional<recording::LowPass>& filter = id.trial.low_pass)
    recording["low_pass"] = {
        {"cutoff_hz", filter->cutoff_hz},
        {"order", filter->order},
        {"both_ways", filter->both_ways},
        {"average_s", filter->averaged > 0 ? Json(filter->averaged / filter->rate_hz) : Json(nullptr)},
        {"gain_at_2.5_hz", filter->gain_at(recording::low_pass_hz)}};
  recording["frf"] = explanation.frf ? frf_to_json(*explanation.frf) : Json(nullptr);
  recording["trust"] = name(id.trust());
  recording["warnings"] = warnings_json(id.warnings);
  use_distribution(id, [&](const auto& found) { recording["correlations"] = correlations_json(found, table.size()); });
  if (id.fit) add_fit(recording, *id.fit, report.protocol_for(id), table);
  return recording;
}

Json controller_sums_json(const ControllerSums& sums) {
  Json list = Json::array();
  for (const SummedController& one : sums.controllers)
    list.push_back({{"controller", one.name},
                    {"best_in", one.best_in},
                    {"log_predictive_density", one.log_density},
                    {"difference", one.difference},
                    {"difference_standard_error", one.standard_error}});
  return {{"recordings", sums.recordings},
          {"not_usable", sums.not_usable},
          {"not_comparable", sums.not_comparable},
          {"controllers", std::move(list)}};
}

}  // namespace

Json recordings_json(const Report& report) {
  Json list = Json::array();
  for (std::size_t i = 0; i < report.recordings.size(); ++i) {
    Json& recording = list.emplace_back(recording_json(report.recordings[i], report));
    if (!report.groups || report.groups->table.members[i].group.empty()) continue;
    if (report.groups->table.has_groups) recording["group"] = report.groups->table.members[i].group;
    if (!report.groups->table.participant_column.empty())
      recording["participant_id"] = report.groups->table.members[i].participant;
  }
  return list;
}

std::optional<sim::Participant> find_participant(const sim::Body& body) {
  try {
    return sim::make_participant(body);
  } catch (const Error&) {
    return {};
  }
}

std::string hash_file(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"), std::fclose);
  Sha256 hash;
  std::vector<char> piece(1 << 20);
  while (file) {
    const std::size_t bytes = std::fread(piece.data(), 1, piece.size(), file.get());
    hash.update(piece.data(), bytes);
    if (std::ferror(file.get()) != 0) break;
    if (bytes < piece.size()) return hash.hex();
  }
  return sha256(read_file(path));  // throws the error of a file that cannot be read
}

std::vector<InputFile> hash_inputs(const std::vector<std::string>& files) {
  std::vector<InputFile> inputs;
  std::set<std::string> seen{""};
  const auto add = [&](const std::string& file) {
    if (!seen.insert(file).second) return;
    std::error_code ignored;
    const bool is_file = std::filesystem::is_regular_file(file, ignored);
    inputs.push_back({file, is_file ? hash_file(file) : std::string()});
  };
  for (const std::string& file : files) {
    add(file);
    for (const std::filesystem::path& beside : recording::files_beside(file)) add(beside.string());
    if (const std::optional<std::filesystem::path> sidecar = sidecar_of(file)) add(sidecar->string());
  }
  return inputs;
}

Json body_json(const sim::Body& body, bool assumed) {
  Json json{{"mass_kg", body.mass_kg},
            {"com_height_m", body.com_height_m},
            {"inertia_kgm2", body.inertia_kgm2},
            {"assumed", assumed}};
  // Without the rounding of the way to the body and back: 70, not 69.99999999999999.
  const auto as_given = [](double value) { return std::round(value * 1e9) / 1e9; };
  if (const std::optional<sim::Participant> participant = find_participant(body))
    json["participant"] =
        Json{{"mass_kg", as_given(participant->mass_kg)}, {"height_m", as_given(participant->height_m)}};
  return json;
}

/// Returns the body of the recordings; null if they have several.
Json report_body_json(const Report& report) {
  std::optional<std::pair<sim::Body, bool>> first;
  for (const RecordingResult& id : report.recordings) {
    if (id.error) continue;
    const std::pair<sim::Body, bool> own(report.protocol_for(id).experiment.body, report.setting_of(id).body_assumed);
    if (first && own != *first) return nullptr;
    first = own;
  }
  return body_json(report.protocol.experiment.body, report.body_assumed);
}

std::string report_json(const Report& report) {
  Json json{{"model", report.model},
            {"model_sha256", report.model_sha256},
            {"controller", report.protocol.experiment.body_model->name},
            {"options", report.options},
            {"protocol", sim::to_json_object(report.protocol)},
            {"body", report_body_json(report)},
            {"other_answer", other_answer_json(report)},
            {"recordings", recordings_json(report)}};
  add_call(json, report.call);
  if (report.sheet) json["study"] = study_sheet_json(report);
  if (const std::optional<ControllerSums> sums = sum_controllers(report))
    json["controller_comparison"] = controller_sums_json(*sums);
  if (report.groups) json.update(groups_json(report));
  return print_json(json) + "\n";
}

}  // namespace decid::tools
