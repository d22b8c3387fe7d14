// MATLAB's MAT-files as tables: versions 4, 5, 7 (mat_5.hpp) and 7.3 (mat_73.hpp).
// Not installed.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "recording/formats/detail/mat/mat_columns.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Columns are the real numeric variables with two values or more, including those within structures, arrays of
/// structures and cell arrays (to eight levels): mat_columns.hpp. A column has its own name ("COM_x"), or its path
/// ("trial.COM_x", "trials(2).COM_x", "data{1}(:,2)") where its own name is not unique. A scalar called fs, rate,
/// sample_rate or similar is the sample rate in Hz. Sparse and complex arrays and MATLAB's own objects (table,
/// timetable, timeseries) are skipped.
class MatTable final : public Table {
 public:
  /// Reads `bytes` of the file at `path`. Throws Error if they are not a MAT-file, are damaged or hold no column; the
  /// error names the content.
  MatTable(std::string_view bytes, const std::filesystem::path& path);

  std::size_t rows(int column) const override { return at(column).values.size(); }
  bool has_header() const override { return named_; }
  const std::vector<std::string>& names() const override { return names_; }
  const std::string& own_name(int column) const override { return own_names_[static_cast<std::size_t>(column)]; }
  const std::string& path(int column) const override { return at(column).path; }
  std::vector<double> numbers(int column, Missing missing) const override;
  std::string locate(std::size_t row) const override { return "row " + std::to_string(row_of_file(row) + 1); }
  const std::vector<StatedRate>& stated_rates() const override { return rates_; }
  std::string unread() const override { return content_.unread; }
  bool choose(int column) override;
  int first_column() const override { return first_; }
  const std::vector<TableArray>& arrays() const override { return content_.arrays; }
  void keep_element(const std::string& array, std::size_t element) override;
  void keep_rows(int column, const std::vector<std::size_t>& rows) override;

 private:
  const MatColumn& at(int column) const { return content_.columns[static_cast<std::size_t>(column)]; }
  void name_columns();

  std::string where_;
  bool named_ = false;  ///< a column is a vector or labelled, with its own name
  MatColumns content_;
  std::vector<std::string> names_, own_names_;
  std::vector<StatedRate> rates_;
  int first_ = 0;
};

}  // namespace decid::recording
