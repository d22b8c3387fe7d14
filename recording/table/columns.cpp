// Columns of a table: see columns.hpp. The search rules are made for EUROBENCH files (time,COM_x), motion capture
// exports and decid's own files.
#include "recording/table/columns.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/error.hpp"
#include "base/number.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "recording/formats/encoding.hpp"

namespace decid::recording {

namespace {

/// The allowed deviation of a step from the mean step, if an unnamed column is to be the time.
constexpr double step_tolerance = 0.01;

bool begins_with_t(std::string_view name) {
  return words(name).front() == "t";
}

/// The names of the platform's tilt, without units; the earliest counts.
constexpr std::initializer_list<const char*> tilt_names = {"tilt",
                                                           "platform_tilt",
                                                           "platform",
                                                           "plattform",
                                                           "platform_angle",
                                                           "tilt_angle",
                                                           "plattformwinkel",
                                                           "kippwinkel",
                                                           "support_tilt",
                                                           "a_fs",
                                                           "support_surface",
                                                           "stimulus",
                                                           "platform_pitch",
                                                           "surface_tilt",
                                                           "surface_angle",
                                                           "support_surface_tilt",
                                                           "support_surface_angle",
                                                           "base_angle",
                                                           "base_tilt",
                                                           "stim_pitch",
                                                           "stim_tilt",
                                                           "stimulus_angle",
                                                           "ss",
                                                           "ss_angle"};

/// Returns "sway_deg" for "sway_deg(:,2)", "sway_deg(2,:,1)" and "sway_deg{2}".
std::string_view without_index(std::string_view name) {
  while (name.size() > 2 && (name.back() == ')' || name.back() == '}')) {
    const std::size_t open = name.find_last_of(name.back() == ')' ? '(' : '{');
    if (open == name.npos || open == 0) return name;
    const std::string_view index = name.substr(open + 1, name.size() - open - 2);
    const bool has_colon = index.find(':') != index.npos;
    if (index.find_first_not_of("0123456789:,") != index.npos || (name.back() == ')' && !has_colon)) return name;
    name = name.substr(0, open);
  }
  return name;
}

}  // namespace

bool is_time_name(std::string_view name) {
  const std::vector<std::string> parts = words(name);
  const auto is_time = [](std::string_view word) {
    return one_of(word, {"time",     "times",        "timestamp", "timestamps",  "zeit",      "zeitstempel",
                         "uhrzeit",  "temps",        "tiempo",    "tempo",       "datetime",  "seconds",
                         "sekunden", "sec",          "ms",        "elapsedtime", "mocaptime", "sampletime",
                         "reltime",  "relativetime", "frametime", "systemtime",  "abstime"});
  };
  // "Elapsed Time (s)", "rel_time_s", "abs time", "Sample Time"
  const bool is_second =
      parts.size() > 1 && is_time(parts[1]) &&
      one_of(parts[0], {"elapsed", "rel", "relative", "abs", "absolute", "sample", "sampling", "mocap", "frame",
                        "system", "local", "unix", "recording", "trial", "capture"});
  // Delsys writes "X [s]" before each signal.
  const bool is_abscissa = parts.size() == 2 && parts[0] == "x" && unit_behind(name) == "s";
  return is_time(parts.front()) || is_second || is_abscissa ||
         (begins_with_t(name) && std::all_of(parts.begin() + 1, parts.end(), [](const std::string& word) {
            return one_of(word, {"in", "s", "sec", "sek", "seconds", "sekunden"}) || time_unit_s(word) != 1.0;
          }));
}

bool is_nanoseconds_name(std::string_view name) {
  return one_of(words(name).back(), {"nsec", "nsecs", "nanosec", "nanosecs"});
}

int nanoseconds_beside(const std::vector<std::string>& names, int seconds) {
  std::vector<std::string> stem = words(names[static_cast<std::size_t>(seconds)]);
  if (!one_of(stem.back(), {"sec", "secs"})) return -1;
  stem.pop_back();
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::vector<std::string> parts = words(names[i]);
    if (!is_nanoseconds_name(names[i])) continue;
    parts.pop_back();
    if (parts == stem) return static_cast<int>(i);
  }
  return -1;
}

double near_whole(double rate_hz) {
  const double whole = std::round(rate_hz);
  return std::abs(rate_hz - whole) < 1e-6 * rate_hz ? whole : rate_hz;
}

std::string six_digits(double value) {
  return format("%.6g", value);
}

std::string three_digits(double value) {
  return format("%.3g", value);
}

std::vector<std::string> words(std::string_view name) {
  std::vector<std::string> parts(1);
  for (const char c : with_plain_blanks(std::string(without_index(name)))) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) || byte >= 0x80) {
      parts.back() += static_cast<char>(std::tolower(byte));
    } else if (!parts.back().empty()) {
      parts.emplace_back();
    }
  }
  if (parts.back().empty() && parts.size() > 1) parts.pop_back();
  return parts;
}

