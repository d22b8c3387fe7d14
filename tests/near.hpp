// Numbers compared in tests: near() allows an error relative to the expected value, within() an absolute one. A failed
// CHECK(near(value, expected, 1e-12)) prints all three. (doctest's Approx adds 1 to its scale, so that for values far
// below 1 it passes whatever they are.)
#pragma once

#include <cmath>
#include <ostream>
#include <sstream>

namespace decid::test {

struct Closeness {
  double value, expected, tolerance;  ///< Tolerance: the largest |value - expected| that passes.

  /// False where a number is not finite, the tolerance's included.
  explicit operator bool() const { return std::isfinite(tolerance) && std::abs(value - expected) <= tolerance; }

  friend std::ostream& operator<<(std::ostream& stream, const Closeness& close) {
    std::ostringstream text;  // The caller's stream keeps its digits.
    text.precision(17);
    text << close.value << ", expected " << close.expected << " +- ";
    text.precision(3);
    text << close.tolerance << ", differs by " << std::abs(close.value - close.expected);
    return stream << text.str();
  }
};

/// |value - expected| <= relative * |expected|: an expected 0 demands 0.
inline Closeness near(double value, double expected, double relative) {
  return {value, expected, relative * std::abs(expected)};
}

/// |value - expected| <= absolute.
inline Closeness within(double value, double expected, double absolute) {
  return {value, expected, absolute};
}

}  // namespace decid::test
