// Progress of long work on standard error: a bar with rate and time left on a terminal, plain lines elsewhere.
#pragma once

#include <chrono>
#include <span>
#include <string>

namespace decid::tools {

/// Returns a curve with one character per value, ▁ to █, from the smallest to the largest value. The scale is
/// logarithmic if all values are positive. Shows only the last `max_length` values.
std::string curve(std::span<const double> values, std::size_t max_length = 24);

class ProgressBar {
 public:
  /// Starts a bar. `what` names the work, `unit` the counted items ("trials"; "%": shows only a percentage). The other
  /// functions count in parts; `parts` of them make one item.
  ProgressBar(std::string what, std::string unit, long long total, bool quiet, int parts = 1);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// Continues from `done` finished parts: rate and time left count from now.
  void go_on_from(long long done);
  /// Returns true if the progress is a bar on a terminal.
  bool terminal() const { return terminal_; }
  /// Updates the progress. note: text about the state of the work, shown after the figures.
  void update(long long done, const std::string& note = {});
  /// Prints a line that stays on the screen.
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
