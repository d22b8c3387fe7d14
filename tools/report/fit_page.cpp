// The page's data as JSON: numbers rounded to what can be seen, draws thinned. fit.js draws it.
#include "tools/report/fit_page.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/files/json_object.hpp"
#include "base/math/statistics.hpp"
#include "base/version.hpp"
#include "embedded/controllers_js.hpp"
#include "embedded/density_css.hpp"
#include "embedded/density_js.hpp"
#include "embedded/fit_css.hpp"
#include "embedded/fit_js.hpp"
#include "embedded/parameters_js.hpp"
#include "embedded/recordings_js.hpp"
#include "embedded/responses_js.hpp"
#include "tools/report/json/frf.hpp"
#include "tools/report/json/groups_json.hpp"
#include "tools/report/json/parameters_json.hpp"
#include "tools/report/json/recording_json.hpp"
#include "tools/report/page.hpp"

namespace decid::tools {
namespace {

using posterior::Band;
using posterior::Density;
using posterior::Posterior;

constexpr int shown_draws = 800, rank_bins = 10;
constexpr double shown_step_s = 0.1;
constexpr double share_units = 9999.0;  // of the draws' own range

void add_figures(Json& quantity_json, const Posterior& found, int quantity) {
  const std::size_t place = found.place(quantity);
  add_intervals(quantity_json, found, quantity);
  quantity_json["rhat"] = page_number(found.rhat()[place]);
  quantity_json["effective_draws"] = page_number(found.effective_draws()[place]);
}

Json parameters_of(const RecordingResult& recording, const FitFigures& fitted, const sim::Protocol& protocol,
                   const sim::ParameterTable& ranges) {
  Json list = described_parameters(recording, protocol, ranges);
  for (std::size_t p = 0; p < list.size(); ++p) add_figures(list[p], fitted.posterior, static_cast<int>(p));
  return list;
}

/// Changes the sign of a quantity.
void negate(Json& quantity_json) {
  quantity_json["mean"] = -quantity_json["mean"].get<double>();
  for (const char* key : {"interval50", "interval90"}) {
    Json& interval = quantity_json[key];
    interval = {-interval[1].get<double>(), -interval[0].get<double>()};
  }
}

/// Measurement noise, start and gain, where they were not known.
Json others_of(const Posterior& found) {
  Json list = Json::array();
  const auto add = [&](int quantity, const char* name, const char* unit) {
    if (found.stddev(quantity) == 0.0) return;
    Json& json = list.emplace_back(Json{{"name", name}, {"unit", unit}});
    add_figures(json, found, quantity);
  };
  add(Density::sensor_noise, "Measurement noise", "deg");
  const bool is_before = found.mean(Density::start) < 0.0;
  add(Density::start,
      is_before ? "Start of the recording before the protocol" : "Start of the recording after the protocol", "s");
  if (is_before && found.stddev(Density::start) > 0.0) negate(list.back());
  add(Density::gain, "Scale of the sway sensor (1 = correct)", "1");
  return list;
}

/// Returns evenly thinned draws of each chain, scaled to the range between the lowest and the highest.
Json draws_for(const Posterior& found, std::size_t parameters) {
  const auto each = static_cast<std::size_t>(found.draws_per_chain()),
             chains = static_cast<std::size_t>(found.chains());
  const std::size_t every = (each * chains + shown_draws - 1) / shown_draws, kept = each / every;
  Json values = Json::array(), lows = Json::array(), highs = Json::array();
  for (std::size_t p = 0; p < parameters; ++p) {
    std::vector<double> parts;
    for (std::size_t chain = 0; chain < chains; ++chain) {
      for (std::size_t i = 1; i <= kept; ++i) {
        const posterior::State& state = found.states()[chain * each + i * every - 1];
        parts.push_back(state.parameters[p]);
      }
    }
    const auto [low, high] = std::ranges::minmax(parts);
    for (double& part : parts) part = high > low ? (part - low) / (high - low) : 0.0;
    lows.push_back(low);
    highs.push_back(high);
    values.push_back(whole_numbers(parts, share_units));
  }
  return {{"chains", chains},           {"each", kept},           {"every", every},
          {"range", share_units},       {"low", std::move(lows)}, {"high", std::move(highs)},
          {"values", std::move(values)}};
}

/// Counts the draws of each chain in each part of all draws, in order of size.
Json ranks_of(const Posterior& found, std::size_t parameters) {
  const auto draws = static_cast<std::size_t>(found.draws()), each = static_cast<std::size_t>(found.draws_per_chain());
  Json list = Json::array();
  for (std::size_t p = 0; p < parameters; ++p) {
    std::vector<std::size_t> order(draws);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, [&](std::size_t draw) { return found.states()[draw].parameters[p]; });
    std::vector<std::vector<int>> counts(static_cast<std::size_t>(found.chains()), std::vector<int>(rank_bins, 0));
    for (std::size_t rank = 0; rank < draws; ++rank) ++counts[order[rank] / each][rank * rank_bins / draws];
    list.push_back(counts);
  }
  return list;
}

Json diagnostics_of(const Posterior& found) {
  return {{"agreed", found.agreed()},
          {"chains", found.chains()},
          {"draws", found.draws()},
          {"rhat", page_number(*std::ranges::max_element(found.rhat()))},
          {"effective_draws", page_number(*std::ranges::min_element(found.effective_draws()))},
          {"divergences", found.divergences()},
          {"energy_fraction", page_number(found.energy_fraction())},
          {"restarts", found.restarts()},
          {"acceptance", page_number(found.acceptance())}};
}

Json check_of(const PredictiveCheck& check) {
  Json figures = Json::array();
  for (const CheckedFigure& figure : check.figures)
    figures.push_back({{"name", figure.name},
                       {"unit", figure.in_degrees ? "deg" : "1"},
                       {"recorded", page_number(figure.recorded)},
                       {"low", page_number(figure.low)},
                       {"middle", page_number(figure.middle)},
                       {"high", page_number(figure.high)},
                       {"p", page_number(figure.p)}});
  return {{"trials", PredictiveCheck::trials}, {"standing", check.standing}, {"figures", std::move(figures)}};
}

/// Values in degrees, some of them left out, less an offset.
struct Thinned {
  std::size_t every;
  double offset_rad = 0.0;

