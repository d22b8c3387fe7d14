// MAT-files: see mat.hpp. This file names columns and finds which of them belong together.
#include "recording/formats/detail/mat/mat.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.hpp"
#include "recording/formats/detail/mat/mat_5.hpp"
#include "recording/formats/detail/mat/mat_73.hpp"

namespace decid::recording {

namespace {

/// Returns the remedy for variables that are not columns, by their kinds.
std::string remedy_for(const std::string& unread) {
  const auto has = [&](const char* name) { return unread.find(name) != std::string::npos; };
  if (has("timeseries object"))
    return "save its parts in MATLAB: time = ts.Time; sway = ts.Data; save('file.mat', 'time', 'sway')";
  if (has("table object")) return "write it in MATLAB as text: writetable(T, 'file.csv'), or writetimetable";
  if (has(" numbers)"))
    return "put the samples first in MATLAB, for example x = permute(x, [3 1 2]), and save it again";
  return "save it in MATLAB with save('file.mat', 'time', 'sway'), or as CSV";
}

}  // namespace

MatTable::MatTable(std::string_view bytes, const std::filesystem::path& path) : where_(path.string()) {
  const MatVersion version = mat_version(bytes);
  if (version == MatVersion::none)
    throw Error(Code::file_damaged, where_, "is damaged, or is not a MAT-file that decid reads", remedy_for(""));
  content_ = make_columns(version == MatVersion::v73  ? read_mat_73(path, bytes.size())
                          : version == MatVersion::v5 ? read_mat_5(bytes, where_)
                                                      : read_mat_4(bytes, where_),
                          where_);
  const std::vector<MatColumn>& columns = content_.columns;
  if (columns.empty()) {
    const std::string& variables = content_.variables;
    throw Error(Code::file_empty, where_,
                variables.empty() ? "holds no variables" : "holds no vector or matrix of numbers: " + variables,
                remedy_for(content_.unread));
  }
  const bool all_count = std::ranges::all_of(content_.arrays, &TableArray::is_matrix);
  const std::size_t limit = all_count ? max_columns : max_mat_columns;
  if (columns.size() > limit)
    throw Error(Code::file_too_large, where_, "has " + std::to_string(columns.size()) + " columns",
                "give a file of at most " + std::to_string(limit));
  for (const MatColumn& column : columns)
    if (column.values.size() > max_rows)
      throw Error(Code::file_too_large, where_, column.path + " has more than 10 million values",
                  "cut it to one trial");
  name_columns();
}

void MatTable::name_columns() {
  std::map<std::string_view, int> uses;
  for (const MatColumn& column : content_.columns) ++uses[column.name];
  names_.clear();
  own_names_.clear();
  for (const MatColumn& column : content_.columns) {
    names_.push_back(uses[column.name] > 1 ? column.path : column.name);
    own_names_.push_back(column.name);
  }
  named_ = std::ranges::any_of(content_.columns, &MatColumn::is_named);
  rates_.clear();
  for (const MatRate& rate : content_.rates) rates_.push_back(rate.rate);
  for (const MatColumn& column : content_.columns)
    if (column.rate) rates_.push_back(*column.rate);
}

/// Keeps the columns and the rate that share most structures with the chosen column: they belong together.
bool MatTable::choose(int chosen) {
  const MatScope& scope = at(chosen).scope;
  std::map<std::string_view, std::pair<std::size_t, int>>
      nearest;  // shared levels, and the number of columns that have them
  for (const MatColumn& column : content_.columns) {
    const std::size_t shared = shared_levels(column.scope, scope);
    auto& [levels, count] = nearest[column.name];
    if (count == 0 || shared > levels) count = 0, levels = shared;
    if (shared == levels) ++count;
  }
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const MatColumn& column = content_.columns[i];
    const auto& [levels, count] = nearest[column.name];
    const bool is_nearest = shared_levels(column.scope, scope) == levels;
    own_names_[i] = is_nearest && (count == 1 || levels == column.scope.size()) ? column.name : std::string();
  }
  const auto beside = std::ranges::find(content_.columns, scope, &MatColumn::scope);
  first_ = static_cast<int>(beside - content_.columns.begin());
  if (at(chosen).rate) {
    rates_ = {*at(chosen).rate};
    return true;
  }
  // The rate of a structure around the column wins among rates that share equally many levels.
  const auto worth = [&](const MatRate& rate) {
    const std::size_t shared = shared_levels(rate.scope, scope);
    return 2 * shared + (shared == rate.scope.size() ? 1 : 0);
  };
  std::size_t best = 0;
  for (const MatRate& rate : content_.rates) best = std::max(best, worth(rate));
  rates_.clear();
  for (const MatRate& rate : content_.rates)
    if (worth(rate) == best) rates_.push_back(rate.rate);
  return true;
}

void MatTable::keep_element(const std::string& array, std::size_t element) {
  std::erase_if(content_.columns, [&](const MatColumn& column) {
    return std::ranges::any_of(column.elements,
                               [&](const auto& inside) { return inside.first == array && inside.second != element; });
  });
  for (TableArray& other : content_.arrays)
    if (other.name == array) other.elements = 1;
  name_columns();
}

void MatTable::keep_rows(int column, const std::vector<std::size_t>& rows) {
  const std::size_t all = at(column).values.size();
  for (MatColumn& kept : content_.columns) {
    if (kept.values.size() != all) continue;
    for (std::size_t i = 0; i < rows.size(); ++i) kept.values[i] = kept.values[rows[i]];
    kept.values.resize(rows.size());
  }
  number_kept_rows(rows);
}

std::vector<double> MatTable::numbers(int column, Missing missing) const {
  const std::vector<double>& values = at(column).values;
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::isfinite(values[k]) || (missing == Missing::kept && std::isnan(values[k]))) continue;
    throw Error(std::isnan(values[k]) ? Code::value_missing : Code::value_invalid, where_,
                locate(k) + ", " + names_[static_cast<std::size_t>(column)] + ": " +
                    (std::isnan(values[k]) ? "NaN" : "an infinite value") + " is not a finite number",
                recording::remedy_for_missing);
  }
  return values;
}

}  // namespace decid::recording
