// Several recordings in one file: see trials.hpp.
#include "recording/table/detail/trials.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "base/error.hpp"
#include "base/number.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "recording/detail/clock.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {
namespace {

constexpr std::size_t max_trials = 10'000;

const TableArray* array_called(const Table& table, const std::string& name) {
  const auto found = std::ranges::find(table.arrays(), name, &TableArray::name);
  return found == table.arrays().end() ? nullptr : &*found;
}

/// Joins two labels: rows have the same label if both labels are equal.
RowLabels joined(const RowLabels& a, const RowLabels& b) {
  RowLabels both;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> known;
  for (std::size_t row = 0; row < a.of_row.size(); ++row) {
    const auto pair = std::pair(a.of_row[row], b.of_row[row]);
    const auto [found, is_new] = known.try_emplace(pair, static_cast<std::uint32_t>(both.values.size()));
    if (is_new) {
      const std::string &first = a.values[pair.first], &second = b.values[pair.second];
      both.values.push_back(first.empty() || second.empty() ? std::string() : first + "," + second);
    }
    both.of_row.push_back(found->second);
  }
  return both;
}

bool distinguishes(const RowLabels& labels) {
  return labels.values.size() <= max_trials && 2 * labels.values.size() <= labels.of_row.size();
}

RowLabels labels_by(const Table& table, const std::vector<int>& columns, const std::string& by,
                    const std::string& where) {
  RowLabels labels = table.labels(columns.front());
  for (std::size_t i = 1; i < columns.size(); ++i) {
    if (table.rows(columns[i]) != table.rows(columns[0]))
      throw Error(Code::size_mismatch, where,
                  "the columns of " + setting("trial_column") + " " + by + " differ in length",
                  "name columns of equal length");
    labels = joined(labels, table.labels(columns[i]));
  }
  if (!distinguishes(labels))
    throw Error(Code::column_unsuitable, where,
                "'" + by + "' has " + std::to_string(labels.values.size()) + " values in " +
                    std::to_string(labels.of_row.size()) + " rows, and does not distinguish recordings",
                "give as " + setting("trial_column") + " a column with one value per recording");
  return labels;
}

/// Returns the index of the element that a trial's name denotes, from 0; nothing without one.
std::optional<std::size_t> element_of(const TableArray& array, const std::string& trial) {
  const std::size_t number = number_from<std::size_t>(trial).value_or(0);
  if (number < 1 || number > array.elements) return {};
  return number - 1;
}

[[noreturn]] void refuse_unknown(const std::string& trial, const std::string& by, const std::string& where) {
  throw Error(Code::setting_unknown, where, "has no recording '" + trial + "' by " + setting("trial_column") + " " + by,
              "name a recording of the file");
}

/// Returns the column's name in small letters, without blanks and signs.
std::string plain_name(const Table& table, int column) {
  return letters_of(table.own_name(column));
}

/// Returns true for names that divide a file even where its times run on.
bool names_trial_surely(const Table& table, int column) {
  return one_of(
      plain_name(table, column),
      {"trial", "trials", "trialno", "trialnr", "trialnumber", "trialid", "trialindex", "block", "blockno", "blocknr",
       "blocknumber", "blockid", "subject", "subjectid", "participant", "participantid", "session", "repetition"});
}

bool is_named_trial(const Table& table, int column) {
  return names_trial_surely(table, column) ||
         one_of(
             plain_name(table, column),
             {"repetitions", "subj",           "subjid",    "subjectno", "subjectnr", "subjectnumber", "pid",
              "person",      "personid",       "patient",   "patientid", "patientno", "patientnr",     "proband",
              "probandin",   "probandid",      "probandnr", "vp",        "vpn",       "vpnr",          "vpnnr",
              "vpid",        "versuchsperson", "versuch",   "versuchnr", "durchgang", "durchgangnr",   "wiederholung",
              "essai",       "essais",         "sujet",     "sujetid",   "rep",       "repno",         "repnr"});
}

/// Returns true for names that recordings have, but also states of a stimulus and marks within one recording.
bool may_name_trial(const Table& table, int column) {
  return one_of(plain_name(table, column),
                {"run",        "runs",        "runno",       "runnr", "runnumber", "runid",       "condition",
                 "conditions", "conditionid", "conditionno", "cond",  "bedingung", "bedingungen", "id",
                 "eyes",       "augen",       "set",         "sets",  "setno",     "visit"});
}

/// Returns true if each label is one stretch of rows: a state of the stimulus comes back. Rows without a label do not
/// count.
bool are_stretches(const RowLabels& labels) {
  std::vector<bool> ended(labels.values.size());
  std::optional<std::uint32_t> last;
  for (const std::uint32_t label : labels.of_row) {
    if (labels.values[label].empty() || label == last) continue;
    if (ended[label]) return false;
    if (last) ended[*last] = true;
    last = label;
  }
  return true;
}

/// A column whose values may distinguish recordings.
struct Divider {
  int column;
  RowLabels labels;
};

/// Returns the columns as long as the sway, except sway and time, that may distinguish recordings; columns called trial
/// or similar come first. `named_only`: leaves out columns without such a name.
std::vector<Divider> dividers(const Table& table, int sway, int time, bool named_only) {
  std::vector<Divider> found, others;
  for (int column = 0; column < table.columns(); ++column) {
    const bool is_named = is_named_trial(table, column), may_be = may_name_trial(table, column);
    if (column == sway || column == time || table.rows(column) != table.rows(sway) ||
        (named_only && !is_named && !may_be))
      continue;
    try {
      RowLabels labels = table.labels(column);
      if (distinguishes(labels) && (!named_only || is_named || are_stretches(labels)))
        (is_named ? found : others).push_back({column, std::move(labels)});
    } catch (const Error&) {  // an infinite number is not a label
    }
  }
  std::ranges::move(others, std::back_inserter(found));
  return found;
}

/// Lists the columns as --trial takes them: by name, or by number where a name has a comma or is not unique.
std::string listed(const Table& table, const std::vector<int>& columns) {
  return decid::joined(columns, ",", [&](int column) {
    const std::string& name = table.name(column);
    const bool is_clear = name.find(',') == std::string::npos && std::ranges::count(table.names(), name) == 1;
    return is_clear ? name : std::to_string(column + 1);
  });
}

/// Adds columns that distinguish more rows than those before them, until there are `wanted` groups. Returns nothing if
/// there are fewer in the end.
std::vector<int> separating_columns(std::vector<Divider> all, std::size_t wanted) {
  const auto groups = [](const RowLabels& labels) {
    return labels.values.size() - static_cast<std::size_t>(std::ranges::count(labels.values, ""));
  };
  const auto whole = std::ranges::find_if(all, [&](const Divider& one) { return groups(one.labels) >= wanted; });
  if (whole != all.end() && wanted > 0) return {whole->column};
  std::vector<int> columns;
  RowLabels labels;
  for (const Divider& one : all) {
    RowLabels more = columns.empty() ? one.labels : joined(labels, one.labels);
    if (groups(more) <= std::max<std::size_t>(groups(labels), 1)) continue;
    labels = std::move(more);
    columns.push_back(one.column);
    if (groups(labels) == wanted) break;
  }
  return groups(labels) >= wanted ? columns : std::vector<int>();
}

/// Returns labels of the stretches that begin at the rows `begins`; nothing if a stretch has several.
std::optional<RowLabels> of_stretches(const RowLabels& labels, const std::vector<std::size_t>& begins) {
  RowLabels made{labels.values, {}};
  for (std::size_t i = 0; i < begins.size(); ++i) {
    const std::size_t end = i + 1 < begins.size() ? begins[i + 1] : labels.of_row.size();
    for (std::size_t row = begins[i]; row < end; ++row)
      if (labels.of_row[row] != labels.of_row[begins[i]]) return {};
    made.of_row.push_back(labels.of_row[begins[i]]);
  }
  return made;
}

/// Returns true if all rows can be one recording: there are no times, or the times can be one recording's.
bool is_one_clock(const Table& table, int time) {
  try {
    return time < 0 || read_clock(table, time, "", "").rate_hz > 0.0;
  } catch (const Error&) {
    return false;
  }
}

std::string remedy_by(const std::string& by) {
  return setting("trial_column") + " '" + by + "' separates them";
}

}  // namespace

