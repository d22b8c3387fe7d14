// JSON objects read key by key, so that every defect of a file is an Error that names the file and the key.
// Not installed. The only header of base that shows nlohmann's library.
// Format: RFC 8259.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/files/json.hpp"

/// The library's own moves all that is within a value onto a list first, against a stack that overflows where values
/// are nested deeply. That list takes memory, and a destructor that finds none ends the process. Json is never nested
/// deeply, so that its children's destructors do.
template <>
inline void decid::Json::json_value::destroy(nlohmann::detail::value_t type) {
  const auto remove = [](auto* value) {
    std::destroy_at(value);
    std::allocator<std::remove_pointer_t<decltype(value)>>().deallocate(value, 1);
  };
  using Type = nlohmann::detail::value_t;
  if (type == Type::object) remove(object);
  if (type == Type::array) remove(array);
  if (type == Type::string) remove(string);
  if (type == Type::binary) remove(binary);
}

namespace decid {

/// Lists and objects within each other: no file of decid's has more than 6, and the library prints them recursively.
inline constexpr int deepest_json = 32;

/// What others wrote is read by this alone, not by Json::parse. Throws Error with line and column if `text` is not JSON
/// or nested deeper than deepest_json, and for a key that stands twice in one object (the last would win silently).
/// `where` names the source.
Json parse_json(std::string_view text, const std::string& where);

/// Two spaces of indentation; doubles read back to the same bits; text that is not UTF-8 is replaced, not refused.
std::string print_json(const Json& json);

/// One object of a JSON file. Each read() takes the value of a key if the key is there and leaves `value` alone if
/// not; finish() takes every key that was not asked for as unknown.
class JsonObject {
 public:
  /// `path` is where in the file the object is ("sequence"), empty for the outermost. Throws Error if `json` is not
  /// an object. `json` must outlive this.
  JsonObject(const Json& json, std::string where, std::string path = {});

  /// The value of `key`, or null if it was left out.
  const Json* find(const char* key);
  /// The value of `key`; throws Error if it was left out.
  const Json& require(const char* key);

  void read(const char* key, double& value);
  void read(const char* key, int& value);
  void read(const char* key, std::uint64_t& value);
  void read(const char* key, bool& value);
  void read(const char* key, std::string& value);
  void read(const char* key, std::vector<int>& value);
  void read(const char* key, std::vector<double>& value);
  void read(const char* key, std::vector<std::string>& value);

  /// Throws Error naming the first key that was not asked for.
  void finish() const;

  /// Throws Error: `key` should have been `expected` ("a number").
  [[noreturn]] void wrong_type(const char* key, const std::string& expected) const;

 private:
  std::string name_of(std::string_view key) const;

  const Json& json_;
  std::string where_, path_;
  std::vector<std::string> known_;
};

}  // namespace decid