  std::vector<double> operator()(std::span<const double> values_rad) const {
    std::vector<double> kept;
    for (std::size_t i = 0; i < values_rad.size(); i += every)
      kept.push_back((values_rad[i] - offset_rad) / sim::rad_per_deg);
    return kept;
  }
};

double mean_of(std::span<const double> values) {
  return values.empty() ? 0.0 : mean(values);
}

/// Bands and lines as whole numbers with one scale.
class Chart {
 public:
  Chart(double first_s, double step_s) : first_s_(first_s), step_s_(step_s) {}

  void line(const char* name, const std::vector<double>& values) {
    if (values.empty()) return;
    const auto [low, high] = std::ranges::minmax(values);
    widest_ = std::max(widest_, high - low);
    lines_.emplace_back(name, values);
  }
  void band(const std::string& name, const Band& band, const Thinned& thinned) {
    line((name + "_low").c_str(), thinned(band.low));
    line((name + "_middle").c_str(), thinned(band.middle));
    line((name + "_high").c_str(), thinned(band.high));
  }
  Json json() const {
    const double per_degree = whole_per_unit(widest_);
    Json json{{"first_s", page_number(first_s_)}, {"step_s", page_number(step_s_)}, {"per_degree", per_degree}};
    for (const auto& [name, values] : lines_) json[name] = whole_numbers(values, per_degree);
    return json;
  }

