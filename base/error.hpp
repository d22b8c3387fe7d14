// The library's error type: what is wrong, where, and how to fix it. The library throws it and never prints, exits or
// aborts. The program turns it into one line and exit code 2, or 1 if a disk failed.
#pragma once

#include <stdexcept>
#include <string>

namespace decid {

/// Thrown for every bad input, file or setting. `what()` reads "where: problem; remedy".
class Error : public std::runtime_error {
 public:
  /// `where` names the file, setting or function; `problem` describes the fault, with its value; `remedy` tells the
  /// user how to fix it.
  Error(std::string where, std::string problem, std::string remedy);

  const std::string& where() const noexcept { return where_; }
  const std::string& problem() const noexcept { return problem_; }
  const std::string& remedy() const noexcept { return remedy_; }

 private:
  std::string where_;
  std::string problem_;
  std::string remedy_;
};

/// Thrown if the system cannot write a file although its path is valid: its disk is full or failed. The input is
/// correct.
class WriteError : public Error {
 public:
  using Error::Error;
};

}  // namespace decid
