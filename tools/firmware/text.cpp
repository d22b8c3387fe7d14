// A firmware's files: see text.hpp.
#include "tools/firmware/text.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/text.hpp"
#include "base/version.hpp"
#include "embedded/firmware_angle.hpp"
#include "embedded/firmware_api.hpp"
#include "embedded/firmware_arithmetic.hpp"
#include "embedded/firmware_bins.hpp"
#include "embedded/firmware_elementary.hpp"
#include "embedded/firmware_familiarity.hpp"
#include "embedded/firmware_familiarity_header.hpp"
#include "embedded/firmware_header.hpp"
#include "embedded/firmware_image.hpp"
#include "embedded/firmware_incremental.hpp"
#include "embedded/firmware_network.hpp"
#include "embedded/firmware_results.hpp"
#include "embedded/firmware_series.hpp"
#include "embedded/firmware_spectrum.hpp"
#include "embedded/firmware_state.hpp"
#include "embedded/firmware_stddevs.hpp"
#include "embedded/firmware_types.hpp"
#include "embedded/firmware_windows.hpp"
#include "identify/response_ratio.hpp"
#include "tools/firmware/c_text.hpp"
#include "tools/firmware/layer_text.hpp"

namespace decid::tools {
namespace {

using dataset::Channel;
using Kind = FirmwareLayer::Kind;

/// Gaussians of the model's head; 0: it gives point estimates.
long long components(const Model& model) {
  if (!model.gives_distribution()) return 0;
  return static_cast<long long>(model.network.output_shape().size()) /
         static_cast<long long>(mixture_outputs(1, model.parameters().size()));
}

int transform_length(const Model& model) {
  return model.image().window % 2 == 0 ? model.image().window / 2 : model.image().window;
}

/// Parts of the runtime that a model needs.
struct Uses {
  bool log_modulus, residual, cos, sin, modulus, asinh, mixture, statistics;
};
Uses uses_of(const Model& model, const FirmwarePlan& plan) {
  const auto has = [&](Channel channel) { return std::ranges::count(model.image().channels, channel) > 0; };
  Uses uses{};
  uses.log_modulus = has(Channel::log_modulus);
  uses.residual = has(Channel::log_residual);
  uses.cos = has(Channel::cos_phase);
  uses.sin = has(Channel::sin_phase);
  uses.modulus = has(Channel::modulus) || uses.log_modulus || uses.cos || uses.sin;
  uses.asinh = model.image().block > 0 || has(Channel::asinh_real) || has(Channel::asinh_imaginary);
  uses.mixture = components(model) > 0;
  uses.statistics = has_kind(plan, Kind::statistics);
  return uses;
}

/// The preprocessor's settings of what makes an image of spectra.
std::string spectrum_settings(const Model& model, const FirmwarePlan& plan, const Uses& uses) {
  const dataset::ImageSettings& image = model.image();
  const dataset::ImageShape shape = model.images().shape();
  const auto has = [&](Channel channel) { return std::ranges::count(image.channels, channel) > 0; };
  const auto radix = [&](int r) { return std::ranges::count(plan.radices, r) > 0; };
  std::string text = define("WINDOW", image.window) + define("SIGNAL_LENGTH", transform_length(model)) +
                     define("PASSES", static_cast<long long>(plan.radices.size())) +
                     define("LARGEST_RADIX", plan.max_radix());
  for (const int r : {2, 3, 4, 5}) text += define("USES_RADIX_" + std::to_string(r), radix(r));
  text += define("SHOWN_BINS", std::min(image.window / 2 + 1, shape.rows)) +
          define("KEPT_COLUMNS", plan.options.incremental ? shape.columns : 1);
  return text + define("USES_CHANNEL_MODULUS", has(Channel::modulus)) + define("USES_MODULUS", uses.modulus) +
         define("USES_LOG_MODULUS", uses.log_modulus) + define("USES_LOG_RESIDUAL", uses.residual) +
         define("USES_PHASE", has(Channel::phase)) + define("USES_COS_PHASE", uses.cos) +
         define("USES_SIN_PHASE", uses.sin) + define("SIGNAL_OFFSET", plan.arena.signal) +
         define("SCRATCH_OFFSET", plan.arena.scratch) +
         (image.fold > 1 ? define("SPECTRA_OFFSET", plan.arena.spectra) : std::string());
}

/// Returns the settings that turn a time series into a network input.
std::string series_settings(const Model& model, const ForBody& body) {
  const dataset::ImageSettings& image = model.image();
  const dataset::ImageShape shape = model.images().shape();
  const sim::Experiment& experiment = model.protocol.experiment;
  const double block_s = image.block / experiment.sample_rate_hz;
  const double bend_over_lean = experiment.body.inertia_kgm2 / experiment.body.mgh();
  return define("BLOCK", image.block) + define("WINDOW", image.fold > 1 ? image.window : shape.rows * image.block) +
         define("SERIES_CHANNELS", static_cast<long long>(image.channels.size())) + define("USES_PHASE", 0) +
         define_double("SWAY_KNEE_RAD", dataset::sway_knee_rad) +
         define_double("SWAY_CHANGE_KNEE_RAD", dataset::sway_change_knee_rad) +
         define_double("SWAY_BEND_KNEE_RAD", dataset::sway_bend_knee_rad) +
         define_double("TORQUE_KNEE_RAD", dataset::torque_knee_rad) +
         define_double("TORQUE_OVER_BEND", body.height * (bend_over_lean / (block_s * block_s)));
}

/// The preprocessor's settings of the runtime's parts.
std::string settings(const Model& model, const ForBody& body, const FirmwarePlan& plan) {
  const dataset::ImageSettings& image = model.image();
  const dataset::ImageShape shape = model.images().shape();
  const bool series = image.block > 0;
  const Uses uses = uses_of(model, plan);
  std::string text = define("SERIES", series) + define("FIRST_SAMPLE", image.first_sample) +
                     define("FOLD", image.fold) + define("IMAGE_CHANNELS", shape.channels) +
                     define("IMAGE_ROWS", shape.rows) + define("IMAGE_COLUMNS", shape.columns) +
                     define("STANDARDIZES_ROWS", image.standardize_rows);
  text += series ? series_settings(model, body) : spectrum_settings(model, plan, uses);
  text += define("USES_ASINH", uses.asinh) +
          define("USES_LOG", uses.log_modulus || uses.residual || uses.asinh || uses.mixture) +
          define("USES_SQUARE_ROOT", uses.modulus || uses.residual || uses.asinh || uses.mixture || uses.statistics ||
                                         has_kind(plan, Kind::layer_norm) || plan.options.ood_score) +
          define("USES_EXPONENTIAL", uses.mixture || uses_exponential(plan)) +
          define("USES_NORMAL", uses.mixture || has_kind(plan, Kind::gelu)) + define("USES_DENSITY", uses.mixture) +
          define("USES_FMA_FLOAT", 1) + define("USES_FMA_DOUBLE", uses.mixture || has_kind(plan, Kind::gelu)) +
          define("USES_IS_FINITE", plan.options.ood_score) + define("USES_FLOAT_BITS", 1);
  text += define("FAMILIARITY", plan.options.ood_score) + define("QUANTISED", plan.options.int8) +
          define("INCREMENTAL", plan.options.incremental) + define("STREAM_ROWS", plan.stream_rows) +
          layer_settings(plan) + define("MAPS", static_cast<long long>(plan.maps.size())) +
          define("LAYERS", static_cast<long long>(plan.layers.size())) +
          define("PARAMETERS", static_cast<long long>(model.parameters().size())) +
          define("OUTPUTS", model.network.output_shape().size()) + define("COMPONENTS", components(model)) +
          define("OTHER_BODY", !body.assumed);
  if (uses.mixture) text += define_double("ROOT_TWELVE", std::sqrt(12.0));
  if (uses.statistics)
    text += "#define STATISTICS_EPSILON " + literal(static_cast<float>(nn::StatisticsPool::epsilon)) + "\n";
  const ArenaPlan& arena = plan.arena;
  text += "/* Where things are in the arena, bytes. */\n" + define("STATE_BYTES", arena.maps) +
          define("MAPS_OFFSET", arena.maps) + define("PATCH_OFFSET", arena.patch);
  if (plan.options.incremental) text += define("SAMPLES_OFFSET", arena.samples);
  return text;
}

/// Sines and cosines of the turns n / window in the first quadrant, or in the upper half where the window is odd.
std::string turns(int window) {
  std::vector<double> sine, cosine;
  for (int n = 0; n <= (window % 2 == 0 ? window / 4 : window / 2); ++n) {
    const auto [s, c] = sincos_of_turn(n, window);
    sine.push_back(s);
    cosine.push_back(c);
  }
  return table("static const double turn_sine[]", sine) + table("static const double turn_cosine[]", cosine);
}

/// Returns a flag for each output of the last pass's butterflies: 1 if a shown bin needs it. Output r of butterfly k is
/// value k + length / radix * r of the transform; bin k is made of values k and length - k.
std::vector<std::uint8_t> needed_outputs(const Model& model, const FirmwarePlan& plan) {
  const int length = transform_length(model), radix = plan.radices.back(), stride = length / radix;
  const int shown = std::min(model.image().window / 2 + 1, model.images().shape().rows);
  std::vector<std::uint8_t> needed(static_cast<std::size_t>(radix), 0);
  for (int k = 0; k < shown; ++k)
    for (const int value : {k, length - k}) needed[static_cast<std::size_t>(value % length / stride)] = 1;
  return needed;
}

std::string passes(const Model& model, const FirmwarePlan& plan) {
  std::vector<int> groups;
  int left = transform_length(model);
  for (const int radix : plan.radices) groups.push_back(left /= radix);
  if (groups.empty()) return {};
  return table("static const int32_t pass_radix[PASSES]", plan.radices) +
         table("static const int32_t pass_groups[PASSES]", groups) +
         table("static const uint8_t last_pass_needed[]", needed_outputs(model, plan));
}

/// Returns the tables that turn a time series into a network input: the weight of each cycle's difference, and the
/// planes that do not depend on the sway.
std::string series_tables(const Model& model, const ForBody& body) {
  const dataset::ImageSettings& image = model.image();
  const dataset::ImageShape shape = model.images().shape();
  std::vector<double> scale{0.0};
  for (int k = 1; k < image.fold; ++k) scale.push_back(std::sqrt(k / (k + 1.0)));
  const std::vector<float> still(static_cast<std::size_t>(model.protocol.samples()), 0.0F);
  std::vector<float> shown(static_cast<std::size_t>(shape.size())), given;
  model.images().make(dataset::Sway(still, body.height), shown);
  std::vector<int> first;
  const auto rows = static_cast<std::ptrdiff_t>(shape.rows);
  std::ptrdiff_t plane = 0;
  for (const Channel channel : image.channels) {
    first.push_back(static_cast<int>(given.size() / static_cast<std::size_t>(rows)));
    if (!is_of_sway(channel))
      given.insert(given.end(), shown.begin() + plane * rows, shown.begin() + (plane + 1) * rows);
    plane += is_of_sway(channel) ? image.fold : 1;
  }
  if (given.empty()) given.push_back(0.0F);
  return (image.fold > 1 ? table("static const double cycle_scale[FOLD]", scale) : std::string()) +
         table("static const int32_t given_first[SERIES_CHANNELS]", first) +
         table("static const float given_plane[]", given);
}

/// Returns the tables that map outputs to parameters, and the expected results of the self-test.
std::string result_tables(const Model& model, const ForBody& body, const TestVector& test) {
  const auto doubles = [](const sim::Parameters& p) { return std::vector<double>(p.begin(), p.end()); };
  std::string text = table("static const double target_mean[PARAMETERS]", doubles(model.targets.mean)) +
                     table("static const double target_deviation[PARAMETERS]", doubles(model.targets.stddev)) +
                     table("static const uint32_t test_outputs[OUTPUTS]", to_bits(test.outputs)) +
                     table("static const uint32_t test_parameters[PARAMETERS]", to_bits(test.parameters));
  if (!body.assumed) {
    sim::Parameters one(model.parameters().size());
    std::ranges::fill(one, 1.0);
    text += table("static const double body_factor[PARAMETERS]", doubles(body.from_model(model, one)));
  }
  if (components(model) == 0) return text;
  std::vector<double> range, factor;
  for (std::size_t p = 0; p < model.parameters().size(); ++p) {
    range.push_back(body.ranges[p].range());
    factor.push_back(model.recalibration.factor(p));
  }
  return text + table("static const double parameter_range[PARAMETERS]", range) +
         table("static const double deviation_factor[PARAMETERS]", factor) +
         table("static const uint32_t test_stddevs[PARAMETERS]", to_bits(test.stddevs));
}

std::string familiarity_tables(const Model& model, const TestVector& test) {
  const OodDetector& known = model.ood_detector;
  return define("FEATURES", std::ssize(known.mean)) + define_double("FAMILIARITY_USUAL", known.usual) +
         table("static const float familiarity_mean[FEATURES]", known.mean) +
         table("static const float familiarity_whitening[]", known.whitening) +
         define_double("TEST_DISTANCE", test.distance);
}

std::string constants(const Model& model, const FirmwarePlan& plan) {
  const dataset::ImageShape shape = model.images().shape();
  std::string text = define("DECID_FW_PARAMETERS", static_cast<long long>(model.parameters().size()));
  text += define("DECID_FW_SAMPLES", model.protocol.samples());
  text += "#define DECID_FW_RATE_HZ " + literal(model.protocol.experiment.sample_rate_hz) + "\n";
  text += define("DECID_FW_IMAGE_CHANNELS", shape.channels) + define("DECID_FW_IMAGE_ROWS", shape.rows) +
          define("DECID_FW_IMAGE_COLUMNS", shape.columns);
  text += define("DECID_FW_ARENA_BYTES", plan.arena.bytes) + define("DECID_FW_WEIGHT_BYTES", plan.weight_bytes());
  text += define("DECID_FW_GIVES_STDDEVS", components(model) > 0 ? 1 : 0) +
          define("DECID_FW_GIVES_DISTANCE", plan.options.ood_score ? 1 : 0);
  if (plan.options.int8)
    text += "/* In 8 bits there is no distance: its mean, whitening and bounds are of features in float. */\n";
  if (plan.options.ood_score)
    text += define("DECID_FW_DISTANCE_BYTES", ood_score_bytes(model, plan)) + "#define DECID_FW_DISTANCE_USABLE " +
            literal(ood_border - ood_missing_weight, 6) + "\n#define DECID_FW_DISTANCE_NOT_USABLE " +
            literal(ood_border, 6) + "\n";
  return text;
}

/// Returns the end of a parameter's name in C: KP_PASS.
std::string constant_name(const sim::ParameterInfo& info) {
  std::string name;
  for (const char c : info.option)
    name += c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return name;
}

/// Returns the constants of the body for which the model answers, in the controller's names.
std::string body_constants(const sim::Body& body) {
  return define_double("DECID_FW_MASS_KG", body.mass_kg) + define_double("DECID_FW_COM_HEIGHT_M", body.com_height_m) +
         define_double("DECID_FW_INERTIA_KGM2", body.inertia_kgm2) + define_double("DECID_FW_MGH_NM_RAD", body.mgh());
}

/// Returns the constants of the parameters' ranges, each alone and all as initialisers of tables, with names and units.
std::string range_constants(const sim::ParameterTable& ranges) {
  const auto low = [](const sim::ParameterInfo& info) { return literal(static_cast<float>(info.low)); };
  const auto high = [](const sim::ParameterInfo& info) { return literal(static_cast<float>(info.high)); };
  std::string text;
  for (const sim::ParameterInfo& info : ranges)
    text += "#define DECID_FW_" + constant_name(info) + "_MIN " + low(info) + "\n#define DECID_FW_" +
            constant_name(info) + "_MAX " + high(info) + "\n";
  const auto list = [&](const char* name, const auto& item) {
    return std::string("#define DECID_FW_") + name + " {" + joined(ranges, ", ", item) + "}\n";
  };
  return text + list("MINIMA", low) + list("MAXIMA", high) +
         list("NAMES", [](const sim::ParameterInfo& info) { return quoted(info.name); }) +
         list("UNITS", [](const sim::ParameterInfo& info) { return quoted(info.unit); });
}

/// Returns the enumerators of the parameters, each with its meaning and unit.
std::string places(const sim::ParameterTable& table) {
  const auto enumerator = [&](std::size_t i) {
    return "DECID_FW_" + constant_name(table[i]) + (i + 1 < table.size() ? "," : "");
  };
  std::size_t width = 0;
  for (std::size_t i = 0; i < table.size(); ++i) width = std::max(width, enumerator(i).size());
  std::string text;
  for (std::size_t i = 0; i < table.size(); ++i) {
    std::string meaning = table[i].description;
    if (!meaning.empty()) meaning[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(meaning[0])));
    text += "  " + enumerator(i) + std::string(width - enumerator(i).size(), ' ') + " /* " + comment(meaning) + ", " +
            comment(table[i].unit) + " */\n";
  }
  return text;
}

}  // namespace

