// MATLAB's MAT-files as tables: versions 4, 5, 7 (mat_5.hpp) and 7.3 (mat_73.hpp).
// Not installed.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "dataset/recording/table.hpp"

namespace decid::dataset {

/// Columns are the real numeric variables with two values or more, also those that are fields of a struct (to four
/// levels): a vector is one column of its name, a matrix one a column ("data(:,2)"), or one a row if it is wider than
/// high ("data(2,:)"). A field is called by its own name ("COM_x"), or with its struct's ("trial.COM_x") where that is
/// not unique. A scalar called fs, rate, sample_rate or the like is the sample rate in Hz. Text, cells, sparse and
/// complex arrays, and MATLAB's own objects (table, timetable) are passed over.
class MatTable final : public Table {
 public:
  /// bytes: of the file at `path`. Throws Error if it is no MAT-file, is damaged or holds no column, naming what it
  /// holds instead.
  MatTable(std::string_view bytes, const std::filesystem::path& path);

  std::size_t rows(int column) const override { return values_[static_cast<std::size_t>(column)].size(); }
  bool has_header() const override { return named_; }
  const std::vector<std::string>& names() const override { return names_; }
  std::vector<double> numbers(int column, Missing missing) const override;
  std::string place_of(std::size_t row) const override { return "row " + std::to_string(row + 1); }
  const std::vector<StatedRate>& stated_rates() const override { return rates_; }

 private:
  std::string where_;
  bool named_ = false;  ///< some column is a vector, with a name of its own
  std::vector<std::string> names_;
  std::vector<std::vector<double>> values_;
  std::vector<StatedRate> rates_;
};

}  // namespace decid::dataset
