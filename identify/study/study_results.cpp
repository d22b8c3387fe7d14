// Recordings of a plan: see study_results.hpp.
#include "identify/study/study_results.hpp"

#include <algorithm>
#include <cstddef>
#include <map>
#include <numeric>
#include <string_view>
#include <utility>

#include "base/parallel.hpp"
#include "base/text.hpp"
#include "recording/protocol_file.hpp"
#include "sim/body_model.hpp"
#include "sim/segments.hpp"

namespace decid {

void set_planned(RecordingResult& result, const PlannedRecording& planned) {
  result.setting = planned.setting;
  result.entry = planned.entry;
  result.mass_kg = planned.mass_kg;
  result.height_m = planned.height_m;
  Warnings missing;
  for (const Warning& warning : planned.warnings)
    if (std::ranges::find(result.warnings, warning) == result.warnings.end()) missing.push_back(warning);
  if (!missing.empty()) result.warnings = most_severe_first({missing, result.warnings});
}

namespace {

/// Returns the error of a recording's setting, at the line of the sheet that gives the setting.
Error at_line(const Error& error, const PlannedRecording& planned) {
  if (planned.line.empty()) return error;
  return {error.code(), planned.line, error.where() + ": " + error.problem(), error.remedy()};
}

/// Reads recordings by their places. protocols: of each setting; null: the setting has the error.
std::vector<RecordingResult> read_places(const RecordingPlan& plan, std::span<const std::size_t> places,
                                         const std::vector<const sim::Protocol*>& protocols,
                                         const std::vector<std::optional<Error>>& errors) {
  std::map<const sim::Protocol*, recording::ProtocolPlan> plans;
  for (const sim::Protocol* protocol : protocols)
    if (protocol != nullptr) plans.try_emplace(protocol, *protocol);
  std::vector<RecordingResult> all(places.size());
  parallel_for(static_cast<int>(places.size()), [&](int place) {
    const auto i = static_cast<std::size_t>(place);
    const PlannedRecording& planned = plan.recordings[places[i]];
    const std::optional<Error>& of_setting = errors[planned.setting];
    if (planned.error || of_setting) {
      all[i].file = planned.source.name();
      all[i].error = planned.error ? *planned.error : at_line(*of_setting, planned);
    } else {
      all[i] = read_source(plans.at(protocols[planned.setting]), planned.source, planned.reading);
    }
    set_planned(all[i], planned);
  });
  return all;
}

/// Stores an error of a setting, or throws it if the plan has no sheet.
void keep_or_throw(const RecordingPlan& plan, const Error& error, std::optional<Error>& kept) {
  if (!plan.sheet) throw error;
  kept = error;
}

/// Returns the body of a setting: the given one, else its protocol's; empty: the model's is assumed. Throws Error
/// unless the model's network covers the experiment of the protocol, and if that has a body that is not a person's and
/// not the model's.
std::optional<sim::Body> body_of(const Model& model, const std::string& name, const RecordingSetting& setting,
                                 std::vector<std::string>* files) {
  if (setting.protocol.empty()) return setting.body;
  sim::Experiment asked = recording::load_protocol(setting.protocol, files).experiment;
  const sim::Body own = std::exchange(asked.body, model.protocol.experiment.body);
  if (asked != model.protocol.experiment)
    throw Error(Code::protocol_mismatch, "protocol " + setting.protocol, "is not the protocol of " + name,
                "fit these recordings (decid fit), or give a model of this protocol");
  if (own == model.protocol.experiment.body) return setting.body;
  if (!sim::is_person(own))
    throw Error(Code::protocol_mismatch, "protocol " + setting.protocol,
                "has a body that is not a person's, m g h " + sim::mgh_text(own.mgh()) +
                    " N m/rad, which the network of " + name + " does not know",
                "fit these recordings (decid fit), without a weight and a height, or give a model of this body");
  if (setting.body || own == sim::Body{}) return setting.body;
  return own;
}

/// Throws Error if a person's body would replace another one of a sheet's protocol.
void refuse_person_of_sheet(const sim::Body& body, const sim::Protocol& its_own) {
  try {
    sim::refuse_person(body, its_own, "protocol " + its_own.name);
  } catch (const Error& error) {
    throw Error(error.code(), error.where(), error.problem(),
                "leave weight and height out of this recording's lines; if the call gives the person's body, or a "
                "protocol that has one, fit recordings of people in a call of their own");
  }
}

/// Sets the controller of a sheet's protocol to the call's. Throws Error if it names one that the call does not fit.
void use_controller(sim::Protocol& its_own, const sim::Protocol& protocol, const FitRequest& request) {
  const sim::BodyModel *const named = its_own.experiment.body_model, *const asked = protocol.experiment.body_model;
  const bool is_fitted =
      (named == &sim::single_pendulum() && !its_own.names_controller) || named == asked ||
      std::ranges::find(request.others, named, &FitRequest::Other::controller) != request.others.end();
  if (!is_fitted)
    throw Error(Code::setting_conflict, "protocol " + its_own.name,
                "names the controller " + named->name + ", and this call fits " + asked->name,
                "fit recordings of one controller in a call");
  its_own.experiment.body_model = asked;
}

/// Returns a note on priors of gains, which are in N m/rad or N m s/rad, where the bodies' m g h differ.
Warnings prior_warnings(const FitRequest& request, const sim::ParameterTable& parameters,
                        std::span<const double> mgh_nm_rad) {
  Warnings warnings;
  std::vector<std::string> gains;
  const auto add = [&](const std::vector<posterior::ParameterPrior>& priors, const sim::ParameterTable& table) {
    for (const posterior::ParameterPrior& prior : priors) {
      const auto found = std::ranges::find(table, prior.name, &sim::ParameterInfo::name);
      const bool in_si = (prior.range && !prior.over_mgh.range) || (prior.normal && !prior.over_mgh.normal) ||
                         (prior.fixed && !prior.over_mgh.fixed);
      if (found != table.end() && found->scales_with_mgh && in_si &&
          std::ranges::find(gains, prior.name) == gains.end())
        gains.push_back(prior.name);
    }
  };
  add(request.priors.parameters, parameters);
  for (const FitRequest::Other& other : request.others) add(other.parameters, other.controller->parameters);
  if (gains.empty() || mgh_nm_rad.empty()) return warnings;
  const auto [low, high] = std::ranges::minmax(mgh_nm_rad);
  if (high <= low * (1.0 + 1e-9)) return warnings;
  add_info(warnings, "priors_of_all_bodies",
           format("the given range, prior or value of %s is in SI units and the same for all bodies of the call, whose "
                  "m g h is %s to %s N m/rad: relative to m g h it differs from body to body; %s/mgh takes values "
                  "over m g h",
                  joined(gains, ", ").c_str(), sim::mgh_text(low).c_str(), sim::mgh_text(high).c_str(),
                  gains.front().c_str()));
  return warnings;
}

}  // namespace

PlanIdentifier::PlanIdentifier(const Model& model, const std::string& name, const RecordingPlan& plan,
                               std::size_t at_once, std::vector<std::string>* files)
    : model_(model), plan_(plan), at_once_(at_once), errors_(plan.settings.size()) {
  for (std::size_t k = 0; k < plan.settings.size(); ++k) {
    bodies_.push_back(for_body(model, name, {}));
    try {
      bodies_[k] = for_body(model, name, body_of(model, name, plan.settings[k], files));
    } catch (const Error& error) {
      keep_or_throw(plan, error, errors_[k]);
    }
  }
  if (bodies_.empty()) bodies_.push_back(for_body(model, name, {}));
}
PlanIdentifier::~PlanIdentifier() = default;

Identifier& PlanIdentifier::identifier(std::size_t setting) {
  if (!identifier_ || setting != current_)
    identifier_ = std::make_unique<Identifier>(model_, bodies_[setting], at_once_);
  current_ = setting;
  return *identifier_;
}

Report PlanIdentifier::report() {
  Report report = make_report(identifier(0));
  for (std::size_t k = 1; k < bodies_.size(); ++k)
    report.other_settings.push_back({bodies_[k].protocol, bodies_[k].assumed, report.tilt_rad});
  report.sheet = plan_.sheet;
  return report;
}

std::vector<RecordingResult> PlanIdentifier::identify(std::span<const std::size_t> places) {
  const std::vector<const sim::Protocol*> protocols(plan_.settings.size(), &model_.protocol);
  std::vector<RecordingResult> all = read_places(plan_, places, protocols, errors_);
  for (std::size_t first = 0; first < all.size();) {
    // Neighbours of one setting go through the network together.
    std::size_t last = first + 1;
    while (last < all.size() && all[last].setting == all[first].setting) ++last;
    if (!errors_[all[first].setting])
      identifier(all[first].setting).identify(std::span(all).subspan(first, last - first));
    first = last;
  }
  return all;
}

PlanFitter::PlanFitter(const Model* model, const sim::Protocol& protocol, const RecordingPlan& plan,
                       const FitRequest& request, std::vector<std::string>* files)
    : plan_(plan), fitters_(plan.settings.size()), errors_(plan.settings.size()) {
  none_.protocol = protocol;
  none_.fit = request;
  none_.fit->priors = posterior::with_conventions(request.priors, protocol.ranges());
  for (std::size_t k = 0; k < plan.settings.size(); ++k) {
    const RecordingSetting& setting = plan.settings[k];
    try {
      sim::Protocol its_own = setting.protocol.empty() ? protocol : recording::load_protocol(setting.protocol, files);
      use_controller(its_own, protocol, request);
      std::optional<sim::Body> body = setting.body;
      if (body && setting.protocol.empty()) sim::refuse_person(*body, its_own, "protocol " + its_own.name);
      if (body && !setting.protocol.empty()) refuse_person_of_sheet(*body, its_own);
      // A body that is not a person's is of the call's protocol: the line's own protocol may describe another one.
      if ((!body || !sim::is_person(*body)) && !setting.protocol.empty() && its_own.experiment.body != sim::Body{})
        body = its_own.experiment.body;
      fitters_[k] = std::make_unique<Fitter>(model, std::move(its_own), body, request);
    } catch (const Error& error) {
      keep_or_throw(plan, error, errors_[k]);
    }
  }
  std::vector<double> mgh_nm_rad;  // of bodies that are fitted
  for (const PlannedRecording& planned : plan.recordings)
    if (!planned.error && fitters_[planned.setting])
      mgh_nm_rad.push_back(fitters_[planned.setting]->report().protocol.experiment.body.mgh());
  of_bodies_ = prior_warnings(request, protocol.parameters(), mgh_nm_rad);
}

Report PlanFitter::report() const {
  const auto of_setting = [&](std::size_t k) {
    return k < fitters_.size() && fitters_[k] ? fitters_[k]->report() : none_;
  };
  Report report = of_setting(0);
  for (std::size_t k = 1; k < fitters_.size(); ++k) {
    Report other = of_setting(k);
    report.network_answers = report.network_answers && other.network_answers;
    report.other_settings.push_back({std::move(other.protocol), other.body_assumed, std::move(other.tilt_rad)});
  }
  report.sheet = plan_.sheet;
  return report;
}

std::vector<RecordingResult> PlanFitter::read(std::span<const std::size_t> places) const {
  std::vector<const sim::Protocol*> protocols;
  for (const std::unique_ptr<Fitter>& fitter : fitters_)
    protocols.push_back(fitter ? &fitter->report().protocol : nullptr);
  std::vector<RecordingResult> all = read_places(plan_, places, protocols, errors_);
  for (RecordingResult& one : all)
    if (!one.error) append(one.warnings, of_bodies_);
  return all;
}

bool PlanFitter::fit(std::span<RecordingResult> read, const FitProgress& progress, const OnFitted& fitted,
                     std::span<const FitGroup> groups) {
  return fit_each(
      read, [&](std::size_t i) -> Fitter& { return *fitters_[read[i].setting]; }, progress, fitted, groups);
}

void warn_of_same_sway(std::span<RecordingResult> recordings) {
  std::map<std::string_view, std::vector<RecordingResult*>> same;
  for (RecordingResult& one : recordings) {
    if (one.error) continue;
    const std::span<const std::byte> bytes = std::as_bytes(std::span(one.trial.sway_rad()));
    same[{reinterpret_cast<const char*>(bytes.data()), bytes.size()}].push_back(&one);
  }
  for (const auto& [sway, copies] : same)
    for (std::size_t k = 0; copies.size() > 1 && k < copies.size(); ++k) {
      if (has_code(copies[k]->warnings, "same_content")) continue;
      Warnings copied;
      add_caution(copied, "same_content",
                  "has the same sway as " + copies[k == 0 ? 1 : 0]->file +
                      ", sample by sample: a copy is neither another person nor another trial; leave one of them out");
      copies[k]->warnings = most_severe_first({copied, copies[k]->warnings});
    }
}

Report identify_plan(const Model& model, const std::string& name, const RecordingPlan& plan,
                     std::vector<std::string>* files) {
  PlanIdentifier identifier(model, name, plan, plan.recordings.size(), files);
  Report report = identifier.report();
  std::vector<std::size_t> places(plan.recordings.size());
  std::iota(places.begin(), places.end(), std::size_t{0});
  report.recordings = identifier.identify(places);
  warn_of_same_sway(report.recordings);
  return report;
}

}  // namespace decid
