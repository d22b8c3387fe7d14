// Progress of long work on standard error: a bar with rate and time left on a terminal, plain lines elsewhere.
#pragma once

#include <chrono>
#include <span>
#include <string>

namespace decid::tools {

/// A curve of one character a value, ▁ to █, from the least to the largest, on a logarithmic scale if all are positive;
/// of more than `most` values the last ones.
std::string curve(std::span<const double> values, std::size_t most = 24);

class ProgressBar {
 public:
  /// `what` names the work, `unit` what is counted ("trials"). What follows counts in parts, so many of which are one.
  ProgressBar(std::string what, std::string unit, long long total, bool quiet, int parts = 1);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// `done` are there already: rate and time left are counted from now.
  void go_on_from(long long done);
  /// Whether there is a bar.
  bool terminal() const { return terminal_; }
  /// note: how the work stands besides.
  void update(long long done, const std::string& note = {});
  /// A line of its own, kept on the screen.
  void line(const std::string& text);

 private:
  std::string figures(long long done) const;
  void clear();

  std::string what_, unit_;
  long long total_, before_ = 0;  // in parts
  int parts_;
  bool quiet_, terminal_;
  std::size_t shown_ = 0;
  std::chrono::steady_clock::time_point start_, next_;
};

}  // namespace decid::tools
