// Signals that were sampled together, of a recording or of a trial: angles over time, each with its name.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.hpp"

namespace decid::recording {

/// Names: the sway of the body's centre of mass in space, and the platform's tilt.
inline constexpr const char* com_sway = "com_sway";
inline constexpr const char* platform_tilt = "tilt";

template <class Value>
struct Signal {
  std::string name;
  std::string column;      ///< that it was read from: "COM_x", or "column 2"
  std::vector<Value> rad;  ///< its samples
  template <class Archive>
  void archive(Archive& a) {
    a(name, column, rad);
  }
};

/// Some few signals of one length, found by their names.
template <class Value>
class Signals {
 public:
  /// Adds a signal; it takes the place of one with its name.
  Signal<Value>& add(Signal<Value> signal) {
    if (Signal<Value>* found = find(signal.name)) return *found = std::move(signal);
    return all_.emplace_back(std::move(signal));
  }
  /// Does nothing if there is none.
  void remove(std::string_view name) {
    std::erase_if(all_, [&](const Signal<Value>& signal) { return signal.name == name; });
  }
  /// Null if there is none.
  const Signal<Value>* find(std::string_view name) const {
    for (const Signal<Value>& signal : all_)
      if (signal.name == name) return &signal;
    return nullptr;
  }
  Signal<Value>* find(std::string_view name) { return const_cast<Signal<Value>*>(std::as_const(*this).find(name)); }
  /// Throws Error if there is none.
  const Signal<Value>& at(std::string_view name) const {
    if (const Signal<Value>* found = find(name)) return *found;
    throw Error("signals", "there is no " + std::string(name), "record it too, or use what needs others");
  }
  Signal<Value>& at(std::string_view name) { return const_cast<Signal<Value>&>(std::as_const(*this).at(name)); }

  /// Of each; 0 if there is none.
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
