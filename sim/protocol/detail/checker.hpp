// Bounds of a protocol's settings. Not installed. Every failure is an Error that names the protocol and the setting as
// its file does.
#pragma once

#include <string>

namespace decid::sim {

struct Experiment;

/// Formats computed values with ten significant digits: "0.25", "121.0000001".
std::string setting_text(double value);
/// Formats given values with all digits needed to restore them: "1.00000000001".
std::string given_text(double value);

/// Returns the whole milliseconds nearest to a time.
int milliseconds(double seconds);

class Checker {
 public:
  explicit Checker(const std::string& protocol) : prefix_("protocol " + protocol + ", ") {}

  [[noreturn]] void fail(const std::string& setting, const std::string& problem, const std::string& remedy) const;
  // NaN fails each of these.
  void within(const std::string& setting, double value, double low, double high) const;
  void positive(const std::string& setting, double value, double high) const;
  void whole_milliseconds(const std::string& setting, double seconds) const;
  void whole_samples(const std::string& setting, double seconds, double rate_hz) const;

 private:
  std::string prefix_;
};

/// Checks only the stimulus; the sample rate must be valid. Lengths must be within a trial's bound, so that all of them
/// fit int.
void check_stimulus(const Checker& check, const Experiment& experiment);

inline constexpr double longest_trial_s = 3600.0;

}  // namespace decid::sim
