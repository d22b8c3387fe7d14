// A study's sheet: a table with a line per recording, or per person for all of that person's recordings. Column names:
// BIDS 1.9, participants.tsv and scans.tsv. recording_plan.hpp finds the recordings of its lines.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"

namespace decid {

/// The cells of a line that go with a recording to its results.
struct SheetEntry {
  std::string participant, session, group, condition;
  std::vector<std::string> cells = {};  ///< of the sheet's other columns, in their order; empty: n/a
  bool operator==(const SheetEntry&) const = default;
};

struct SheetLine {
  std::size_t number = 0;  ///< in the file, from 1
  std::string file;        ///< empty: the line is of all recordings of the participant, in the session if it has one
  SheetEntry entry;
  std::optional<double> mass_kg, height_m;
  std::string protocol;                                      ///< empty: the call's
  std::vector<std::pair<std::string, std::string>> reading;  ///< options of reading by name, and their values
  std::optional<Error> error = {};   ///< what is wrong with the line; its recordings have this error
  std::optional<Error> misfit = {};  ///< too many cells, or neither a participant nor a file; whatever the cells hold
  std::size_t cells = 0;             ///< of the line, which may be shorter than the names
};

struct StudySheet {
  std::filesystem::path file;
  std::vector<std::string> columns;  ///< of SheetEntry::cells, as the file spells them
  std::vector<SheetLine> lines;
  std::vector<std::string> names = {};  ///< of all columns, as the file spells them
  std::string participant_column = {};  ///< as the file spells it; empty: none
  std::string group_column = {};        ///< as the file spells it; empty: none
  std::vector<std::string> notes = {};  ///< on columns that are carried along and look like settings, for people

  /// Returns "participants.tsv, line 3".
  std::string locate(const SheetLine& line) const;
  /// Returns the function that reads a column of entries, by any spelling of its name; "" is n/a. Throws Error for a
  /// column that the sheet or its entries do not have.
  std::function<std::string(const SheetEntry& entry)> reader_for(const std::string& column) const;
};

/// Reads a sheet: text between tabs, commas or semicolons (RFC 4180), or the first sheet of a workbook (.xlsx). Letter
/// case, blanks, underscores and punctuation of column names do not count:
/// - participant_id (or participant, subject, person, patient, proband, with or without id, or id; without these a
/// number such as "Subject No" or "VP-Nr", then a name such as "patient name", then "code"; the first of several),
/// session, group, condition; "1.0" is the session, group or condition "1", "1,000" stays, and a hyphen or a point
/// alone is no person, session or group;
/// - file (or filename, path, recording): a path from the sheet's folder, or the end of one;
/// - mass or weight in kg; height in m, or in cm from 30 up; other units by the name (weight_lb, height_in) or, of
/// BIDS' sheets, by the sidecar (sidecar.hpp), or by all cells (154 lb): one without a unit beside these is an error;
/// - protocol: a name or a file; and options of reading (set_reading_option()).
/// Other columns, age and sex among them, are SheetEntry::cells. Empty cells and n/a have no value. Throws Error for an
/// unreadable file, a recording, a sheet without participant_id and file, two columns of one meaning, a weight or
/// height in a unit that is not read, and a sheet without lines. A line with a wrong cell has an error.
StudySheet read_sheet(const std::filesystem::path& path);
/// Returns true for a readable table of up to 1000 lines without a time, whose columns name participants or files, and
/// at least one other thing that decid reads.
bool looks_like_sheet(const std::filesystem::path& path);

/// Returns true for "group".
bool names_groups(const std::string& column);
/// Returns true for the names of a column of weights: weight, mass and the like.
bool names_weights(const std::string& column);
/// Returns true for the names of a column of heights.
bool names_heights(const std::string& column);
/// Returns true for the names of a column of ages in years.
bool names_ages(const std::string& column);
/// Returns true for the names of a column of body mass indices in kg/m2: bmi, body mass index, IMC.
bool names_body_mass_indices(const std::string& column);
/// Returns true for a cell without a value: empty, n/a, NA, NaN and #N/A.
bool has_no_value(const std::string& cell);
/// Reads the number of a cell, with a decimal point or comma; nothing for another text.
std::optional<double> read_number(std::string cell);

/// Returns the line with the empty cells of a recording's line filled from the person's.
SheetLine merged(SheetLine recording, const SheetLine& participant);

}  // namespace decid
