// Published frequency responses in files: see table.hpp.
#include "posterior/frf/table.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "posterior/density/elementary.hpp"
#include "recording/table/columns.hpp"
#include "recording/table/table.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::frf {
namespace {

constexpr std::size_t max_harmonics = 1000, max_table_rows = 1000;
constexpr double per_interval = 1.959963984540054;  // of a normal distribution: half its 95 % interval over its sd
constexpr double per_circle = 2.447746830680816;  // sqrt(-2 log 0.05), in two dimensions: the radius that contains 95 %

/// A column and its numbers.
struct Column {
  std::string name;
  std::vector<double> values;
};

class Reader {
 public:
  Reader(const recording::Table& table, std::string file) : table_(table), file_(std::move(file)) {}

  std::optional<Column> find(std::initializer_list<std::string_view> names) {
    for (const std::string_view name : names) {
      std::vector<int> found;
      for (int i = 0; i < table_.columns(); ++i)
        if (recording::name_without_unit(full_name(i)) == name) found.push_back(i);
      if (found.size() > 1)
        throw Error(Code::column_ambiguous, file_,
                    format("%zu columns are called %s", found.size(), std::string(name).c_str()), "rename all but one");
      if (!found.empty()) return read(found.front());
    }
    return {};
  }

  Column need(std::initializer_list<std::string_view> names) {
    if (std::optional<Column> found = find(names)) return std::move(*found);
    throw Error(
        Code::column_missing, file_,
        "has no column called " + std::string(*names.begin()) + "; its columns are " + recording::to_list(table_, -1),
        "name them frequency_hz, gain and phase_deg, or leave " + setting("frf") + " out for a recording");
  }

  /// Throws Error for the first value for which `right` is false.
  template <class Right>
  void check(const Column& column, const Right& right, const char* problem, const char* remedy) const {
    for (std::size_t i = 0; i < column.values.size(); ++i)
      if (!right(column.values[i]))
        throw Error(Code::value_invalid, file_,
                    format("%s, %s: %g %s", place(i).c_str(), column.name.c_str(), column.values[i], problem), remedy);
  }

  std::string place(std::size_t row) const { return table_.locate(row); }
  const std::string& file() const { return file_; }

 private:
  const std::string& full_name(int column) const { return table_.names()[static_cast<std::size_t>(column)]; }

  Column read(int column) {
    Column made{full_name(column), table_.numbers(column)};
    if (!rows_) rows_ = made.values.size();
    if (made.values.size() != *rows_)
      throw Error(
          Code::size_mismatch, file_,
          format("%s has %zu values, and there are %zu frequencies", made.name.c_str(), made.values.size(), *rows_),
          "give equal numbers");
    return made;
  }

  const recording::Table& table_;
  std::string file_;
  std::optional<std::size_t> rows_;  // of the first column read
};

bool is_positive(double value) {
  return value > 0.0;
}
bool is_count(double value) {
  return value >= 1.0 && value <= max_harmonics && value == std::floor(value);
}

Column read_frequencies(Reader& reader) {
  Column column = reader.need({"frequency_hz", "frequency", "frequencies", "freq_hz", "freq", "f_hz", "f", "hz"});
  reader.check(column, is_positive, "is not above 0", "give frequencies in Hz");
  for (std::size_t i = 1; i < column.values.size(); ++i) {
    const double here = column.values[i], before = column.values[i - 1];
    if (here == before)
      throw Error(Code::value_invalid, reader.file(), format("%s: %g Hz is repeated", reader.place(i).c_str(), here),
                  "give each frequency once");
    if (here < before)
      throw Error(Code::value_invalid, reader.file(),
                  format("%s: %g Hz comes after %g Hz", reader.place(i).c_str(), here, before),
                  "sort the table by frequency");
  }
  return column;
}

Column read_gains(Reader& reader) {
  if (const auto decibels = reader.find({"gain_db", "magnitude_db"}))
    throw Error(Code::unit_unknown, reader.file(), decibels->name + " is in decibels",
                "give sway over tilt, 10^(decibels / 20), as gain");
  Column column = reader.need({"gain", "gains", "magnitude", "modulus"});
  reader.check(column, is_positive, "is not above 0",
               "give sway over tilt; if these are decibels, 20 log10(gain), give 10^(decibels / 20)");
  return column;
}

/// Returns the phases in degrees.
Column read_phases(Reader& reader) {
  Column column = reader.need({"phase", "phases"});
  const std::optional<recording::Unit> unit = recording::unit_in(column.name);
  if (unit && *unit != recording::Unit::degree) {
    for (double& value : column.values) value *= recording::rad_in(*unit) / sim::rad_per_deg;
    return column;
  }
  const auto is_small = [](double value) { return std::abs(value) <= 2.0 * sim::pi; };
  if (std::ranges::all_of(column.values, is_small))
    throw Error(Code::unit_unknown, reader.file(), "has phases within 6.3 degrees only, which may be radians",
                "name the column phase_rad if they are radians");
  return column;
}

sim::Complex response_of(double gain, double phase_deg) {
  const double turns = phase_deg / 360.0;
  return gain * posterior::turned(turns - std::floor(turns));
}

void read_harmonics(Reader& reader, Table& table) {
  const auto column = reader.find({"harmonics"});
  if (!column) return;
  reader.check(*column, is_count, "is not a number of harmonics", "give the number of harmonics that a row averages");
  for (std::size_t i = 0; i < table.rows.size(); ++i) table.rows[i].harmonics = static_cast<int>(column->values[i]);
}

/// Returns half a unit of the last decimal place that a coherence has: a coherence of 0 or 1 was rounded to it.
double half_unit(const std::vector<double>& coherences) {
  constexpr int max_places = 6;
  double unit = 0.1;
  const auto is_whole = [&](double value) { return std::abs(value / unit - std::round(value / unit)) < 1e-6; };
  for (int places = 1; places < max_places && !std::ranges::all_of(coherences, is_whole); ++places) unit /= 10.0;
  return 0.5 * unit;
}

void take_coherence(const Reader& reader, const Column& coherence, const Column& cycles, const Column& gains,
                    Table& table) {
  reader.check(
      coherence, [](double value) { return value >= 0.0 && value <= 1.0; }, "is not between 0 and 1",
      "give the squared coherence");
  reader.check(cycles, is_count, "is not a number of cycles", "give the number of averaged cycles");
  const double min_squared = half_unit(coherence.values);
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const double averages = cycles.values[i] * std::max(1, table.rows[i].harmonics);
    const double squared = std::clamp(coherence.values[i], min_squared, 1.0 - min_squared);
    table.rows[i].coherence = squared;
    table.rows[i].stddev = gains.values[i] * std::sqrt((1.0 - squared) / (2.0 * squared * averages));
  }
}

