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
// No sway over a tilt is beyond these.
constexpr double min_table_gain = 1e-6, max_table_gain = 1e3;
constexpr double per_interval = 1.959963984540054;  // of a normal distribution: half its 95 % interval over its sd
constexpr double per_circle = 2.447746830680816;  // sqrt(-2 log 0.05), in two dimensions: the radius that contains 95 %

/// A column, its numbers, and the unit that its name or the line below the names gives; empty: none.
struct Column {
  std::string name;
  std::string unit;
  std::vector<double> values;
};

/// A quantity of the table.
struct Role {
  const char* quantity;
  std::initializer_list<std::string_view> names;
  bool (*has_unit)(std::string_view unit);
  std::string (*remedy)(std::string_view unit);  ///< for other units
};

bool is_unit_word(const std::string& word) {
  return recording::one_of(word, {"mm", "cm", "m", "hz", "mhz", "khz", "s", "ms"}) || recording::unit_in(word);
}

/// Returns a unit as this file calls it, empty for a plain number. Returns nothing for other text.
std::optional<std::string> find_unit(std::string_view text) {
  const std::string unit = lower_case(std::string(text));
  if (recording::one_of(unit, {"-", "ratio", "deg/deg", "\u00B0/\u00B0", "rad/rad"})) return "";
  if (recording::one_of(unit, {"%", "percent", "pct", "prozent"})) return "percent";
  if (unit == "db") return "decibels";
  if (unit == "hz") return "Hz";
  return std::ranges::all_of(recording::words(text), is_unit_word) ? std::optional<std::string>(text) : std::nullopt;
}

bool is_angle(std::string_view unit) {
  return recording::words(unit).size() == 1 && recording::unit_in(unit);
}

/// A column's name in lower case without its unit, and the unit: "gain" and "decibels" for "Gain (dB)" and "gain_db".
struct Parts {
  std::string name, unit;
};
Parts parts_of(const std::string& full_name) {
  if (const std::string_view behind = recording::unit_behind(full_name); !behind.empty())
    if (std::optional<std::string> unit = find_unit(behind))
      return {joined(recording::words(recording::name_before_unit(full_name)), "_"), std::move(*unit)};
  std::vector<std::string> words = recording::words(full_name);
  if (words.size() == 1) return {words.front(), ""};
  if (recording::unit_in(words.front()) && !recording::unit_in(words.back()))
    std::rotate(words.begin(), words.begin() + 1, words.end());
  const bool may_be_unit = !recording::one_of(words.back(), {"ratio", "s", "ms"});
  std::optional<std::string> unit = may_be_unit ? find_unit(words.back()) : std::nullopt;
  if (unit) words.pop_back();
  return {joined(words, "_"), unit.value_or("")};
}

bool is_ratio(std::string_view unit) {
  return unit.empty();
}

const Role frequency_role{"the frequency",
                          {"frequency", "frequencies", "freq", "f", "hz"},
                          [](std::string_view unit) { return unit.empty() || unit == "Hz"; },
                          [](std::string_view) { return std::string("give frequencies in Hz"); }};
const Role gain_role{"the gain", {"gain", "gains", "magnitude", "modulus"}, is_ratio, [](std::string_view unit) {
                       return std::string("give sway over tilt") + (unit == "decibels"  ? ", 10^(decibels / 20)"
                                                                    : unit == "percent" ? ", percent / 100"
                                                                                        : ", degrees per degree");
                     }};
const Role phase_role{"the phase",
                      {"phase", "phases"},
                      [](std::string_view unit) { return unit.empty() || is_angle(unit); },
                      [](std::string_view) { return std::string("give degrees (phase_deg) or radians (phase_rad)"); }};
std::string remedy_for_spread(std::string_view unit) {
  return std::string("give it as the gain, sway over tilt") +
         (unit == "percent" ? ": percent / 100 times the gain, if these are percent of the gain" : "");
}
const Role stddev_role{"the standard deviation",
                       {"sd", "gain_sd", "se", "gain_se", "sem", "gain_sem", "standard_deviation", "standard_error",
                        "gain_standard_deviation", "gain_standard_error"},
                       is_ratio,
                       remedy_for_spread};
