// Columns of a MAT-file: its variables, named as MATLAB names them and as exporting programs define them.
// Not installed.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "recording/detail/stated_rate.hpp"
#include "recording/formats/detail/mat/mat_variable.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Names of the structures, arrays and elements around a variable, outermost first: trials, (2), signals.
using MatScope = std::vector<std::string>;

struct MatColumn {
  std::string name;  ///< "com_sway_deg", "data(:,2)", or the file's label for it
  std::string path;  ///< "trials(2).com_sway_deg"
  MatScope scope;
  std::vector<std::pair<std::string, std::size_t>>
      elements;           ///< path of each array around it, and the element's number
  bool is_named = false;  ///< a vector, or labelled; else a column of a matrix
  std::vector<double> values;
  std::optional<StatedRate> rate;  ///< the channel's own rate, where the file has one per channel
};

struct MatRate {
  StatedRate rate;
  MatScope scope;
};

struct MatColumns {
  std::vector<MatColumn> columns;
  std::vector<TableArray> arrays;  ///< arrays whose elements may be recordings
  std::vector<MatRate> rates;
  std::string variables, unread;  ///< all variables, and variables whose kind cannot be a column; for an Error
};

/// Returns the columns that variables hold. A vector is one column. A matrix has a column per matrix column, or per row
/// if it is wider than high. A matrix of samples x channels x trials has a column per channel and trial. Exports of
/// programs keep their names: LabChart (data, datastart, dataend, titles), AcqKnowledge (data, labels, units, isi),
/// Qualisys (Labels and Data), Simulink (time, signals.values, signals.label), and a matrix next to a list of names.
/// Throws Error for a LabChart file whose parts do not fit together; `where` names the file.
MatColumns make_columns(std::vector<MatVariable> variables, const std::string& where);

/// Returns the number of equal levels of two scopes, counted from the outermost.
std::size_t shared_levels(const MatScope& a, const MatScope& b);

}  // namespace decid::recording
