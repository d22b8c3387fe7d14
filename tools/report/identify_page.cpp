// The report's data as JSON: numbers rounded to what can be seen, so that a page stays small.
// page.cpp makes the page, identify.js draws it.
#include "tools/report/identify_page.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <span>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/math/math.hpp"
#include "base/math/statistics.hpp"
#include "base/version.hpp"
#include "embedded/density_css.hpp"
#include "embedded/density_js.hpp"
#include "embedded/frf_js.hpp"
#include "embedded/identify_js.hpp"
#include "embedded/parameters_js.hpp"
#include "embedded/recordings_js.hpp"
#include "tools/report/json/frf.hpp"
#include "tools/report/json/groups_json.hpp"
#include "tools/report/json/parameters_json.hpp"
#include "tools/report/json/recording_json.hpp"
#include "tools/report/page.hpp"

namespace decid::tools {
namespace {

/// Angles in degrees as whole multiples of a decimal unit between a thousandth and a ten-thousandth of the widest
/// excursion, one for all the signals; "per_degree" says how many are one.
Json series_to_json(std::initializer_list<std::pair<const char*, const std::vector<float>*>> signals_rad) {
  std::vector<std::vector<double>> all;
  double widest = 1e-6;
  for (const auto& [name, signal_rad] : signals_rad) {
    std::vector<double>& values = all.emplace_back();
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const float angle_rad : *signal_rad) {
      values.push_back(double{angle_rad} / sim::rad_per_deg);
      if (!std::isfinite(values.back())) continue;
      low = std::min(low, values.back());
      high = std::max(high, values.back());
    }
    widest = std::max(widest, high - low);
  }
  const double per_degree = whole_per_unit(widest);
  Json json{{"per_degree", per_degree}};
  std::size_t i = 0;
  for (const auto& [name, signal_rad] : signals_rad) json[name] = whole_steps(all[i++], per_degree);
  return json;
}

// How a channel's values become colours: the limits of its scale and its kind, which is the choice of colours.
struct ColourScale {
  const char* kind;  // "sequential", "diverging" or "cyclic"
  double low, high;
  bool logarithmic;  // limits are decimal logarithms
};

// A few bins hold most of the power, so the limits are quantiles, and values beyond take the last colour.
ColourScale colour_scale(dataset::Channel channel, std::vector<double> finite) {
  using dataset::Channel;
  if (channel == Channel::phase) return {"cyclic", -sim::pi, sim::pi, false};
  if (channel == Channel::cos_phase || channel == Channel::sin_phase) return {"diverging", -1.0, 1.0, false};
  if (finite.empty()) return {"sequential", 0.0, 1.0, false};
  const bool plain = channel == Channel::real || channel == Channel::imaginary;
  if (plain || channel == Channel::asinh_real || channel == Channel::asinh_imaginary) {
    for (double& value : finite) value = std::abs(value);
    const double limit = std::max(quantile(finite, plain ? 0.98 : 0.999), 1e-12);
    return {"diverging", -limit, limit, false};
  }
  const bool logarithmic = channel == Channel::modulus;
  if (logarithmic) {
    for (double& value : finite) value = std::log10(std::max(value, dataset::min_modulus_rad));
  }
  std::ranges::sort(finite);
  const double low = quantile_of_sorted(finite, 0.005), high = quantile_of_sorted(finite, 0.999);
  return {"sequential", low, std::max(high, low + 1e-6), logarithmic};
}

Json channel_to_json(dataset::Channel channel, std::span<const float> values) {
  std::vector<double> finite;
  for (const float value : values) {
    if (std::isfinite(value)) finite.push_back(value);
  }
  const ColourScale scale = colour_scale(channel, std::move(finite));
  Json levels = Json::array();
  for (const float value : values) {
    if (!std::isfinite(value)) {
      levels.push_back(nullptr);
      continue;
    }
    const double shown = scale.logarithmic ? std::log10(std::max(double{value}, dataset::min_modulus_rad)) : value;
    const double place = std::clamp((shown - scale.low) / (scale.high - scale.low), 0.0, 1.0);
    levels.push_back(std::lround(255.0 * place));
  }
  return {{"name", dataset::name(channel)},   {"kind", scale.kind},
          {"logarithmic", scale.logarithmic}, {"low", page_number(scale.low)},
          {"high", page_number(scale.high)},  {"levels", std::move(levels)}};
}

// The rows up to half the sample rate; those above mirror them and would show nothing new.
Json image_to_json(const RecordingResult& recording, const Report& of) {
  const std::vector<float>& image = recording.estimate.image;
  if (image.empty() || of.image.block > 0) return nullptr;  // a time series is what the page shows anyway
  const dataset::ImageShape& shape = of.image_shape;
  const double rate_hz = of.protocol.experiment.sample_rate_hz;
  const std::vector<dataset::Channel>& channels = of.image.channels;
  if (shape.channels != static_cast<int>(channels.size()) || shape.rows < 1 || shape.columns < 1 ||
      static_cast<std::size_t>(shape.size()) != image.size()) {
    throw Error(Code::size_mismatch, "report of " + recording.file,
                "an image of " + std::to_string(image.size()) + " values does not match its shape of " +
                    std::to_string(shape.channels) + " x " + std::to_string(shape.rows) + " x " +
                    std::to_string(shape.columns),
                "give the image and the shape of the same ImageMaker");
  }
  const int window = of.image.window;
  const int rows = std::min(shape.rows, window / 2 + 1);
  Json list = Json::array();
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const std::size_t size = static_cast<std::size_t>(shape.rows) * static_cast<std::size_t>(shape.columns);
    const std::span<const float> all(image);
    list.push_back(channel_to_json(
        channels[c], all.subspan(c * size, static_cast<std::size_t>(rows) * static_cast<std::size_t>(shape.columns))));
  }
  return {{"rows", rows},
          {"columns", shape.columns},
          {"row_hz", page_number(rate_hz / window)},
          {"column_s", page_number(window / rate_hz)},
          {"start_s", page_number(of.image.first_sample / rate_hz)},
          {"fold", of.image.fold},
          {"mirrored", shape.rows > rows},
          {"channels", std::move(list)}};
}

