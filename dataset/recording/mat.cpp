// MAT-files: see mat.hpp. What their variables are called as columns.
#include "dataset/recording/mat.hpp"

#include <cmath>
#include <map>
#include <optional>

#include "base/error.hpp"
#include "dataset/recording/columns.hpp"
#include "dataset/recording/mat_5.hpp"
#include "dataset/recording/mat_73.hpp"

namespace decid::dataset {

namespace {

const char* text_of(MatVariable::Kind kind) {
  using Kind = MatVariable::Kind;
  switch (kind) {
    case Kind::numbers:
      return "numbers";
    case Kind::complex:
      return "complex";
    case Kind::text:
      return "text";
    case Kind::cell:
      return "cell";
    case Kind::structure:
      return "struct";
    case Kind::sparse:
      return "sparse";
    case Kind::function:
      return "function";
    case Kind::object:
      break;
  }
  return "object";
}

bool is_rate(const std::string& name) {
  const std::string plain = name_without_unit(name);
  return one_of(plain,
                {"fs", "sr", "rate", "rate_hz", "fs_hz", "sample_rate", "samplerate", "sample_rate_hz", "samplingrate",
                 "sampling_rate", "sampling_rate_hz", "sf", "freq", "frequency", "sample_frequency"});
}

/// What a file holds, before its columns are named.
struct Columns {
  std::vector<std::string> leaf, path;
  std::vector<std::vector<double>> values;
  bool named = false;
  std::vector<StatedRate> rates;
  std::string held;  ///< all variables, for an Error
};

void collect(MatVariable&& variable, const std::string& outer, Columns& columns) {
  if (!variable.is_matrix) return;
  const std::string& name = variable.name;
  const std::string path = outer.empty() ? name : outer + "." + name;
  const std::size_t height = variable.height, width = variable.width;
  if (columns.held.size() < 200) {
    columns.held += (columns.held.empty() ? "" : ", ") + path + " (" + std::to_string(height) + " x " +
                    std::to_string(width) + " " + text_of(variable.kind) + ")";
  }
  for (MatVariable& field : variable.fields) collect(std::move(field), path, columns);
  std::vector<double>& all = variable.values;
  if (all.empty()) return;
  if (all.size() == 1) {
    if (is_rate(name) && std::isfinite(all[0]) && all[0] > 0.0)
      columns.rates.push_back({all[0], path, !one_of(name_without_unit(name), {"rate", "freq", "frequency"})});
    if (one_of(name_without_unit(name), {"ts", "dt", "sampling_interval", "sample_interval", "sample_time"}) &&
        is_sample_rate(1.0 / all[0]))
      columns.rates.push_back({near_whole(1.0 / all[0]), path, true});
    return;
  }
  if (height == 1 || width == 1) {
    columns.leaf.push_back(name);
    columns.path.push_back(path);
    columns.values.push_back(std::move(all));
    columns.named = true;
    return;
  }
  const bool wide = width > height;
  const std::size_t signals = wide ? height : width, samples = wide ? width : height;
  for (std::size_t s = 0; s < signals && columns.values.size() <= most_columns; ++s) {
    const std::string index = wide ? "(" + std::to_string(s + 1) + ",:)" : "(:," + std::to_string(s + 1) + ")";
    columns.leaf.push_back(name + index);
    columns.path.push_back(path + index);
    columns.values.emplace_back(samples);
    for (std::size_t k = 0; k < samples; ++k) columns.values.back()[k] = all[wide ? k * height + s : s * height + k];
  }
}

}  // namespace

MatTable::MatTable(std::string_view bytes, const std::filesystem::path& path) : where_(path.string()) {
  const char* remedy = "save it in MATLAB with save('file.mat', 'time', 'sway'), or as CSV";
  const MatVersion version = mat_version(bytes);
  if (version == MatVersion::none) throw Error(where_, "is not a MAT-file that can be read, or is damaged", remedy);
  Columns columns;
  for (MatVariable& variable : version == MatVersion::v73  ? read_mat_73(path, bytes.size())
                               : version == MatVersion::v5 ? read_mat_5(bytes, where_)
                                                           : read_mat_4(bytes, where_))
    collect(std::move(variable), "", columns);
  if (columns.values.empty()) {
    throw Error(where_,
                columns.held.empty() ? "holds no variables" : "holds no vector or matrix of numbers: " + columns.held,
                remedy);
  }
  if (columns.values.size() > most_columns) {
    throw Error(where_, "has " + std::to_string(columns.values.size()) + " columns", "at most 1000 can be read");
  }
  std::map<std::string, int> uses;
  for (const std::string& leaf : columns.leaf) ++uses[leaf];
  for (std::size_t i = 0; i < columns.leaf.size(); ++i) {
    if (columns.values[i].size() > most_rows) {
      throw Error(where_, columns.path[i] + " has more than 10 million values", "cut it to the trial to be identified");
    }
    names_.push_back(uses[columns.leaf[i]] > 1 ? columns.path[i] : columns.leaf[i]);
  }
  values_ = std::move(columns.values);
  named_ = columns.named;
  rates_ = std::move(columns.rates);
}

std::vector<double> MatTable::numbers(int column, Missing missing) const {
  const std::vector<double>& values = values_[static_cast<std::size_t>(column)];
  for (std::size_t k = 0; k < values.size(); ++k) {
    if (std::isfinite(values[k]) || (missing == Missing::kept && std::isnan(values[k]))) continue;
    throw Error(where_,
                place_of(k) + ", " + names_[static_cast<std::size_t>(column)] + ": " +
                    (std::isnan(values[k]) ? "NaN" : "an infinite value") + " is not a finite number",
                remedy_for(std::isnan(values[k]) ? missing : Missing::refused));
  }
  return values;
}

}  // namespace decid::dataset
