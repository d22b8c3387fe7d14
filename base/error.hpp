// The one error type of the library: what went wrong, where, and what to do about it.
// The library throws it and never prints, exits or aborts; the program turns it into one line and exit code 2, or 1
// where a disk failed.
#pragma once

#include <stdexcept>
#include <string>

namespace decid {

/// Thrown for every bad input, file or setting. `what()` reads "where: problem; remedy".
class Error : public std::runtime_error {
 public:
  /// `where` names the file, setting or function; `problem` says what is wrong with it, figures included;
  /// `remedy` says what to do.
  Error(std::string where, std::string problem, std::string remedy);

  const std::string& where() const noexcept { return where_; }
  const std::string& problem() const noexcept { return problem_; }
  const std::string& remedy() const noexcept { return remedy_; }

 private:
  std::string where_;
  std::string problem_;
  std::string remedy_;
};

/// Thrown where the system does not write a file whose place was right: its disk is full, or it failed. No input is
/// wrong.
class WriteError : public Error {
 public:
  using Error::Error;
};

}  // namespace decid