// [place in the range, density], denser where the parameter probably is.
Json density_to_json(const ParameterDistribution& found, int quantity, const sim::ParameterInfo& info) {
  constexpr int coarse = 20, fine = 100;
  constexpr double tail = 5e-4;
  const auto locate = [&](double probability) {
    return (found.quantile(quantity, probability) - info.low) / info.range();
  };
  const double low = locate(tail), high = locate(1.0 - tail);
  std::vector<double> places;
  for (int i = 0; i <= coarse; ++i) places.push_back(static_cast<double>(i) / coarse);
  for (int i = 0; i <= fine; ++i) places.push_back(low + (high - low) * i / fine);
  std::ranges::sort(places);
  Json list = Json::array();
  for (const double place : places)
    list.push_back(Json{page_number(place),
                        page_number(decid::exp(found.log_density(quantity, info.low + place * info.range())))});
  return list;
}

void add_distribution(Json& recording, const ParameterDistribution& found, const sim::Protocol& protocol) {
  const sim::ParameterTable table = protocol.ranges();
  for (std::size_t p = 0; p < table.size(); ++p) {
    add_intervals(recording["parameters"][p], found, static_cast<int>(p));
    recording["densities"].push_back(density_to_json(found, static_cast<int>(p), table[p]));
  }
  recording["correlations"] = page_correlations(found, table.size());
}

/// Returns the page's data of one recording.
Json recording_to_json(const RecordingResult& recording, const Report& of) {
  const Explanation& explanation = recording.explanation;
  Json json{{"file", recording.file},
            {"column", recording.column},
            {"tilt", tilt_to_json(recording)},
            {"protocol", protocol_figures(of.protocol_for(recording))},
            {"body_assumed", of.setting_of(recording).body_assumed},
            {"parameters", described_parameters(recording, of.protocol_for(recording), of.ranges_for(recording))},
            {"rms_residual_deg", page_number(explanation.rms_residual_deg)},
            {"variance_accounted_for", page_number(explanation.variance_accounted_for)},
            {"peak_to_peak_deg", page_number(recording.peak_to_peak_deg())},
            {"trust", name(recording.trust())},
            {"warnings", warnings_json(recording.warnings)},
            {"series", series_to_json({{"sway", &recording.trial.sway_rad()}, {"fitted", &explanation.fitted_rad}})},
            {"frf", explanation.frf ? frf_to_json(*explanation.frf) : Json(nullptr)},
            {"image", image_to_json(recording, of)}};
  if (recording.estimate.distribution)
    add_distribution(json, *recording.estimate.distribution, of.protocol_for(recording));
  return json;
}

}  // namespace

std::string identify_page(const Report& report) {
  std::vector<Json> recordings;
  for (const RecordingResult& recording : report.recordings)
    if (!recording.error) recordings.push_back(recording_to_json(recording, report));
  Json data = {{"model",
                {{"name", report.model},
                 {"sha256", report.model_sha256},
                 {"version", version},
                 {"options", report.options},
                 {"call", call_json(report.call, report.protocol.name)},
                 {"protocol", report.protocol.name},
                 {"recalibrated", report.recalibrated}}},
               {"groups", page_groups(report)},
               {"other_answer", other_answer_json(report)},
               {"platform", series_to_json({{"tilt", &report.tilt_rad}})},
               {"recordings", Json::array()},
               {"failed", errors_json(report)}};
  for (Json& shown : recordings)
    data["recordings"].push_back(taken(shown, {"file", "trust", "parameters", "variance_accounted_for"}));
  return page_html({.title = "Balance control report",
                    .lead = "Seven balance-control parameters, estimated from body sway on a tilting platform.",
                    .script = std::string(embedded::parameters_js()) + std::string(embedded::recordings_js()) +
                              std::string(embedded::density_js()) + std::string(embedded::frf_js()) +
                              std::string(embedded::identify_js()),
                    .style = embedded::density_css(),
                    .details = std::move(recordings)},
                   data);
}

}  // namespace decid::tools
