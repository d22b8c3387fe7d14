// Several recordings in one file: see trials.hpp.
#include "dataset/recording/trials.hpp"

#include <algorithm>
#include <charconv>
#include <map>
#include <optional>
#include <utility>

#include "base/error.hpp"
#include "dataset/recording/columns.hpp"

namespace decid::dataset {
namespace {

constexpr std::size_t most_trials = 10'000;

const TableArray* array_called(const Table& table, const std::string& name) {
  const auto found = std::ranges::find(table.arrays(), name, &TableArray::name);
  return found == table.arrays().end() ? nullptr : &*found;
}

/// Rows have the same label if they have the same in both.
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

RowLabels labels_by(const Table& table, const std::vector<int>& columns, const std::string& by,
                    const std::string& where) {
  RowLabels labels = table.labels(columns.front());
  for (std::size_t i = 1; i < columns.size(); ++i) {
    if (table.rows(columns[i]) != table.rows(columns[0]))
      throw Error(where, "the columns of --trial " + by + " differ in length", "name columns of one table");
    labels = joined(labels, table.labels(columns[i]));
  }
  const std::size_t rows = labels.of_row.size(), values = labels.values.size();
  if (values > most_trials || 2 * values > rows)
    throw Error(where,
                "'" + by + "' has " + std::to_string(values) + " values in " + std::to_string(rows) +
                    " rows, and does not tell recordings apart",
                "name as --trial a column with one value for each recording");
  return labels;
}

/// The element that a trial's name is, from 0; nothing if there is none.
std::optional<std::size_t> element_of(const TableArray& array, const std::string& trial) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(trial.data(), trial.data() + trial.size(), number);
  if (error != std::errc() || end != trial.data() + trial.size() || number < 1 || number > array.elements) return {};
  return number - 1;
}

[[noreturn]] void refuse_unknown(const std::string& trial, const std::string& by, const std::string& where) {
  throw Error(where, "has no recording '" + trial + "' by --trial " + by, "name one that the file has");
}

}  // namespace

std::vector<int> trial_columns(const Table& table, const std::string& by, const std::string& where) {
  if (const std::string format = table.format_of_one(); !format.empty())
    throw Error(where, "is a " + format + ", which holds one recording", "leave out --trial");
  if (array_called(table, by) != nullptr) return {};
  const bool is_one = std::ranges::find(table.names(), by) != table.names().end();
  std::vector<int> columns;
  for (std::size_t begin = 0; begin <= by.size();) {
    const std::size_t end = is_one ? by.size() : std::min(by.find(',', begin), by.size());
    columns.push_back(named_column(table, by.substr(begin, end - begin), where, "--trial"));
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
  names = labels_by(table, trial_columns(table, by, where), by, where).values;
  std::erase(names, "");
  if (names.empty()) throw Error(where, "'" + by + "' is empty in all rows", "name another column as --trial");
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

void refuse_several_trials(const Table& table, int sway, const std::string& where) {
  if (!table.has_header() || !table.format_of_one().empty()) return;
  for (int column = 0; column < table.columns(); ++column) {
    std::string plain;
    for (const std::string& word : words(table.own_name(column))) plain += word;
    if (column == sway || table.rows(column) != table.rows(sway)) continue;
    if (!one_of(plain, {"trial", "trials", "trialno", "trialnr", "trialnumber", "trialid", "trialindex", "block",
                        "blockno", "blocknr", "blocknumber", "blockid", "subject", "subjectid", "participant",
                        "participantid", "session", "repetition"}))
      continue;
    const RowLabels labels = table.labels(column);
    std::optional<std::uint32_t> first;
    for (std::size_t row = 0; row < labels.of_row.size(); ++row) {
      const std::uint32_t label = labels.of_row[row];
      if (labels.values[label].empty()) continue;
      if (!first) first = label;
      if (label == *first) continue;
      const std::string& name = table.names()[static_cast<std::size_t>(column)];
      throw Error(where,
                  table.place_of(row) + ": '" + name + "' changes from '" + labels.values[*first] + "' to '" +
                      labels.values[label] + "': the file holds several recordings",
                  remedy_for_several(name));
    }
  }
}

std::string remedy_for_several(const std::string& by) {
  if (by.empty())
    return "give each of them as a file of its own, or add a column that numbers them and name it as --trial to decid "
           "identify or decid fit";
  return "--trial '" + by +
         "' makes each of them one, in decid identify and decid fit; --trial none reads all rows as one";
}

}  // namespace decid::dataset