void read_confidence(Reader& reader, const Column& gains, Table& table) {
  const auto stddev = reader.find({"sd", "gain_sd", "se", "gain_se", "sem", "gain_sem", "standard_deviation",
                                   "standard_error", "gain_standard_deviation", "gain_standard_error"});
  const auto interval = reader.find({"ci95", "gain_ci95", "ci_95", "gain_ci_95"});
  const auto circle = reader.find({"radius95", "radius_95", "radius"});
  const auto coherence = reader.find({"coherence"}), cycles = reader.find({"cycles"});
  if (coherence && !cycles)
    throw Error(Code::column_missing, reader.file(), "has coherence, and no column called cycles",
                "add a column with the number of averaged cycles, or leave the coherence out");
  std::vector<std::string> kinds;
  for (const auto* column : {&stddev, &interval, &circle, &coherence})
    if (*column) kinds.push_back((*column)->name);
  if (kinds.empty()) return;
  if (kinds.size() > 1)
    throw Error(Code::column_ambiguous, reader.file(), "has two kinds of confidence, " + kinds[0] + " and " + kinds[1],
                "remove one of them");
  table.confidence = kinds.front();
  if (coherence) return take_coherence(reader, *coherence, *cycles, gains, table);
  const Column& given = stddev ? *stddev : interval ? *interval : *circle;
  const double divisor = stddev ? 1.0 : interval ? per_interval : per_circle;
  reader.check(given, is_positive, "is not above 0", "give a confidence for each row, or leave the column out");
  for (std::size_t i = 0; i < table.rows.size(); ++i) table.rows[i].stddev = given.values[i] / divisor;
}

}  // namespace

Table read_table(const std::filesystem::path& path) {
  const auto read = recording::read_table(path);
  Reader reader(*read, path.string());
  if (!read->has_header())
    throw Error(Code::column_missing, path.string(), "has no header",
                "name the columns frequency_hz, gain and phase_deg in its first line");
  const Column frequencies = read_frequencies(reader), gains = read_gains(reader), phases = read_phases(reader);
  const std::size_t rows = frequencies.values.size();
  if (rows < min_table_rows || rows > max_table_rows)
    throw Error(Code::setting_out_of_range, path.string(), "has " + counted(std::ssize(frequencies.values), "row"),
                format("give %d to %zu frequencies", min_table_rows, max_table_rows));
  Table table;
  table.file = path.string();
  for (std::size_t i = 0; i < rows; ++i)
    table.rows.push_back({frequencies.values[i], response_of(gains.values[i], phases.values[i]), 0.0, 0, 0.0});
  read_harmonics(reader, table);
  read_confidence(reader, gains, table);
  return table;
}

}  // namespace decid::frf
