// The hierarchical model as JSON: see cohort_json.hpp.
#include "tools/report/json/cohort_json.hpp"

#include "base/files/json_object.hpp"
#include "tools/report/json/parameters_json.hpp"

namespace decid::tools {
namespace {

/// Returns a list of what `describe` adds to each parameter's name.
template <class Describe>
Json each_parameter(const sim::ParameterTable& parameters, const Describe& describe) {
  Json list = Json::array();
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    Json& one = list.emplace_back(Json{{"name", parameters[p].name}});
    describe(p, one);
  }
  return list;
}

Json effects_json(const std::vector<cohort::Effect>& effects, const sim::ParameterTable& parameters) {
  return each_parameter(parameters, [&](std::size_t p, Json& one) {
    const cohort::Effect& effect = effects[p];
    one["difference"] = effect.difference.mean;
    one["sd"] = effect.difference.sd;
    one["interval95"] = effect.difference.interval95;
    one["simultaneous95"] = effect.simultaneous95;
    one["standardised"] = effect.standardised.mean;
    one["standardised_interval95"] = effect.standardised.interval95;
    one["probability_of_direction"] = effect.direction;
  });
}

/// The names of a comparison's cells.
Json pair_of(const cohort::Result& found, const cohort::Comparison& comparison) {
  return {found.cells[comparison.first].name(), found.cells[comparison.second].name()};
}

Json covariate_json(const cohort::Covariate& covariate, const sim::ParameterTable& parameters) {
  return {{"name", covariate.name},
          {"mean", covariate.mean},
          {"unknown", covariate.unknown},
          {"parameters", each_parameter(parameters, [&](std::size_t p, Json& one) {
             const cohort::Slope& slope = covariate.slopes[p];
             one["slope"] = slope.mean;
             one["sd"] = slope.sd;
             one["interval95"] = slope.interval95;
             one["probability_of_direction"] = slope.direction;
           })}};
}

}  // namespace

Json cohort_json(const Report& report) {
  if (!report.groups || !report.groups->hierarchical) return nullptr;
  const cohort::Result& found = *report.groups->hierarchical;
  const sim::ParameterTable parameters = report.compared_parameters();
  Json groups = Json::array(), comparisons = Json::array(), interactions = Json::array(), changes = Json::array(),
       covariates = Json::array();
  for (const cohort::Cell& cell : found.cells)
    groups.push_back({{"name", cell.name()},
                      {"group", cell.group},
                      {"session", text_or_null(cell.session)},
                      {"condition", text_or_null(cell.condition)},
                      {"participants", cell.participants},
                      {"recordings", cell.recordings},
                      {"parameters", each_parameter(parameters, [&](std::size_t p, Json& one) {
                         one["mean"] = cell.mean[p].mean;
                         one["mean_sd"] = cell.mean[p].sd;
                         one["mean_interval95"] = cell.mean[p].interval95;
                         one["between_sd"] = cell.between_sd[p].mean;
                         one["between_sd_interval95"] = cell.between_sd[p].interval95;
                       })}});
  for (const cohort::Comparison& comparison : found.comparisons)
    comparisons.push_back({{"groups", pair_of(found, comparison)},
                           {"participants_in_both", comparison.participants_in_both},
                           {"parameters", effects_json(comparison.effects, parameters)}});
  for (const cohort::Interaction& one : found.interactions)
    interactions.push_back({{"first", pair_of(found, found.comparisons[one.first])},
                            {"second", pair_of(found, found.comparisons[one.second])},
                            {"parameters", effects_json(one.effects, parameters)}});
  for (const cohort::Covariate& covariate : found.covariates)
    covariates.push_back(covariate_json(covariate, parameters));
  for (const cohort::Change& change : found.changes) {
    const cohort::Comparison& comparison = found.comparisons[change.comparison];
    changes.push_back({{"participant_id", found.visits[change.first].participant},
                       {"groups", pair_of(found, comparison)},
                       {"parameters", each_parameter(parameters, [&](std::size_t p, Json& one) {
                          one["difference"] = change.difference[p].mean;
                          one["interval95"] = change.difference[p].interval95;
                          one["changed"] = change.changed(p);
                        })}});
  }
  return {{"draws", found.draws},
          {"max_rhat", found.max_rhat},
          {"groups", std::move(groups)},
          {"comparisons", std::move(comparisons)},
          {"interactions", std::move(interactions)},
          {"covariates", std::move(covariates)},
          {"variance", each_parameter(parameters,
                                      [&](std::size_t p, Json& one) {
                                        one["participant_sd"] = found.variances[p].participant.mean;
                                        one["visit_sd"] = found.variances[p].visit.mean;
                                        one["trial_sd"] = found.variances[p].trial.mean;
                                        one["measurement_sd"] = found.variances[p].measurement;
                                      })},
          {"changes", std::move(changes)}};
}

Json reliability_json(const Report& report) {
  Json list = Json::array();
  if (!report.groups) return list;
  const GroupComparison& compared = report.groups->comparison;
  const sim::ParameterTable parameters = report.compared_parameters();
  for (std::size_t i = 0; i < report.groups->reliability.size(); ++i) {
    const auto& of_pair = report.groups->reliability[i];
    const GroupPair& pair = compared.pairs[i];
    if (of_pair.empty()) continue;
    list.push_back({{"groups", {compared.groups[pair.first].name, compared.groups[pair.second].name}},
                    {"participants", pair.participants[0]},
                    {"parameters", each_parameter(parameters, [&](std::size_t p, Json& one) {
                       if (!of_pair[p]) return;
                       const cohort::Reliability& found = *of_pair[p];
                       one["icc_single"] = found.icc_single;
                       one["icc_single_interval95"] = found.icc_single95;
                       one["icc_average"] = found.icc_average;
                       one["icc_average_interval95"] = found.icc_average95;
                       one["standard_error"] = found.standard_error;
                       one["minimal_detectable_change"] = found.minimal_detectable_change;
                       one["participant_sd"] = found.participant_sd;
                       one["visit_sd"] = found.visit_sd;
                       one["measurement_sd"] = found.measurement_sd;
                       one["within_participant_sd"] = found.within_participant_sd;
                       one["shown_fraction"] = found.shown_fraction;
                     })}});
  }
  return list;
}

}  // namespace decid::tools