std::string letters_of(std::string_view name) {
  return joined(words(name), "");
}

std::vector<std::string> words_in(std::string_view name) {
  std::vector<std::string> parts = words(name);
  const auto is_upper = [](char c) { return c >= 'A' && c <= 'Z'; };
  const auto is_lower = [](char c) { return c >= 'a' && c <= 'z'; };
  std::string text(name), spaced;
  for (const char* centre : {"CoM", "CoG", "CoP"})  // one word each
    for (std::size_t at = text.find(centre); at != text.npos; at = text.find(centre, at + 1)) text[at + 1] = 'O';
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool is_after_lower = i > 0 && is_lower(text[i - 1]);
    const bool is_last_capital = i > 0 && is_upper(text[i - 1]) && i + 1 < text.size() && is_lower(text[i + 1]);
    if (is_upper(text[i]) && (is_after_lower || is_last_capital)) spaced += ' ';
    spaced += text[i];
  }
  for (std::string& part : words(spaced))
    if (std::ranges::find(parts, part) == parts.end()) parts.push_back(std::move(part));
  return parts;
}

bool one_of(std::string_view word, std::initializer_list<std::string_view> list) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

std::string to_list(const Table& table, int without) {
  std::string list;
  for (int i = 0; i < table.columns(); ++i) {
    if (i == without) continue;
    if (list.size() > 200) return list + ", ...";
    list += (list.empty() ? "'" : ", '") + table.name(i) + "'";
  }
  return list;
}

void refuse_several(const Table& table, const std::vector<int>& columns, const std::string& name,
                    const std::string& where, const std::string& setting_name) {
  const auto& names = table.names();
  std::string numbers, list;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    numbers += (i == 0 ? "" : i + 1 < columns.size() ? ", " : " and ") + std::to_string(columns[i] + 1);
    if (list.size() < 200) list += (i == 0 ? "'" : ", '") + names[static_cast<std::size_t>(columns[i])] + "'";
  }
  const auto has_path = [&](int column) {
    return table.own_name(column) != names[static_cast<std::size_t>(column)] || !table.arrays().empty();
  };
  if (std::ranges::none_of(columns, has_path))
    throw Error(Code::column_ambiguous, where,
                std::to_string(columns.size()) + " columns are called '" + name + "', numbers " + numbers,
                "give the column's number, from 1, as " + setting_name);
  throw Error(Code::column_ambiguous, where,
              "has several columns called '" + std::string(without_index(name)) + "': " + list,
              "name one with " + setting_name + trial_advice(table));
}

std::string trial_advice(const Table& table) {
  for (const bool is_matrix : {false, true})
    for (const TableArray& array : table.arrays())
      if (array.is_matrix == is_matrix && array.elements > 1)
        return "; " + setting("trial_column") + " " + array.name + " makes each of its " +
               std::to_string(array.elements) + (is_matrix ? " columns" : " elements") + " a recording";
  return "";
}

int find_named(const Table& table, int without, std::initializer_list<const char*> names, const std::string& where,
               const std::string& setting_name) {
  for (const char* name : names) {
    std::vector<int> found;
    for (int i = 0; i < table.columns(); ++i) {
      const std::string& here = table.own_name(i);
      if (i == without || name_without_unit(here) != name) continue;
      if (found.empty() || without_index(here) == without_index(table.own_name(found.front()))) found.push_back(i);
    }
    if (found.size() > 1) refuse_several(table, found, table.own_name(found.front()), where, setting_name);
    if (!found.empty()) return found.front();
  }
  return -1;
}

int named_column(const Table& table, const std::string& column, const std::string& where,
                 const std::string& setting_name) {
  // In this order: the exact name; another case; without its unit: "KSP" for "KSP (deg)"; a number; then "LHIP_x" for
  // "LHIP_x_mm"; then the same behind the name of a subject, as Vicon writes it: "HIP X" for "Sub1:HIP X (mm)".
  const auto key = [](const std::string& text) { return lower_case(with_plain_blanks(text)); };
  const std::string joined_words = joined(words(column), "_");
  std::vector<int> exact, paths, alike, plain, suffixed, of_subject;
  for (int i = 0; i < table.columns(); ++i) {
    const std::string& name = table.name(i);
    if (name == column) exact.push_back(i);
    if (table.path(i) == column) paths.push_back(i);
    if (key(name) == key(column)) alike.push_back(i);
    if (key(name_before_unit(name)) == key(column)) plain.push_back(i);
    if (!joined_words.empty() && name_without_unit(name) == joined_words) suffixed.push_back(i);
    const std::string behind = name.substr(std::min(name.find(':'), name.size() - 1) + 1);
    if (!behind.empty() && !joined_words.empty() && name_without_unit(behind) == joined_words) of_subject.push_back(i);
  }
  const int number = number_from<int>(column).value_or(0);
  std::vector<int> numbered;
  if (number >= 1 && number <= table.columns()) numbered.push_back(number - 1);
  for (const std::vector<int>& found : {exact, paths, alike, plain, numbered, suffixed, of_subject}) {
    if (found.size() == 1) return found.front();
    if (found.size() > 1) refuse_several(table, found, column, where, setting_name);
  }
  if (column.find(',') != column.npos)
    throw Error(Code::column_missing, where,
                "has no column '" + column + "', and decid does not average columns, as those of left and right",
                "name one column as " + setting_name + ", or add one with their mean to the file; its columns are " +
                    to_list(table, -1));
  throw Error(Code::column_missing, where, "has no column '" + column + "'; its columns are " + to_list(table, -1),
              "give one of them, or its number from 1, as " + setting_name);
}

