// The library's error type: what is wrong, where, and how to fix it. The library throws it and never prints, exits or
// aborts. The program turns it into one line and exit code 2, or 1 if a disk failed.
#pragma once

#include <stdexcept>
#include <string>

namespace decid {

/// Causes of errors, for scripts: stable names, which docs/reference/errors.md lists with their remedies.
enum class Code {
  file_missing,
  file_unreadable,
  file_unwritable,
  file_damaged,
  file_unsupported,
  file_too_large,
  file_empty,
  file_in_use,
  file_exists,
  file_differs,
  setting_out_of_range,
  setting_unknown,
  setting_malformed,
  setting_missing,
  setting_conflict,
  column_missing,
  column_ambiguous,
  column_unsuitable,
  table_unclear,
  unit_unknown,
  rate_unknown,
  times_uneven,
  value_missing,
  value_invalid,
  recording_ambiguous,
  recording_too_short,
  protocol_mismatch,
  trials_missing,
  data_reused,
  body_falls,
  diverged,
  size_mismatch,
  not_supported,
  system_failed,
  out_of_memory,
  stopped,
  recordings_failed,
  internal,
};
/// Returns "file_missing" and so on.
const char* name(Code code);

/// Returns the code for a file that open() refuses with this errno.
Code opening_failed(int error);

/// Thrown for every bad input, file or setting. `what()` reads "where: problem; remedy".
class Error : public std::runtime_error {
 public:
  /// `where` names the file, setting or function; `problem` describes the fault, with its value; `remedy` tells the
  /// user how to fix it.
  Error(Code code, std::string where, std::string problem, std::string remedy);

  Code code() const noexcept { return code_; }
  const std::string& where() const noexcept { return where_; }
  const std::string& problem() const noexcept { return problem_; }
  const std::string& remedy() const noexcept { return remedy_; }

 private:
  Code code_;
  std::string where_;
  std::string problem_;
  std::string remedy_;
};

/// Thrown if the system cannot write a file although its path is valid: its disk is full or failed. The input is
/// correct.
class WriteError : public Error {
 public:
  WriteError(std::string where, std::string problem, std::string remedy);
};

}  // namespace decid
