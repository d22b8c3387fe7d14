// Priors of a recorded trial: see priors.hpp.
#include "posterior/density/priors.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/math/random.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"

namespace decid::posterior {
namespace {

constexpr double latest_start_s = 1.0, max_gain = 0.9;  // so that the loop's phase factors stay small
constexpr double longest_standing_s = 60.0;
constexpr double edge = 0.01, tiny_probability = 1e-6;
constexpr double contradiction_sd = 5.0;
constexpr double max_range_factor = 100.0;  // of a range's upper end, over the table's or below it

/// Returns the probability of the normal distribution below the quantile.
double probability_in(const Quantile& prior, double probability) {
  return std::clamp(prior.probability_low + prior.probability_range * probability, 1e-300, 1.0 - 0x1p-53);
}

constexpr const char* mgh_suffix = "/mgh";

/// Throws Error for a fixed value that no simulation takes, or that is meant in another unit.
void check_fixed(const sim::ParameterInfo& info, double value) {
  const double max = std::min(info.max, max_range_factor * info.high), min_gain = info.high / max_range_factor;
  const bool is_mgh = info.scales_with_mgh && value > 0.0 && value < min_gain;
  if (std::isfinite(value) && value >= info.min && value <= max && !is_mgh) return;
  throw Error(Code::setting_out_of_range, "prior of " + info.name, format("fixes it at %g", value) + info.unit_after(),
              (is_mgh ? format("give 0, or %g to %g", min_gain, max) : format("give %g to %g", info.min, max)) +
                  info.unit_after() + (is_mgh ? mgh_hint(info, value) : info.unit_hint()));
}

}  // namespace

// The limit is the one below which gains are refused, so that the hint says why. cohort::hint_of_unit() has another
// one, because it also notes values that are accepted.
std::string mgh_hint(const sim::ParameterInfo& info, double value) {
  if (!info.scales_with_mgh || !(std::abs(value) < info.high / max_range_factor)) return {};
  return format(" (%s is in %s; for values over m g h give %s%s)", info.name.c_str(), info.unit.c_str(),
                info.name.c_str(), mgh_suffix);
}

PriorName::PriorName(const std::string& text) : parameter(text), over_mgh(text.ends_with(mgh_suffix)) {
  if (over_mgh) parameter.resize(text.size() - std::string_view(mgh_suffix).size());
}

Priors in_si_units(Priors priors, const sim::Protocol& protocol) {
  const sim::ParameterTable& table = protocol.parameters();
  const double mgh_nm_rad = protocol.experiment.body.mgh();
  for (ParameterPrior& prior : priors.parameters) {
    if (!prior.over_mgh.any()) continue;
    const auto info = std::ranges::find(table, prior.name, &sim::ParameterInfo::name);
    if (info != table.end() && !info->scales_with_mgh) {
      std::vector<std::string> scaled;
      for (const sim::ParameterInfo& one : table)
        if (one.scales_with_mgh) scaled.push_back(one.name);
      throw Error(
          Code::setting_conflict, (prior.over_mgh.range ? "range of " : "prior of ") + prior.name,
          "is over m g h, but " + prior.name + " is " + (info->unit == "1" ? "a plain number" : "in " + info->unit),
          "give it without " + std::string(mgh_suffix) + ", which is for " + joined(scaled, ", "));
    }
    if (prior.range && prior.over_mgh.range)
      prior.range = {mgh_nm_rad * prior.range->low, mgh_nm_rad * prior.range->high};
    if (prior.normal && prior.over_mgh.normal)
      prior.normal = {mgh_nm_rad * prior.normal->mean, mgh_nm_rad * prior.normal->sd};
    if (prior.fixed && prior.over_mgh.fixed) prior.fixed = mgh_nm_rad * *prior.fixed;
    prior.over_mgh = {};
  }
  return priors;
}

double Quantile::value(double x) const {
  return value_at(normal_distribution(x));
}

double Quantile::value_at(double probability) const {
  if (sd == 0.0) return low + range * probability;
  return std::clamp(mean + sd * inverse_normal(probability_in(*this, probability)), low, low + range);
}

double Quantile::slope_at(double probability) const {
  if (sd == 0.0) return range;
  return sd * probability_range / normal_density(inverse_normal(probability_in(*this, probability)));
}

double Quantile::slope(double x) const {
  if (sd == 0.0) return range * normal_density(x);
  const double density = normal_density((value(x) - mean) / sd);
  return density > 0.0 ? sd * probability_range * normal_density(x) / density : 0.0;
}

double Quantile::value_in_tails(double x) const {
  const auto stddevs_at = [](double probability) { return inverse_normal(std::max(probability, 1e-300)); };
  const double below = probability_low + probability_range * normal_distribution(x);
  // Near 1 a probability has no digits for the rest.
  const double above = normal_distribution((mean - low - range) / sd) + probability_range * normal_distribution(-x);
  const double stddevs = below < 0.5 ? stddevs_at(below) : -stddevs_at(above);
  return std::clamp(mean + sd * stddevs, low, low + range);
}

double Quantile::slope_in_tails(double x) const {
  const double density = normal_density((value_in_tails(x) - mean) / sd);
  return density > 0.0 ? sd * probability_range * normal_density(x) / density : 0.0;
}

double Quantile::coordinate(double value) const {
  if (range == 0.0) return 0.0;
  const double probability = sd == 0.0
                                 ? (value - low) / range
                                 : (normal_distribution((value - mean) / sd) - probability_low) / probability_range;
  return inverse_normal(std::clamp(probability, edge, 1.0 - edge));
}

std::string contradicted_priors(const std::vector<ParameterPrior>& priors, const sim::ParameterTable& table,
                                std::span<const double> values) {
  std::vector<std::string> names;
  for (std::size_t p = 0; p < table.size(); ++p) {
    const auto prior = std::ranges::find(priors, table[p].name, &ParameterPrior::name);
    if (prior == priors.end() || !prior->normal) continue;
    if (std::abs(values[p] - prior->normal->mean) > contradiction_sd * prior->normal->sd)
      names.push_back(table[p].name);
  }
  return joined(names, ", ");
}

Priors with_conventions(Priors priors, const sim::ParameterTable& table) {
  for (const sim::ParameterInfo& info : table) {
    const bool named =
        std::ranges::find(priors.parameters, info.name, &ParameterPrior::name) != priors.parameters.end();
    if (info.convention && !named) priors.parameters.push_back({.name = info.name, .fixed = info.convention});
  }
  return priors;
}

const Priors& require_valid(const Priors& priors) {
  const auto require = [](bool right, const std::string& where, double value, const char* remedy) {
    if (!right) throw Error(Code::setting_out_of_range, where, format("is %g", value), remedy);
  };
  const auto check = [&](bool right, const char* of_priors, double value, const char* remedy) {
    require(right, std::string("priors, ") + of_priors, value, remedy);
  };
  require(priors.sensor_noise_deg > 0.0 && std::isfinite(priors.sensor_noise_deg), setting("prior_noise"),
          priors.sensor_noise_deg, "give degrees above 0");
  check(priors.sensor_noise_factor > 1.0 && std::isfinite(priors.sensor_noise_factor), "sensor_noise_factor",
        priors.sensor_noise_factor, "give a factor above 1");
  check(priors.slow_ratio > 0.0 && std::isfinite(priors.slow_ratio), "slow_ratio", priors.slow_ratio,
        "give a ratio above 0");
  check(priors.slow_ratio_factor > 1.0 && std::isfinite(priors.slow_ratio_factor), "slow_ratio_factor",
        priors.slow_ratio_factor, "give a factor above 1");
  require(priors.start_s >= 0.0 && priors.start_s <= latest_start_s, setting("prior_start"), priors.start_s,
          "give 0 to 1 s");
  require(priors.gain >= 0.0 && priors.gain <= max_gain, setting("prior_gain"), priors.gain, "give 0 to 0.9");
  check(priors.drift_hz >= 0.0 && std::isfinite(priors.drift_hz), "drift_hz", priors.drift_hz, "give 0 Hz or more");
  check(priors.standing_s >= 0.0 && priors.standing_s <= longest_standing_s, "standing_s", priors.standing_s,
        "give 0 to 60 s");
  return priors;
}

sim::ParameterTable ranges_for(const Priors& priors, const sim::ParameterTable& table) {
  std::vector<sim::ParameterInfo> all(table.begin(), table.end());
  std::vector<std::string> named;
  for (const ParameterPrior& prior : priors.parameters) {
    const auto info =
        std::ranges::find(all, prior.name, [](const sim::ParameterInfo& one) { return std::string(one.name); });
    if (info == all.end())
      throw Error(Code::setting_unknown, "prior of " + prior.name, "names a parameter that the model does not have",
                  "give one of " + joined(all, ", ", &sim::ParameterInfo::name));
    if (std::ranges::find(named, prior.name) != named.end())
      throw Error(Code::setting_conflict, "prior of " + prior.name, "is given twice", "give it once");
    named.push_back(prior.name);
    if (prior.over_mgh.any())
      throw Error(Code::setting_conflict, "prior of " + prior.name, "is over m g h, which depends on the body",
                  "convert it by in_si_units()");
    if (prior.fixed) {
      if (prior.range || prior.normal)
        throw Error(Code::setting_conflict, "prior of " + prior.name,
                    "fixes the parameter and also gives it a range or a normal prior", "give one of them");
      check_fixed(*info, *prior.fixed);
    }
    if (prior.range) {
      const auto [low, high] = *prior.range;
      if (!(low >= 0.0 && high > low && std::isfinite(high)))
        throw Error(Code::setting_out_of_range, "range of " + prior.name,
                    format("is %g to %g", low, high) + info->unit_after(),
                    "give a low end of 0 or more and a high end above it");
      if (high > max_range_factor * info->high)
        throw Error(Code::setting_out_of_range, "range of " + prior.name,
                    format("ends at %g", high) + info->unit_after(),
                    format("give a high end of %g%s or less, %g times the model's", max_range_factor * info->high,
                           info->unit_after().c_str(), max_range_factor) +
                        info->unit_hint());
      if (high < info->high / max_range_factor)  // as of a gain over m g h
        throw Error(Code::setting_out_of_range, "range of " + prior.name,
                    format("ends at %g", high) + info->unit_after(),
                    format("give a high end of %g%s or more, the model's over %g", info->high / max_range_factor,
                           info->unit_after().c_str(), max_range_factor) +
                        info->unit_hint() + mgh_hint(*info, high));
      info->low = low;
      info->high = high;
    }
    if (prior.normal) {
      const auto [mean, sd] = *prior.normal;
      if (!(std::isfinite(mean) && sd > 0.0 && std::isfinite(sd)))
        throw Error(Code::setting_out_of_range, "prior of " + prior.name,
                    format("has mean %g and standard deviation %g", mean, sd), "give a standard deviation above 0");
      if (make_quantile(priors, prior.name, info->low, info->range()).probability_range < tiny_probability)
        throw Error(Code::setting_out_of_range, "prior of " + prior.name,
                    format("with mean %g and standard deviation %g lies outside of the range %g to %g%s", mean, sd,
                           info->low, info->high, info->unit_after().c_str()),
                    "give a mean within the range, or a wider range" + info->unit_hint() + mgh_hint(*info, mean));
    }
  }
  return sim::ParameterTable(std::move(all));
}

Quantile make_quantile(const Priors& priors, const std::string& name, double low, double range) {
  Quantile quantile{.low = low, .range = range};
  for (const ParameterPrior& prior : priors.parameters) {
    if (prior.name != name) continue;
    if (prior.fixed) return {.low = *prior.fixed, .range = 0.0};
    if (!prior.normal) continue;
    quantile.mean = prior.normal->mean;
    quantile.sd = prior.normal->sd;
    const auto below = [&](double value) { return normal_distribution((value - quantile.mean) / quantile.sd); };
    quantile.probability_low = below(low);
    quantile.probability_range = below(low + range) - quantile.probability_low;
  }
  return quantile;
}

}  // namespace decid::posterior