std::vector<int> trial_columns(const Table& table, const std::string& by, const std::string& where) {
  if (const std::string format = table.format_of_one(); !format.empty())
    throw Error(Code::setting_conflict, where, "is a " + format + ", which holds one recording",
                "leave out " + setting("trial_column"));
  if (array_called(table, by) != nullptr) return {};
  const bool is_one = std::ranges::find(table.names(), by) != table.names().end();
  std::vector<int> columns;
  for (std::size_t begin = 0; begin <= by.size();) {
    const std::size_t end = is_one ? by.size() : std::min(by.find(',', begin), by.size());
    columns.push_back(named_column(table, by.substr(begin, end - begin), where, setting("trial_column")));
    begin = end + 1;
  }
  return columns;
}

std::vector<std::string> trials_in(const Table& table, const std::string& by, const std::string& where) {
  std::vector<std::string> names;
  if (const TableArray* array = array_called(table, by)) {
    for (std::size_t i = 1; i <= array->elements; ++i) names.push_back(std::to_string(i));
    return names;
  }
  const RowLabels labels = labels_by(table, trial_columns(table, by, where), by, where);
  names = labels.values;
  std::erase(names, "");
  // 40 s at 5 Hz, the slowest rate, are 200 rows.
  constexpr std::size_t many_names = 20, few_rows = 50;
  if (names.size() > many_names && labels.of_row.size() < few_rows * names.size())
    throw Error(Code::column_unsuitable, where,
                "'" + by + "' has " + std::to_string(names.size()) + " values in " +
                    std::to_string(labels.of_row.size()) + " rows, as a signal has",
                "give the column that numbers the recordings as " + setting("trial_column"));
  if (names.empty())
    throw Error(Code::column_unsuitable, where, "'" + by + "' is empty in all rows",
                "give another column as " + setting("trial_column"));
  return names;
}

