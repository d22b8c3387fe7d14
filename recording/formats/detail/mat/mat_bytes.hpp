// The bytes of MAT-files of versions 4 to 7: numbers of either byte order. Reads never pass the end.
// Not installed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace decid::recording {

inline constexpr std::size_t max_name_bytes = 1024;  // MATLAB's names have at most 63 characters

[[noreturn]] inline void refuse_damaged(const std::string& where, const std::string& what) {
  throw Error(Code::file_damaged, where, "is cut short or damaged" + what, "copy or save it again");
}

/// Reads numbers of either byte order.
class MatBytes {
 public:
  MatBytes(std::string_view bytes, bool swapped, const std::string& where)
      : bytes_(bytes), swapped_(swapped), where_(where) {}

  std::size_t left() const { return bytes_.size(); }
  bool swapped() const { return swapped_; }

  std::string_view take(std::size_t count) {
    if (count > bytes_.size()) refuse_damaged(where_, "");
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }
  void pass_at_most(std::size_t count) { bytes_.remove_prefix(std::min(count, bytes_.size())); }

  template <class T>
  T number() {
    return number_at<T>(take(sizeof(T)).data());
  }

  /// Reads `count` numbers of type T.
  template <class T>
  std::vector<double> numbers(std::size_t count) {
    if (count > left() / sizeof(T)) refuse_damaged(where_, "");
    const char* from = take(count * sizeof(T)).data();
    std::vector<double> values(count);
    for (double& value : values) {
      value = static_cast<double>(number_at<T>(from));
      from += sizeof(T);
    }
    return values;
  }

 private:
  template <class T>
  T number_at(const char* from) const {
    T value;
    char raw[sizeof(T)];
    std::memcpy(raw, from, sizeof(T));
    if (swapped_) std::reverse(raw, raw + sizeof(T));
    std::memcpy(&value, raw, sizeof(T));
    return value;
  }

  std::string_view bytes_;
  bool swapped_;
  const std::string& where_;
};

}  // namespace decid::recording