std::optional<StatedRate> stated_rate(const Table& table, const std::string& where, const std::string& setting_name) {
  const std::vector<StatedRate> rates = candidates(table.stated_rates());
  if (rates.empty()) return {};
  if (rates.size() > 1)
    throw Error(Code::rate_unknown, where, "states several rates: " + to_list(rates),
                "give the samples per second as " + setting_name);
  if (!is_sample_rate(rates.front().hz))
    throw Error(Code::setting_out_of_range, where,
                "its own rate is " + six_digits(rates.front().hz) + " Hz, not from 1 to 100,000",
                "give the samples per second as " + setting_name);
  return rates.front();
}

namespace {

/// Returns a column's times; none if a cell is missing or is not a time.
std::vector<double> times_or_none(const Table& table, int column) {
  try {
    return table.times(column);
  } catch (const Error&) {
    return {};
  }
}

}  // namespace

int find_time(const Table& table) {
  if (table.is_even()) return -1;
  if (table.has_header()) {
    std::vector<std::string> names;
    for (int i = 0; i < table.columns(); ++i) names.push_back(table.own_name(i));
    auto found = std::find_if(names.begin(), names.end(), is_time_name);
    const auto may_be_time = [](const std::string& name) {
      return begins_with_t(name) && !one_of(words(name).back(), {"c", "degc", "\u00B0c", "f", "k"});  // a temperature
    };
    // "header.stamp" and "header.stamp.sec" of ROS; the nanoseconds start again each second.
    const auto is_stamp = [](const std::string& name) {
      return std::ranges::count(words(name), "stamp") > 0 && !is_nanoseconds_name(name);
    };
    const auto has_nanoseconds = [&](const std::string& name) {
      return nanoseconds_beside(names, static_cast<int>(&name - names.data())) >= 0;
    };
    if (found == names.end()) found = std::find_if(names.begin(), names.end(), is_stamp);
    if (found == names.end()) found = std::find_if(names.begin(), names.end(), has_nanoseconds);
    if (found == names.end()) found = std::find_if(names.begin(), names.end(), may_be_time);
    return found == names.end() ? -1 : static_cast<int>(found - names.begin());
  }
  const int column = table.first_column();
  if (table.columns() < 2 || table.rows(column) < 3) return -1;
  const std::vector<double> first = times_or_none(table, column);
  if (first.empty()) return -1;
  const double step = (first.back() - first.front()) / static_cast<double>(first.size() - 1);
  for (const StatedRate& rate : table.stated_rates())  // a counter of samples has no rate
    if (std::abs(step * rate.hz - 1.0) > step_tolerance) return -1;
  for (std::size_t i = 1; i < first.size(); ++i) {
    const double found = first[i] - first[i - 1];
    if (found <= 0.0 || std::abs(found - step) > 2.0 * step_tolerance * step) return -1;
  }
  return column;
}

int find_tilt_column(const Table& table, int without, const std::string& where, const std::string& setting_name) {
  return find_named(table, without, tilt_names, where, setting_name);
}

std::vector<int> tilt_columns(const Table& table, int without) {
  std::vector<int> columns;
  for (int i = 0; i < table.columns(); ++i) {
    const std::string name = name_without_unit(table.own_name(i));
    if (i != without && std::ranges::find(tilt_names, name) != tilt_names.end()) columns.push_back(i);
  }
  return columns;
}

double time_unit_s(std::string_view name) {
  const std::string unit = words(name).back();
  if (one_of(unit, {"min", "minutes", "minuten"})) return 60.0;
  if (one_of(unit, {"ms", "msec", "msecs", "msecond", "mseconds", "milliseconds", "millisekunden"})) return 1e-3;
  if (one_of(unit, {"us", "usec", "\xC2\xB5s", "microseconds", "mikrosekunden"})) return 1e-6;
  if (one_of(unit, {"ns", "nsec", "nanoseconds", "nanosekunden"})) return 1e-9;
  if (one_of(unit, {"days", "tage"})) return 86400.0;
  return 1.0;
}

}  // namespace decid::recording