std::vector<float> test_sway(int samples) {
  std::vector<float> sway;
  for (int k = 0; k < samples; ++k) {
    auto x = static_cast<std::uint32_t>(k) * 2654435761U;
    const int triangle = 605 - std::abs(k % 2420 - 1210);
    x ^= x >> 15;
    x *= 2246822519U;
    x ^= x >> 13;
    const int noise = static_cast<int>(x >> 8) - (1 << 23);
    sway.push_back(static_cast<float>(triangle) * 0x1p-16F + static_cast<float>(noise) * 0x1p-33F);
  }
  return sway;
}

long long ood_score_bytes(const Model& model, const FirmwarePlan& plan) {
  const auto numbers = model.ood_detector.mean.size() + model.ood_detector.whitening.size();
  return plan.options.ood_score ? static_cast<long long>(numbers * sizeof(float)) : 0;
}

FirmwareFiles firmware_files(const Model& model, const ForBody& body, const FirmwarePlan& plan, const TestVector& test,
                             const std::string& name, const std::string& origin) {
  std::string header = "/* " + origin + "\n   How to use it: docs/guide/firmware.md of decid. */\n";
  header += embedded::firmware_header();
  header = replaced(header, "@CONSTANTS@", constants(model, plan));
  header = replaced(header, "@BODY@", body_constants(body.protocol.experiment.body));
  header = replaced(header, "@RANGES@", range_constants(body.ranges));
  header = replaced(header, "@PLACES@", places(model.parameters()));
  header = replaced(header, "@DEVIATIONS@",
                    components(model) > 0 ? std::string(embedded::firmware_stddevs()) : std::string());
  header = replaced(header, "@FAMILIARITY@",
                    plan.options.ood_score ? std::string(embedded::firmware_familiarity_header()) : std::string());
  header = replaced(header, "@INCREMENTAL@",
                    plan.options.incremental ? std::string(embedded::firmware_incremental()) : std::string());

  std::string source = "/* " + origin +
                       format(R"(
   Plain C99, or C++. No library at all (compilers may call memcpy and memset, and what divides where the processor does
   not), no memory but the arena and the stack, no state. All numbers are IEEE 754; gcc outside of -std=c99 needs
   -ffp-contract=off, no compiler may have -ffast-math or -ffinite-math-only. The self-test tells if the bits are right.
   Weights %lld bytes, arena %lld bytes; all feature maps as a whole would be %lld. */
)",
                              plan.weight_bytes(), plan.arena.bytes, plan.whole_map_bytes());
  source += "#include \"" + name + ".h\"\n\n#include <float.h>\n#include <stddef.h>\n#include <stdint.h>\n\n";
  source += settings(model, body, plan) + "\n";
  source += embedded::firmware_arithmetic();
  source += "\n";
  source += embedded::firmware_elementary();
  source += "\n";
  source += embedded::firmware_angle();
  source += "\n";
  source += embedded::firmware_types();
  source += "\n/* ---- Tables */\n\n";
  const bool series = model.image().block > 0;
  source += series ? series_tables(model, body) : turns(model.image().window) + passes(model, plan);
  std::vector<int> channels;
  for (const Channel channel : model.image().channels) channels.push_back(static_cast<int>(channel));
  source += table("static const int32_t image_channel[]", channels);
  if (model.image().standardize_rows) {
    source += table("static const float row_mean[]", model.rows.mean) +
              table("static const float row_deviation[]", model.rows.stddev);
  }
  source += layer_tables(plan) + result_tables(model, body, test) + "\n";
  const auto add = [&](std::string_view part) {
    source += part;
    source += "\n";
  };
  if (!series) add(embedded::firmware_spectrum());
  add(embedded::firmware_network());
  add(embedded::firmware_image());
  if (!series) add(embedded::firmware_bins());
  add(embedded::firmware_state());
  add(series ? embedded::firmware_series() : embedded::firmware_windows());
  add(embedded::firmware_results());
  if (plan.options.ood_score) {
    source += familiarity_tables(model, test) + "\n";
    add(embedded::firmware_familiarity());
  }
  source += embedded::firmware_api();
  return {with_name(header, name), with_name(source, name)};
}

}  // namespace decid::tools
