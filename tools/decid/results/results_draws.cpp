// Draws as arrays and as CSV: see results.hpp. Names of CSV's columns: R's package posterior (draws_df) and Stan.
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "dataset/npz/arrays.hpp"
#include "tools/decid/results/results.hpp"

namespace decid::tools {
namespace {

using posterior::Density;
using posterior::Posterior;

/// A quantity of each draw: its name, and its value at a draw.
struct Quantity {
  std::string name;
  std::function<double(std::size_t draw)> value;
};

/// The parameters and the recording's own unknowns.
std::vector<Quantity> quantities_of(const Posterior& found, const std::vector<std::string>& parameters) {
  std::vector<Quantity> all;
  const auto add = [&](const std::string& name, int quantity) {
    all.push_back(
        {name, [&found, quantity](std::size_t draw) { return Posterior::value(found.states()[draw], quantity); }});
  };
  for (std::size_t p = 0; p < parameters.size(); ++p) add(parameters[p], static_cast<int>(p));
  add("sensor_noise_deg", Density::sensor_noise);
  add("slow_noise_deg", Density::slow_noise);
  add("start_s", Density::start);
  add("gain", Density::gain);
  return all;
}

/// The sampler's own figures; `names` are log density, acceptance, divergence and energy.
std::vector<Quantity> transitions_of(const Posterior& found, const std::array<const char*, 4>& names) {
  const auto of = [&found](double posterior::Transition::*member) {
    return [&found, member](std::size_t draw) { return found.transitions()[draw].*member; };
  };
  return {{names[0], of(&posterior::Transition::log_density)},
          {names[1], of(&posterior::Transition::acceptance)},
          {names[2], of(&posterior::Transition::diverged)},
          {names[3], of(&posterior::Transition::energy)}};
}

/// Arrays, and the values to which they refer.
struct Arrays {
  std::deque<std::vector<double>> values;
  std::vector<dataset::NamedArray> all;

  void add(const std::string& name, std::vector<std::size_t> shape, std::vector<double> of) {
    const std::vector<double>& kept = values.emplace_back(std::move(of));
    all.push_back({name, std::move(shape), kept});
  }
};

void add_draws(const std::string& prefix, const FitFigures& fit, const std::vector<std::string>& names,
               Arrays& arrays) {
  const Posterior& found = fit.posterior;
  const auto chains = static_cast<std::size_t>(found.chains()),
             each = static_cast<std::size_t>(found.draws_per_chain());
  const std::size_t draws = chains * each;
  std::vector<double> parameters, chain;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    const sim::Parameters& values = found.states()[draw].parameters;
    parameters.insert(parameters.end(), values.begin(), values.end());
    const std::size_t number = draw / each;
    chain.push_back(static_cast<double>(number));
  }
  arrays.add(prefix + "parameters", {draws, names.size()}, std::move(parameters));
  arrays.add(prefix + "chain", {draws}, std::move(chain));
  std::vector<Quantity> all = quantities_of(found, names);
  std::ranges::move(transitions_of(found, {"lp", "acceptance_rate", "diverging", "energy"}), std::back_inserter(all));
  for (const Quantity& quantity : all) {
    std::vector<double> values;
    for (std::size_t draw = 0; draw < draws; ++draw) values.push_back(quantity.value(draw));
    arrays.add(prefix + quantity.name, {chains, each}, std::move(values));
  }
  const std::size_t stored = fit.stored_draws.size();
  if (fit.inferred.log_likelihood.empty() || stored % chains != 0) return;
  arrays.add(prefix + "log_likelihood", {chains, stored / chains, fit.inferred.log_likelihood.size() / stored},
             fit.inferred.log_likelihood);
  std::vector<double> places;
  for (std::size_t i = 0; i < stored / chains; ++i)
    places.push_back(static_cast<double>(static_cast<std::size_t>(fit.stored_draws[i]) % each));
  arrays.add(prefix + "log_likelihood_draw", {stored / chains}, std::move(places));
  const std::vector<int>& blocks = fit.inferred.recorded_blocks;
  arrays.add(prefix + "log_likelihood_block", {blocks.size()}, {blocks.begin(), blocks.end()});
}

/// Appends the draws of a recording; `before`: cells before them.
void add_lines(const FitFigures& fit, const std::vector<std::string>& names, const std::string& before,
               std::string& text) {
  const Posterior& found = fit.posterior;
  const auto each = static_cast<std::size_t>(found.draws_per_chain());
  std::vector<Quantity> all = transitions_of(found, {"lp__", "accept_stat__", "divergent__", "energy__"});
  std::ranges::move(quantities_of(found, names), std::back_inserter(all));
  if (text.empty()) {
    text = before.empty() ? ".chain,.iteration,.draw" : "file,.chain,.iteration,.draw";
    for (const Quantity& quantity : all) text += ',' + quantity.name;
    text += '\n';
  }
  for (std::size_t draw = 0; draw < found.states().size(); ++draw) {
    text += before + format("%zu,%zu,%zu", draw / each + 1, draw % each + 1, draw + 1);
    for (const Quantity& quantity : all) {
      const double value = quantity.value(draw);
      text += ',' + (std::isfinite(value) ? Json(value).dump() : value < 0.0 ? "-Inf" : "NA");
    }
    text += '\n';
  }
}

}  // namespace

void write_draws(const std::filesystem::path& path, const Report& report, std::span<const std::size_t> places,
                 std::size_t count) {
  if (std::ranges::none_of(report.recordings, [](const RecordingResult& id) { return id.fit.has_value(); })) return;
  const std::vector<std::string> names = report.protocol.parameters().names();
  const bool is_csv = path.extension() == ".csv" || path.extension() == ".CSV";
  Arrays arrays;
  std::string text;
  for (std::size_t i = 0; i < report.recordings.size(); ++i) {
    const RecordingResult& id = report.recordings[i];
    if (!id.fit) continue;
    if (is_csv)
      add_lines(*id.fit, names, count > 1 ? csv_cell(valid_utf8(id.file)) + ',' : "", text);
    else
      add_draws(count > 1 ? std::to_string(places[i] + 1) + "/" : "", *id.fit, names, arrays);
  }
  if (is_csv) return write_file(path, text);
  dataset::write_arrays(path, arrays.all);
}

}  // namespace decid::tools