const Role interval_role{"the 95% interval", {"ci95", "gain_ci95", "ci_95", "gain_ci_95"}, is_ratio, remedy_for_spread};
const Role circle_role{"the radius", {"radius95", "radius_95", "radius"}, is_ratio, remedy_for_spread};
const Role coherence_role{"the coherence", {"coherence"}, is_ratio, [](std::string_view unit) {
                            return std::string("give the squared coherence") +
                                   (unit == "percent" ? ", percent / 100" : "");
                          }};
std::string remedy_for_count(std::string_view) {
  return "give a whole number without a unit";
}
const Role cycles_role{"the number of cycles", {"cycles"}, is_ratio, remedy_for_count};
const Role harmonics_role{"the number of harmonics", {"harmonics"}, is_ratio, remedy_for_count};

class Reader {
 public:
  Reader(const recording::Table& table, std::string file) : table_(table), file_(std::move(file)) {}

  std::optional<Column> find(const Role& role) {
    std::vector<int> found;
    for (int i = 0; i < table_.columns(); ++i)
      if (std::ranges::find(role.names, parts_of(table_.name(i)).name) != role.names.end()) found.push_back(i);
    if (found.empty()) return {};
    if (found.size() > 1)
      throw Error(Code::column_ambiguous, file_,
                  format("%zu columns give %s: ", found.size(), role.quantity) +
                      joined(found, ", ", [&](int column) { return "'" + table_.name(column) + "'"; }),
                  "rename all but one");
    const std::string& name = table_.name(found.front());
    const std::string unit = parts_of(name).unit;
    if (!role.has_unit(unit)) throw Error(Code::unit_unknown, file_, name + " is in " + unit, role.remedy(unit));
    return read(found.front());
  }

  Column need(const Role& role) {
    if (std::optional<Column> found = find(role)) return std::move(*found);
    throw Error(Code::column_missing, file_,
                "has no column called " + std::string(*role.names.begin()) + "; its columns are " +
                    recording::to_list(table_, -1),
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
  Column read(int column) {
    Column made{table_.name(column), parts_of(table_.name(column)).unit, table_.numbers(column)};
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
  Column column = reader.need(frequency_role);
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
  Column column = reader.need(gain_role);
  reader.check(column, is_positive, "is not above 0",
               "give sway over tilt; if these are decibels, 20 log10(gain), give 10^(decibels / 20)");
  reader.check(
      column, [](double value) { return value >= min_table_gain && value <= max_table_gain; },
      "is not within 1e-6 to 1000", "give sway over tilt, degrees per degree");
  return column;
}

/// Returns the phases in degrees.
Column read_phases(Reader& reader) {
  Column column = reader.need(phase_role);
  if (!column.unit.empty()) {
    const recording::Unit unit = *recording::unit_in(column.unit);
    if (unit != recording::Unit::degree)
      for (double& value : column.values) value *= recording::rad_in(unit) / sim::rad_per_deg;
    return column;
  }
  const auto is_small = [](double value) { return std::abs(value) <= 2.0 * sim::pi; };
  if (std::ranges::all_of(column.values, is_small))
    throw Error(Code::unit_unknown, reader.file(), "has phases within 6.3 degrees only, which may be radians",
                "name the column phase_deg or phase_rad");
  return column;
}

sim::Complex response_of(double gain, double phase_deg) {
  const double turns = phase_deg / 360.0;
  return gain * posterior::turned(turns - std::floor(turns));
}

void read_harmonics(Reader& reader, Table& table) {
  const auto column = reader.find(harmonics_role);
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
  const auto stddev = reader.find(stddev_role), interval = reader.find(interval_role);
  const auto circle = reader.find(circle_role);
  const auto coherence = reader.find(coherence_role), cycles = reader.find(cycles_role);
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
  recording::require_whole(*read, path.string());
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
