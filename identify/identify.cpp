// Identification of recordings: see identify.hpp.
#include "identify/identify.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"
#include "identify/following.hpp"
#include "sim/simulate.hpp"

namespace decid {
namespace {

void warn(Identification& id) {
  for (std::size_t p = 0; p < sim::parameter_count; ++p) {
    const sim::ParameterInfo& info = sim::parameter_info[p];
    const double margin = 0.05 * (info.high - info.low);
    if (id.parameters[p] < info.low - margin || id.parameters[p] > info.high + margin)
      id.warnings.push_back(format("%s = %.4g lies outside the range the model was trained on (%g to %g%s)", info.name,
                                   id.parameters[p], info.low, info.high, unit_after(info).c_str()));
  }
  // Simulated trials swing about upright: of 2,000 none has a mean beyond this.
  constexpr double largest_mean_deg = 0.8;
  const double mean_deg = mean(id.sway_rad) / sim::rad_per_deg;
  if (std::abs(mean_deg) > largest_mean_deg)
    id.warnings.push_back(
        format("the sway's mean is %.2f degrees, where 0 should be upright: an offset of the sensor "
               "shifts the result, take it off with --detrend offset",
               mean_deg));
  const auto [low, high] = std::ranges::minmax(id.sway_rad);
  const double largest = std::max(std::abs(static_cast<double>(low)), std::abs(static_cast<double>(high)));
  if (largest > sim::sway_limit_rad)
    id.warnings.push_back(
        format("sway reaches %.1f degrees; trials beyond 5 degrees were never trained on", largest / sim::rad_per_deg));
}

/// Tells recordings that look unlike anything the network was trained on.
void compare_with_training(const Model& model, const std::vector<Identification*>& all) {
  if (!model.familiarity.known()) {
    for (Identification* id : all) warn_unless_following(*id);
    return;
  }
  const auto values = static_cast<std::size_t>(model.images().shape().size());
  std::vector<float> images(all.size() * values);
  for (std::size_t i = 0; i < all.size(); ++i) {
    model.make_input(all[i]->sway_rad, std::span(images).subspan(i * values, values));
  }
  const std::vector<double> distance = distances(model, static_cast<int>(all.size()), images);
  for (std::size_t i = 0; i < all.size(); ++i) {
    Identification& id = *all[i];
    id.unfamiliarity = unfamiliarity(distance[i], model.familiarity.usual, id.following);
    if (id.unfamiliarity <= 1.0) continue;  // false for NaN
    id.warnings.push_back(
        format("looks unlike the trials the model was trained on (%.2f, where 96%% of simulated trials are below 1; it "
               "has %.2f of the response to the tilt that the identified controller would have): its parameters mean "
               "little; check that the platform played the protocol's stimulus from the first sample on, the sign of "
               "the sway, the rate and the unit",
               id.unfamiliarity, id.following));
  }
}

}  // namespace

std::vector<Identification> identify(Model& model, const std::vector<std::filesystem::path>& files,
                                     const ReadOptions& options) {
  const sim::Simulator simulator(model.protocol);
  std::vector<Identification> all = read_recordings(simulator, files, options);
  std::vector<std::size_t> usable;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (!all[i].error) usable.push_back(i);
  const auto sway = [&](int k) { return std::span<const float>(all[usable[static_cast<std::size_t>(k)]].sway_rad); };
  if (usable.empty()) return all;
  const std::vector<float> outputs = predict(model, static_cast<int>(usable.size()), 64, sways_in_memory(sway));
  for (std::size_t k = 0; k < usable.size(); ++k) {
    Identification& id = all[usable[k]];
    id.parameters = model.targets.unscale(std::span(outputs).subspan(k * sim::parameter_count, sim::parameter_count));
    id.image_settings = model.image;
    id.image_shape = model.images().shape();
    id.image.resize(static_cast<std::size_t>(id.image_shape.size()));
    model.images().make(id.sway_rad, id.image);
    warn(id);
    explain(simulator, id);
  }
  std::vector<Identification*> used;
  for (const std::size_t i : usable) used.push_back(&all[i]);
  compare_with_training(model, used);
  return all;
}

}  // namespace decid
