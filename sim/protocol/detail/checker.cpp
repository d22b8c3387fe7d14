// Bounds of a protocol's settings: see checker.hpp.
#include "sim/protocol/detail/checker.hpp"

#include <charconv>
#include <cmath>

#include "base/error.hpp"
#include "base/text.hpp"
#include "sim/protocol/experiment.hpp"

namespace decid::sim {

int milliseconds(double seconds) {
  return static_cast<int>(std::floor(seconds * steps_per_second + 0.5));
}

std::string setting_text(double value) {
  return format("%.10g", value);
}

std::string given_text(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

void Checker::fail(const std::string& setting, const std::string& problem, const std::string& remedy) const {
  throw Error(Code::setting_out_of_range, prefix_ + setting, problem, remedy);
}

void Checker::within(const std::string& setting, double value, double low, double high) const {
  if (value >= low && value <= high) return;
  fail(setting, "is " + given_text(value), "give a value from " + setting_text(low) + " to " + setting_text(high));
}

void Checker::positive(const std::string& setting, double value, double high) const {
  if (value > 0.0 && value <= high) return;
  fail(setting, "is " + given_text(value), "give a value above 0 and at most " + setting_text(high));
}

void Checker::whole_milliseconds(const std::string& setting, double seconds) const {
  const double steps = seconds * steps_per_second;
  if (std::abs(steps - std::floor(steps + 0.5)) <= 1e-6) return;
  fail(setting, "is " + given_text(seconds) + " s", "give a multiple of 0.001 s, the integration step");
}

void Checker::whole_samples(const std::string& setting, double seconds, double rate_hz) const {
  const double samples = seconds * rate_hz;
  if (std::abs(samples - std::floor(samples + 0.5)) <= 1e-6) return;
  fail(setting, "is " + given_text(seconds) + " s, not a whole number of samples",
       "give a multiple of " + setting_text(1.0 / rate_hz) + " s");
}

}  // namespace decid::sim
