// Reports as a table and as draws: see results.hpp.
#include <cmath>
#include <deque>

#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "dataset/npz/arrays.hpp"
#include "tools/decid/results/results.hpp"

namespace decid::tools {
namespace {

/// A number as JSON prints it; nothing for one that is not finite.
std::string number_cell(double value) {
  return std::isfinite(value) ? Json(value).dump() : std::string();
}

/// A file's name need not be UTF-8, the table is: other bytes are replaced.
std::string text_cell(const std::string& text) {
  return csv_cell(valid_utf8(text));
}

std::string parameter_cells(const RecordingResult& id) {
  const std::size_t parameters = id.estimate.parameters.size();
  std::vector<std::string> intervals(parameters, ",");
  use_distribution(id, [&](const auto& found) {
    for (std::size_t p = 0; p < parameters; ++p)
      intervals[p] = number_cell(found.quantile(static_cast<int>(p), 0.5 * (1.0 - 0.9))) + ',' +
                     number_cell(found.quantile(static_cast<int>(p), 1.0 - 0.5 * (1.0 - 0.9)));
  });
  std::string text;
  for (std::size_t p = 0; p < parameters; ++p)
    text += ',' + number_cell(id.estimate.parameters[p]) + ',' + intervals[p];
  return text;
}

/// Draws as columns of numbers, and the arrays that refer to them.
struct Columns {
  std::deque<std::vector<double>> values;
  std::vector<dataset::NamedArray> arrays;

  template <class ValueOf>
  void add(const std::string& name, const posterior::Posterior& found, const ValueOf& value_of) {
    std::vector<double>& column = values.emplace_back();
    for (const posterior::State& state : found.states()) column.push_back(value_of(state));
    arrays.push_back({name, {column.size()}, column});
  }
};

void add_draws(const std::string& prefix, const posterior::Posterior& found, Columns& columns) {
  using posterior::State;
  std::vector<double>& parameters = columns.values.emplace_back();
  for (const State& state : found.states())
    parameters.insert(parameters.end(), state.parameters.begin(), state.parameters.end());
  const std::size_t draws = found.states().size();
  columns.arrays.push_back({prefix + "parameters", {draws, parameters.size() / draws}, parameters});
  columns.add(prefix + "sensor_noise_deg", found, [](const State& state) { return state.sensor_noise_deg; });
  columns.add(prefix + "slow_noise_deg", found, [](const State& state) { return state.slow_noise_deg; });
  columns.add(prefix + "start_s", found, [](const State& state) { return state.start_s; });
  columns.add(prefix + "gain", found, [](const State& state) { return state.gain; });
  columns.add(prefix + "chain", found, [&](const State& state) {
    return static_cast<double>((&state - found.states().data()) / found.draws_per_chain());
  });
}

}  // namespace

std::string report_table(const Report& report) {
  const sim::ParameterTable& parameters = report.protocol.parameters();
  std::string text = "file,trust";
  for (const std::string& name : parameters.names()) text += ',' + name + ',' + name + "_low90," + name + "_high90";
  text += ",error\n";
  for (const RecordingResult& id : report.recordings) {
    text += text_cell(id.file) + ',';
    text += id.error ? std::string(3 * parameters.size(), ',') : name(id.trust()) + parameter_cells(id);
    text += ',' + (id.error ? text_cell(id.error->what()) : std::string()) + '\n';
  }
  return text;
}

void write_draws(const std::filesystem::path& path, const Report& report, std::span<const std::size_t> places,
                 std::size_t count) {
  Columns columns;
  for (std::size_t i = 0; i < report.recordings.size(); ++i)
    if (const std::optional<FitFigures>& fit = report.recordings[i].fit)
      add_draws(count > 1 ? std::to_string(places[i] + 1) + "/" : "", fit->posterior, columns);
  dataset::write_arrays(path, columns.arrays);
}

}  // namespace decid::tools
