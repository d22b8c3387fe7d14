// JSON objects read key by key: types are checked strictly, unknown keys are refused (a misspelt setting would
// otherwise be silently left at its default).
// Format: RFC 8259, parsed by nlohmann's library.
#include "dataset/json_object.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "base/error.hpp"

namespace decid::dataset {

Json parse_json(const std::string& text, const std::string& where) {
  try {
    return Json::parse(text);
  } catch (const Json::exception& exception) {
    // The library's text opens with its own tag, "[json.exception.parse_error.101] ", which says nothing to a reader.
    std::string problem = exception.what();
    if (const std::size_t tag = problem.find("] "); tag != std::string::npos) problem.erase(0, tag + 2);
    throw Error(where, "is not valid JSON: " + problem, "correct the file there");
  }
}

std::string print_json(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

namespace {

bool is_int(const Json& json) {
  // Widest types first: a number above the range of int would wrap around in get<int>().
  if (json.is_number_unsigned()) return json.get<std::uint64_t>() <= std::uint64_t{std::numeric_limits<int>::max()};
  return json.is_number_integer() && json.get<std::int64_t>() >= std::numeric_limits<int>::min();
}

}  // namespace

JsonObject::JsonObject(const Json& json, std::string where, std::string path)
    : json_(json), where_(std::move(where)), path_(std::move(path)) {
  if (json_.is_object()) return;
  throw Error(where_, (path_.empty() ? "the text" : path_) + " is not a JSON object", "write {\"key\": value, ...}");
}

std::string JsonObject::name_of(std::string_view key) const {
  std::string name = "'";
  if (!path_.empty()) name.append(path_).append(".");
  return name.append(key).append("'");
}

void JsonObject::wrong_type(const char* key, const std::string& expected) const {
  std::string found = print_json(json_.at(key));
  if (found.size() > 40) found = found.substr(0, 37) + "...";
  std::replace(found.begin(), found.end(), '\n', ' ');
  throw Error(where_, name_of(key) + " is " + found, "make it " + expected);
}

const Json* JsonObject::find(const char* key) {
  known_.emplace_back(key);
  const auto found = json_.find(key);
  return found == json_.end() ? nullptr : &*found;
}

const Json& JsonObject::require(const char* key) {
  if (const Json* json = find(key)) return *json;
  throw Error(where_, name_of(key) + " is missing", "add it");
}

void JsonObject::read(const char* key, double& value) {
  const Json* json = find(key);
  if (!json) return;
  if (!json->is_number()) wrong_type(key, "a number");
  value = json->get<double>();
}

void JsonObject::read(const char* key, int& value) {
  const Json* json = find(key);
  if (!json) return;
  if (!is_int(*json)) wrong_type(key, "a whole number");
  value = json->get<int>();
}

void JsonObject::read(const char* key, std::uint64_t& value) {
  const Json* json = find(key);
  if (!json) return;
  if (!json->is_number_unsigned()) wrong_type(key, "a whole number from 0 to 2^64 - 1");
  value = json->get<std::uint64_t>();
}

void JsonObject::read(const char* key, bool& value) {
  const Json* json = find(key);
  if (!json) return;
  if (!json->is_boolean()) wrong_type(key, "true or false");
  value = json->get<bool>();
}

void JsonObject::read(const char* key, std::string& value) {
  const Json* json = find(key);
  if (!json) return;
  if (!json->is_string()) wrong_type(key, "a text");
  value = json->get<std::string>();
}

void JsonObject::read(const char* key, std::vector<int>& value) {
  const Json* json = find(key);
  if (!json) return;
  if (!json->is_array() || !std::all_of(json->begin(), json->end(), is_int)) wrong_type(key, "a list of whole numbers");
  value = json->get<std::vector<int>>();
}

void JsonObject::read(const char* key, std::vector<double>& value) {
  const Json* json = find(key);
  if (!json) return;
  const auto is_number = [](const Json& item) { return item.is_number(); };
  if (!json->is_array() || !std::all_of(json->begin(), json->end(), is_number)) wrong_type(key, "a list of numbers");
  value = json->get<std::vector<double>>();
}

void JsonObject::read(const char* key, std::vector<std::string>& value) {
  const Json* json = find(key);
  if (!json) return;
  const auto is_text = [](const Json& item) { return item.is_string(); };
  if (!json->is_array() || !std::all_of(json->begin(), json->end(), is_text)) wrong_type(key, "a list of texts");
  value = json->get<std::vector<std::string>>();
}

void JsonObject::finish() const {
  for (const auto& [key, value] : json_.items()) {
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    std::string list;
    for (const std::string& known : known_) list += (list.empty() ? "" : ", ") + known;
    throw Error(where_, "unknown key " + name_of(key), "the keys here are " + list);
  }
}

}  // namespace decid::dataset
