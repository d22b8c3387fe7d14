// Columns of a MAT-file: its variables, named as MATLAB would and as programs that export recordings mean them.
// Not installed.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "recording/formats/mat/mat_variable.hpp"
#include "recording/stated_rate.hpp"
#include "recording/table/table.hpp"

namespace decid::recording {

/// Names of the structures, arrays and elements around something, outermost first: trials, (2), signals.
using MatScope = std::vector<std::string>;

struct MatColumn {
  std::string name;  ///< "com_sway_deg", "data(:,2)", or the label that the file has for it
  std::string path;  ///< "trials(2).com_sway_deg"
  MatScope scope;
  std::vector<std::pair<std::string, std::size_t>> elements;  ///< path of each array around it, and which element
  bool is_named = false;                                      ///< a vector, or labelled; else a matrix's column
  std::vector<double> values;
  std::optional<StatedRate> rate;  ///< its own, where the file has one for each channel
};

struct MatRate {
  StatedRate rate;
  MatScope scope;
};

struct MatColumns {
  std::vector<MatColumn> columns;
  std::vector<TableArray> arrays;  ///< whose elements may be recordings
  std::vector<MatRate> rates;
  std::string held, unread;  ///< all variables, and those that are no columns by their kind, for an Error
};

/// Makes columns of variables. A vector is one, a matrix one for each of its columns, or rows if it is wider than high;
/// a matrix of samples x channels x trials one for each channel and trial. What programs export has their names:
/// LabChart (data, datastart, dataend, titles), AcqKnowledge (data, labels, units, isi), Qualisys (Labels and Data),
/// Simulink (time, signals.values, signals.label), and a matrix with a list of names beside it. Throws Error for a
/// LabChart file whose parts do not fit together; `where` names the file.
MatColumns columns_of(std::vector<MatVariable> variables, const std::string& where);

/// How many levels of two scopes are the same, from the outermost on.
std::size_t shared_levels(const MatScope& a, const MatScope& b);

}  // namespace decid::recording