void keep_trial(Table& table, const std::string& by, const std::string& trial, const std::string& where) {
  if (const TableArray* array = array_called(table, by)) {
    const std::optional<std::size_t> element = element_of(*array, trial);
    if (!element) refuse_unknown(trial, by, where);
    return table.keep_element(std::string(by), *element);
  }
  const std::vector<int> columns = trial_columns(table, by, where);
  const RowLabels labels = labels_by(table, columns, by, where);
  const auto wanted = std::ranges::find(labels.values, trial);
  if (trial.empty() || wanted == labels.values.end()) refuse_unknown(trial, by, where);
  const auto number = static_cast<std::uint32_t>(wanted - labels.values.begin());
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < labels.of_row.size(); ++row)
    if (labels.of_row[row] == number) rows.push_back(row);
  table.keep_rows(columns.front(), rows);
}

std::string remedy_for_several(const Table& table, int sway, int time, const std::vector<std::size_t>& starts,
                               const std::string& by) {
  std::vector<std::size_t> begins{0};
  begins.insert(begins.end(), starts.begin(), starts.end());
  std::vector<Divider> constant;
  if (table.format_of_one().empty())
    for (Divider& one : dividers(table, sway, time, false))
      if (std::optional<RowLabels> labels = of_stretches(one.labels, begins))
        constant.push_back({one.column, std::move(*labels)});
  const std::vector<int> columns = separating_columns(std::move(constant), begins.size());
  if (!columns.empty()) return remedy_by(by.empty() ? listed(table, columns) : by + "," + listed(table, columns));
  return "save each recording as its own file, or add a column that numbers them and give it as " +
         setting("trial_column");
}