 private:
  double first_s_, step_s_, widest_ = 1e-6;
  std::vector<std::pair<std::string, std::vector<double>>> lines_;
};

/// Returns the sway that was fitted: before a low-pass that the fit has undone.
std::vector<float> fitted_sway(const recording::Trial& trial, double rate_hz) {
  const bool undone = trial.low_pass && can_undo(*trial.low_pass);
  return undone ? undo(*trial.low_pass, trial.sway_rad(), rate_hz) : trial.sway_rad();
}

/// Returns the page's time series: sway about its mean, noise and tilt estimate, evenly thinned.
Json signals_of(const RecordingResult& recording, const FitFigures& fitted, const Report& of) {
  const double rate_hz = of.protocol_for(recording).experiment.sample_rate_hz;
  const std::vector<float> samples = fitted_sway(recording.trial, rate_hz);
  const auto block = static_cast<std::size_t>(std::lround(fitted.block_s * rate_hz));
  std::vector<double> recorded;
  for (std::size_t k = 0; k + block <= samples.size(); k += block) {
    double sum = 0.0;
    for (std::size_t j = 0; j < block; ++j) sum += double{samples[k + j]};
    recorded.push_back(sum / static_cast<double>(block));
  }
  const auto about_mean = [](const Band& band) { return Thinned{1, mean_of(band.middle)}; };
  const posterior::Inferred& inferred = fitted.inferred;
  Chart sway(0.5 * (fitted.block_s - 1.0 / rate_hz), fitted.block_s);
  sway.line("recorded", Thinned{1, mean_of(recorded)}(recorded));
  sway.band("model", inferred.sway_rad, about_mean(inferred.sway_rad));
  sway.band("again", fitted.check.sway_rad, Thinned{1});

  const Thinned edges{static_cast<std::size_t>(std::max(1L, std::lround(shown_step_s / fitted.edge_s)))};
  const double step_s = fitted.edge_s * static_cast<double>(edges.every);
  Chart noise(fitted.first_edge_s, step_s), tilt(fitted.first_edge_s, step_s);
  noise.band("noise", inferred.noise_rad_s, edges);
  tilt.band("estimate", inferred.tilt_estimate_rad, edges);
  const std::vector<float>& tilt_rad = of.setting_of(recording).tilt_rad;
  std::vector<double> platform;
  for (std::size_t i = 0; i < inferred.tilt_estimate_rad.low.size() && !tilt_rad.empty(); ++i) {
    const double place = (fitted.first_edge_s + static_cast<double>(i) * fitted.edge_s) * rate_hz;
    const double last = static_cast<double>(tilt_rad.size() - 1);
    platform.push_back(double{tilt_rad[static_cast<std::size_t>(std::clamp(std::round(place), 0.0, last))]});
  }
  tilt.line("platform", edges(platform));
  return {{"sway", sway.json()}, {"noise", noise.json()}, {"tilt", tilt.json()}};
}

/// The recorded response and a controller's, in the form of decid fit --frf; null if there is none.
Json response_of(const FitFigures& fitted, const PredictiveCheck& check) {
  const ControllerResponse response = controller_response(fitted, check);
  if (response.frequency_hz.empty()) return nullptr;
  Json json = Json::object();
  const auto line = [&](const char* key, const std::vector<double>& values) {
    for (const double value : values) json[key].push_back(page_number(value));
  };
  const auto band = [&](const char* key, const Band& values) {
    for (std::size_t i = 0; i < values.low.size(); ++i)
      json[key].push_back({page_number(values.low[i]), page_number(values.high[i])});
  };
  line("frequency_hz", response.frequency_hz);
  line("gain", response.gain);
  line("phase_deg", response.phase_deg);
  line("model_gain", response.simulated_gain.middle);
  line("model_phase_deg", response.simulated_phase_deg.middle);
  band("model_gain_interval90", response.simulated_gain);
  band("model_phase_interval90", response.simulated_phase_deg);
  return json;
}

/// The fitted controllers, the one that answers first; empty if only one was fitted.
Json controllers_of(const FitFigures& fitted, const sim::Protocol& protocol) {
  Json list = Json::array();
  if (!fitted.compared) return list;
  const auto add = [&](const std::string& name, const posterior::ComparedModel& compared, const Posterior& found,
                       const PredictiveCheck& check, bool comparable, const Warnings& warnings) {
    const sim::BodyModel& model = sim::find_body_model(name, "controller");
    Json parameters = Json::array(), odd = Json::array();
    for (std::size_t p = 0; p < model.parameters.size(); ++p) {
      const sim::ParameterInfo& info = model.parameters[p];
      const auto quantity = static_cast<int>(p);
      parameters.push_back({{"name", info.name},
                            {"description", info.description},
                            {"unit", info.shown_unit()},
                            {"mean", page_number(found.mean(quantity))},
                            {"sd", page_number(found.stddev(quantity))},
                            {"low", page_number(found.quantile(quantity, 0.05))},
                            {"high", page_number(found.quantile(quantity, 0.95))}});
    }
    for (const CheckedFigure& figure : check.figures)
      if (figure.p < PredictiveCheck::odd) odd.push_back(figure.name);
    Chart sway(0.5 * fitted.block_s, fitted.block_s);
    sway.band("again", check.sway_rad, Thinned{1});
    list.push_back({{"name", name},
                    {"description", model.description},
                    {"log_density", page_number(compared.log_density)},
                    {"difference", page_number(compared.difference)},
                    {"standard_error", page_number(compared.standard_error)},
                    {"weight", page_number(compared.weight)},
                    {"comparable", comparable},
                    {"parameters", std::move(parameters)},
                    {"correlations", page_correlations(found, model.parameters.size(), 1e4)},
                    {"odd", std::move(odd)},
                    {"warnings", warnings_json(warnings)},
                    {"frf", response_of(fitted, check)},
                    {"sway", sway.json()}});
  };
  add(protocol.experiment.body_model->name, *fitted.compared, fitted.posterior, fitted.check, fitted.comparable,
      {});  // its warnings are the recording's
  for (const ControllerFit& other : fitted.others)
    add(other.controller, other.compared, other.posterior, other.check, other.comparable, other.warnings);
  return list;
}

/// Returns the page's data of one recording; ranges: those of the density.
Json recording_to_json(const RecordingResult& recording, const Report& of, const sim::ParameterTable& ranges) {
  const FitFigures& fitted = *recording.fit;
  const Posterior& found = fitted.posterior;
  const posterior::LeaveOneOut& left_out = fitted.inferred.left_out;
  return {{"file", recording.file},
          {"column", recording.column},
          {"tilt", tilt_to_json(recording)},
          {"protocol", protocol_figures(of.protocol_for(recording))},
          {"body_assumed", of.setting_of(recording).body_assumed},
          {"trust", name(recording.trust())},
          {"warnings", warnings_json(recording.warnings)},
          {"peak_to_peak_deg", page_number(recording.peak_to_peak_deg())},
          {"answer", name(fitted.answer)},
          {"parameters", parameters_of(recording, fitted, of.protocol_for(recording), ranges)},
          {"others", others_of(found)},
          {"controllers", controllers_of(fitted, of.protocol_for(recording))},
          {"samples_noise_deg", page_number(fitted.samples_noise_deg)},
          {"diagnostics", diagnostics_of(found)},
          {"check", check_of(fitted.check)},
          {"log_density",
           {{"value", page_number(left_out.log_density)},
            {"standard_error", page_number(left_out.standard_error)},
            {"effective_parameters", page_number(left_out.effective_parameters)},
            {"unreliable", left_out.unreliable},
            {"blocks", fitted.inferred.recorded_blocks.size()},
            {"block_s", page_number(fitted.block_s)}}},
          {"correlations", page_correlations(found, ranges.size())},
          {"draws", draws_for(found, ranges.size())},
          {"ranks", ranks_of(found, ranges.size())},
          {"signals", signals_of(recording, fitted, of)}};
}

}  // namespace

