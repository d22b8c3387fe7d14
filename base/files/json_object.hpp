// JSON objects read key by key, so that every defect of a file is an Error that names the file and the key. Not
// installed. The only header of base that includes nlohmann's library. Format: RFC 8259.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/files/json.hpp"

/// The library's own destructor first moves all nested values onto a list, because deep nesting would overflow the
/// stack. The list needs memory, and a destructor without memory ends the process. Json is never nested deeply, so its
/// children's destructors suffice. A null that became an object or a list without memory for it has no value.
template <>
inline void decid::Json::json_value::destroy(nlohmann::detail::value_t type) {
  const auto remove = [](auto* value) {
    if (value == nullptr) return;
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

/// The maximum depth of lists and objects: decid's files have at most 6, and the library prints them recursively.
inline constexpr int deepest_json = 32;

/// Parses JSON from other programs; use it instead of Json::parse. Throws Error with line and column if `text` is not
/// JSON or nested deeper than deepest_json, and for a repeated key in one object (the last would win silently). `where`
/// names the source.
Json parse_json(std::string_view text, const std::string& where);

/// Prints with two spaces of indentation. Doubles restore the same bits; text that is not UTF-8 is replaced, not
/// refused.
std::string print_json(const Json& json);

/// One object of a JSON file. Each read() sets `value` if the key exists, and otherwise leaves it; finish() treats
/// every key that was not requested as unknown.
class JsonObject {
 public:
  /// `path` is the object's place in the file ("sequence"), empty for the outermost. Throws Error if `json` is not an
  /// object. `json` must outlive this object.
  JsonObject(const Json& json, std::string where, std::string path = {});

  /// Returns the value of `key`, or null if it is missing.
  const Json* find(const char* key);
  /// Returns the value of `key`; throws Error if it is missing.
  const Json& require(const char* key);

  void read(const char* key, double& value);
  void read(const char* key, int& value);
  void read(const char* key, std::uint64_t& value);
  void read(const char* key, bool& value);
  void read(const char* key, std::string& value);
  void read(const char* key, std::vector<int>& value);
  void read(const char* key, std::vector<double>& value);
  void read(const char* key, std::vector<std::string>& value);

  /// Returns the place in the file to which a key of another object belongs, 'sequence'; empty if there is none.
  using PlaceOf = std::function<std::string(const std::string& key)>;
  /// Throws Error naming the first key that was not requested, with its place or the key that may be meant.
  void finish(const PlaceOf& place_of = {}) const;

  /// Throws Error: `key` should have been `expected` ("a number").
  [[noreturn]] void wrong_type(const char* key, const std::string& expected) const;

 private:
  std::string full_name(std::string_view key) const;
  /// Returns the requested key that an unknown one may misspell; empty if there is none.
  std::string meant_key(const std::string& key) const;
  template <class Value, class IsValue>
  void read_as(const char* key, Value& value, const IsValue& is_value, const char* expected);

  const Json& json_;
  std::string where_, path_;
  std::vector<std::string> known_;
};

}  // namespace decid