void refuse_several_trials(const Table& table, int sway, int time, const std::string& where) {
  if (!table.has_header() || !table.format_of_one().empty()) return;
  std::vector<Divider> changing;
  for (Divider& one : dividers(table, sway, time, true))
    if (std::ranges::count_if(one.labels.values, [](const std::string& value) { return !value.empty(); }) > 1)
      changing.push_back(std::move(one));
  if (changing.empty()) return;
  const std::vector<std::size_t> starts = time < 0 ? std::vector<std::size_t>() : restarts(table, time);
  const bool is_one = starts.empty() && is_one_clock(table, time);
  // Cycles and states of one recording have such names too; describe_change() names them.
  if (is_one) std::erase_if(changing, [&](const Divider& one) { return !names_trial_surely(table, one.column); });
  if (changing.empty()) return;
  const RowLabels& labels = changing.front().labels;
  const std::string& name = table.name(changing.front().column);
  const std::vector<std::uint32_t>& of_row = labels.of_row;
  const auto is_filled = [&](std::uint32_t label) { return !labels.values[label].empty(); };
  const std::uint32_t first = *std::ranges::find_if(of_row, is_filled);
  const auto other =
      std::ranges::find_if(of_row, [&](std::uint32_t label) { return label != first && is_filled(label); });
  const std::string problem = table.locate(static_cast<std::size_t>(other - of_row.begin())) + ": '" + name +
                              "' changes from '" + labels.values[first] + "' to '" + labels.values[*other] +
                              "': the file holds several recordings";
  if (!starts.empty())
    throw Error(Code::recording_ambiguous, where, problem, remedy_for_several(table, sway, time, starts, ""));
  const std::string advice = remedy_by(listed(table, separating_columns(std::move(changing), 0)));
  throw Error(Code::recording_ambiguous, where, problem,
              advice + (is_one ? "; " + setting("trial_column") + " none reads all rows as one" : ""));
}

std::pair<std::string, std::optional<double>> describe_change(const Table& table, int sway, int time, double rate_hz) {
  constexpr std::size_t looks = 9;  // cells that are looked at first: a signal has another value in each
  constexpr std::size_t max_values = 10;
  constexpr double min_mean_s = 2.0;  // of the stretches of a named column with more values: it may count seconds
  if (!table.has_header() || !table.format_of_one().empty()) return {};
  for (int column = 0; column < table.columns(); ++column) {
    const std::size_t rows = table.rows(column);
    if (column == sway || column == time || rows != table.rows(sway) || rows < 2 * max_values) continue;
    const std::string first = table.label(column, 0), last = table.label(column, rows - 1);
    std::size_t different = 0;
    for (std::size_t i = 1; i < looks; ++i)
      different +=
          table.label(column, i * (rows - 1) / (looks - 1)) != table.label(column, (i - 1) * (rows - 1) / (looks - 1));
    const bool is_named = is_named_trial(table, column) || may_name_trial(table, column);
    if (first.empty() || last.empty() || first == last || (different > looks / 2 && !is_named)) continue;
    const RowLabels labels = table.labels(column);
    const double mean_s = static_cast<double>(rows) / static_cast<double>(labels.values.size()) / rate_hz;
    const bool has_few = labels.values.size() <= max_values || (is_named && mean_s >= min_mean_s);
    if (!has_few || !distinguishes(labels) || !are_stretches(labels)) continue;
    const auto change = std::ranges::adjacent_find(labels.of_row, std::not_equal_to<>());
    const auto row = static_cast<std::size_t>(change - labels.of_row.begin()) + 1;
    const double change_s = static_cast<double>(row) / rate_hz;
    const std::string text = "'" + table.name(column) + "' changes from '" + first + "' to '" +
                             labels.values[labels.of_row[row]] + "' at " + six_digits(change_s) +
                             " s: if the file holds several recordings, " + remedy_by(listed(table, {column}));
    const bool may_be_trigger = labels.values.size() == 2 && !is_named;
    return {text, may_be_trigger ? std::optional(change_s) : std::nullopt};
  }
  return {};
}

std::string exchanged_with_time(const Table& table, int sway, int time) {
  for (int column = 0; column < table.columns(); ++column)
    if (column != time && (column == sway || is_named_trial(table, column)) && table.rows(column) == table.rows(time) &&
        is_one_clock(table, column))
      return table.name(column);
  return {};
}

}  // namespace decid::recording
