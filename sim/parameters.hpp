// Parameters of a model of body and controller. A table defines their number, names, units and ranges; a set of values
// has the table's order. Models are in body_model.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace decid::sim {

/// One set of parameters in SI units: all of its model's, in the order of the model's table.
class Parameters {
 public:
  static constexpr std::size_t max_parameters = 32;  ///< stored in place, because simulations copy them

  constexpr Parameters() = default;
  /// At most `max_parameters` values.
  constexpr explicit Parameters(std::size_t size) : size_(size) { assert(size <= max_parameters); }
  constexpr Parameters(std::initializer_list<double> values) : size_(values.size()) {
    assert(size_ <= max_parameters);
    std::copy(values.begin(), values.end(), values_.begin());
  }

  constexpr std::size_t size() const noexcept { return size_; }
  constexpr double& operator[](std::size_t i) noexcept {
    assert(i < size_);
    return values_[i];
  }
  constexpr double operator[](std::size_t i) const noexcept {
    assert(i < size_);
    return values_[i];
  }
  constexpr double* begin() noexcept { return values_.data(); }
  constexpr double* end() noexcept { return values_.data() + size_; }
  constexpr const double* begin() const noexcept { return values_.data(); }
  constexpr const double* end() const noexcept { return values_.data() + size_; }

  template <class Archive>
  void archive(Archive& a) {
    size_ = std::min(a.count(size_), max_parameters);
    for (double& value : *this) a(value);
  }

  friend constexpr bool operator==(const Parameters& a, const Parameters& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

 private:
  std::array<double, max_parameters> values_{};
  std::size_t size_ = 0;
};
static_assert(std::is_trivially_copyable_v<Parameters>);

struct ParameterInfo {
  std::string name;         ///< as in files: "Kp_pass"
  std::string option;       ///< as on the command line: "kp-pass"
  std::string description;  ///< for users: "Passive stiffness"
  std::string unit;         ///< "1": a plain number
  double low, high;         ///< range of the uniform distribution of the data set
  bool scales_with_mgh;     ///< value / (m g h) is meaningful
  /// The values that can be simulated.
  double min = 0.0, max = std::numeric_limits<double>::infinity();
  /// The value at which a fit fixes the parameter if no prior is given for it: only its products with others act on the
  /// sway, and this is the convention of the model's authors.
  std::optional<double> convention{};

  double middle() const { return 0.5 * (low + high); }
  double range() const { return high - low; }
  /// Returns true outside of the range by more than a twentieth of it; estimates scatter that far.
  bool is_beyond(double value) const {
    const double margin = 0.05 * range();
    return !(value >= low - margin && value <= high + margin);  // true for NaN
  }
  /// Returns the unit for users; empty for a plain number.
  std::string shown_unit() const { return unit == "1" ? "" : unit; }
  /// Returns " N m/rad", to follow a number; empty for a plain number.
  std::string unit_after() const { return unit == "1" ? "" : " " + unit; }
  /// Returns " (delay is in s: 20 ms is 0.02)" for units that users take for milliseconds or degrees per second; empty
  /// for others.
  std::string unit_hint() const {
    if (unit == "s") return " (" + name + " is in s: 20 ms is 0.02)";
    return unit == "rad/s" ? " (" + name + " is in rad/s: 1 deg/s is 0.01745)" : "";
  }
};

class ParameterTable {
 public:
  /// Throws Error for no parameters or more than Parameters::max_parameters, for a repeated name, and for a range that
  /// is empty or cannot be simulated.
  explicit ParameterTable(std::vector<ParameterInfo> parameters);

  std::size_t size() const noexcept { return all_.size(); }
  const ParameterInfo& operator[](std::size_t i) const noexcept { return all_[i]; }
  auto begin() const noexcept { return all_.begin(); }
  auto end() const noexcept { return all_.end(); }
  std::vector<std::string> names() const;

  /// Returns the middle of every range.
  Parameters middle() const;
  /// Returns the nearest values that can be simulated.
  Parameters simulable(Parameters values) const;
  /// Returns each value's position in its range, 0 .. 1; values outside of their ranges lie outside of 0 .. 1.
  std::vector<double> to_unit(const Parameters& values) const;
  Parameters from_unit(std::span<const double> unit) const;

  /// Reads "Kp=900,Kd=250,...": all parameters, by name ("Kp_pass") or option name ("kp-pass"), in any order. Throws
  /// Error; `where` names the text.
  Parameters from_text(const std::string& text, const std::string& where) const;

 private:
  std::vector<ParameterInfo> all_;
};

/// Returns the values with each parameter that has a convention at its convention.
Parameters with_conventions(Parameters values, const ParameterTable& table);

}  // namespace decid::sim