std::string fit_page(const Report& report) {
  std::vector<Json> recordings;
  for (const RecordingResult& recording : report.recordings)
    if (!recording.error) recordings.push_back(recording_to_json(recording, report, report.ranges_for(recording)));
  Json data = {{"version", version},
               {"seed", report.fit->settings.seed},
               {"call", call_json(report.call, report.protocol.name)},
               {"sha256", report.model_sha256},
               {"groups", page_groups(report)},
               {"other_answer", other_answer_json(report)},
               {"recordings", Json::array()},
               {"failed", errors_json(report)}};
  for (Json& recording : recordings)
    data["recordings"].push_back(taken(recording, {"file", "trust", "parameters", "diagnostics"}));
  return page_html(
      {.title = "Balance control report: detailed analysis",
       .lead = "Seven balance-control parameters with their uncertainty, estimated from body sway on a tilting "
               "platform.",
       .script = std::string(embedded::parameters_js()) + std::string(embedded::recordings_js()) +
                 std::string(embedded::density_js()) + std::string(embedded::responses_js()) +
                 std::string(embedded::controllers_js()) + std::string(embedded::fit_js()),
       .style = std::string(embedded::density_css()) + std::string(embedded::fit_css()),
       .details = std::move(recordings)},
      data);
}

}  // namespace decid::tools
