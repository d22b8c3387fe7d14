// Signals of a recording or trial that were sampled together: angles over time, each with its name.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.hpp"

namespace decid::recording {

/// Names of signals: the sway of the body's centre of mass in space, and the platform's tilt.
inline constexpr const char* com_sway = "com_sway";
inline constexpr const char* platform_tilt = "tilt";

template <class Value>
struct Signal {
  std::string name;
  std::string column;      ///< the column it comes from: "COM_x", or "column 2"
  std::vector<Value> rad;  ///< samples
  template <class Archive>
  void archive(Archive& a) {
    a(name, column, rad);
  }
};

/// A few signals of equal length, found by name.
template <class Value>
class Signals {
 public:
  /// Adds a signal; replaces a signal of the same name.
  Signal<Value>& add(Signal<Value> signal) {
    if (Signal<Value>* found = find(signal.name)) return *found = std::move(signal);
    return all_.emplace_back(std::move(signal));
  }
  /// Removes a signal, if present.
  void remove(std::string_view name) {
    std::erase_if(all_, [&](const Signal<Value>& signal) { return signal.name == name; });
  }
  /// Returns null if there is no such signal.
  const Signal<Value>* find(std::string_view name) const {
    for (const Signal<Value>& signal : all_)
      if (signal.name == name) return &signal;
    return nullptr;
  }
  Signal<Value>* find(std::string_view name) { return const_cast<Signal<Value>*>(std::as_const(*this).find(name)); }
  /// Throws Error if there is no such signal.
  const Signal<Value>& at(std::string_view name) const {
    if (const Signal<Value>* found = find(name)) return *found;
    throw Error(Code::column_missing, "signals", std::string(name) + " is missing", "record it too");
  }
  Signal<Value>& at(std::string_view name) { return const_cast<Signal<Value>&>(std::as_const(*this).at(name)); }

  /// Returns the samples of each signal; 0 without signals.
  std::size_t samples() const noexcept { return all_.empty() ? 0 : all_.front().rad.size(); }
  auto begin() const noexcept { return all_.begin(); }
  auto end() const noexcept { return all_.end(); }
  template <class Archive>
  void archive(Archive& a) {
    a(all_);
  }

 private:
  std::vector<Signal<Value>> all_;
};

}  // namespace decid::recording
