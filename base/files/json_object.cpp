// JSON objects read key by key. Types are checked strictly, and unknown keys are refused: a misspelt setting would
// otherwise silently keep its default. Format: RFC 8259, parsed by nlohmann's library.
#include "base/files/json_object.hpp"

#include <algorithm>
#include <limits>
#include <string_view>
#include <utility>

#include "base/error.hpp"
#include "base/text.hpp"

namespace decid {

namespace {

constexpr std::size_t max_shown = 40;  // of a key or a value, in an error

/// Returns at most `max_bytes` bytes, with "..." for the rest; never cuts a UTF-8 character.
std::string shortened(std::string text, std::size_t max_bytes) {
  if (text.size() <= max_bytes) return text;
  std::size_t end = max_bytes - 3;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return text.substr(0, end) + "...";
}

/// Counts the brackets outside of texts, so that deeply nested text is refused before it takes memory. Returns the
/// commas of each list and object, in the order in which they begin.
std::vector<std::uint32_t> check_depth(std::string_view text, const std::string& where) {
  std::vector<std::uint32_t> commas, open;
  int line = 1;
  bool quoted = false;
  std::size_t line_start = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') ++line, line_start = i + 1;
    if (quoted && c == '\\') ++i;
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    if (c == ',' && !open.empty()) ++commas[open.back()];
    if ((c == ']' || c == '}') && !open.empty()) open.pop_back();
    if (c != '[' && c != '{') continue;
    open.push_back(static_cast<std::uint32_t>(commas.size()));
    commas.push_back(0);
    if (open.size() > std::size_t{deepest_json}) {
      throw Error(Code::setting_malformed, where,
                  "has lists or objects nested deeper than " + std::to_string(deepest_json) + " levels at line " +
                      std::to_string(line) + ", column " + std::to_string(i - line_start + 1),
                  "correct the file there");
    }
  }
  return commas;
}

/// Prints the beginning of a value, until `text` is long enough to be shortened.
void print_beginning(const Json& json, std::string& text) {
  if (json.is_string()) {
    const Json begin = json.get_ref<const std::string&>().substr(0, max_shown + 1);
    text += begin.dump(-1, ' ', false, Json::error_handler_t::replace);
  } else if (!json.is_structured()) {
    text += json.dump();
  } else {
    const bool list = json.is_array();
    text += list ? '[' : '{';
    for (auto item = json.begin(); item != json.end() && text.size() <= max_shown; ++item) {
      if (item != json.begin()) text += ", ";
      if (!list) text += '"' + shortened(item.key(), max_shown) + "\": ";
      print_beginning(*item, text);
    }
    text += list ? ']' : '}';
  }
}

/// Builds values from the library's parser. The library's own builder compares each key with all before it, which takes
/// minutes for an object of 10 MB. This one appends keys, and looks for repeated ones when the object is complete.
class Builder {
 public:
  /// commas: per list and object, so that none has to grow.
  Builder(const std::string& where, std::vector<std::uint32_t> commas) : where_(where), commas_(std::move(commas)) {}

  bool null() { return put(nullptr); }
  bool boolean(bool value) { return put(value); }
  bool number_integer(std::int64_t value) { return put(value); }
  bool number_unsigned(std::uint64_t value) { return put(value); }
  bool number_float(double value, const std::string&) { return put(value); }
  bool string(std::string& value) { return put(std::move(value)); }
  bool binary(Json::binary_t&) { return false; }  // text never contains binary values
  bool start_object(std::size_t) { return open(Json::object()); }
  bool start_array(std::size_t) { return open(Json::array()); }
  bool end_array() { return close(); }
  bool end_object() {
    check_keys(open_.back()->get_ref<const Json::object_t&>());
    return close();
  }
  bool key(std::string& name) {
    key_ = std::move(name);
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const Json::exception& exception) {
    // The library's text begins with its own tag, "[json.exception.parse_error.101] ", which does not help the user.
    std::string problem = exception.what();
    if (const std::size_t tag = problem.find("] "); tag != std::string::npos) problem.erase(0, tag + 2);
    throw Error(Code::setting_malformed, where_, "is not valid JSON: " + shortened(std::move(problem), 200),
                "correct the file there");
  }

  Json take() { return std::move(root_); }

 private:
  /// Stores a value; the pointer is valid until another value follows.
  Json* place(Json value) {
    if (open_.empty()) {
      root_ = std::move(value);
      return &root_;
    }
    if (open_.back()->is_array()) return &open_.back()->get_ref<Json::array_t&>().emplace_back(std::move(value));
    return &open_.back()->get_ref<Json::object_t&>().emplace_back(std::move(key_), std::move(value)).second;
  }
  bool put(Json value) {
    place(std::move(value));
    return true;
  }
  bool open(Json value) {
    Json* const opened = open_.emplace_back(place(std::move(value)));
    const std::uint32_t commas = commas_[next_++];
    if (commas == 0) return true;
    if (opened->is_array()) {
      opened->get_ref<Json::array_t&>().reserve(commas + std::size_t{1});
    } else {
      opened->get_ref<Json::object_t&>().reserve(commas + std::size_t{1});
    }
    return true;
  }
  bool close() {
    open_.pop_back();
    return true;
  }

  void check_keys(const Json::object_t& object) const {
    if (object.size() < 2) return;
    std::vector<std::string_view> keys;
    keys.reserve(object.size());
    for (const auto& [name, value] : object) keys.push_back(name);
    std::ranges::sort(keys);
    if (const auto twice = std::ranges::adjacent_find(keys); twice != keys.end())
      throw Error(Code::setting_conflict, where_,
                  "the key '" + shortened(std::string(*twice), max_shown) + "' is repeated in one object",
                  "keep one of them");
  }

  const std::string& where_;
  Json root_;
  std::vector<Json*> open_;  // lists and objects around the next value
  std::string key_;          // of the next value
  std::vector<std::uint32_t> commas_;
  std::size_t next_ = 0;
};

}  // namespace

Json parse_json(std::string_view text, const std::string& where) {
  // Brackets count only in JSON: the parser refuses other files, such as an archive, at their first byte.
  const std::size_t begin = text.find_first_not_of("\xEF\xBB\xBF \t\r\n");
  const bool may_nest = begin != text.npos && (text[begin] == '{' || text[begin] == '[');
  Builder builder(where, may_nest ? check_depth(text, where) : std::vector<std::uint32_t>());
  Json::sax_parse(text, &builder);
  return builder.take();
}

std::string print_json(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace);
}

namespace {

bool is_int(const Json& json) {
  // Widest types first: a number above int's range would wrap around in get<int>().
  if (json.is_number_unsigned()) return json.get<std::uint64_t>() <= std::uint64_t{std::numeric_limits<int>::max()};
  return json.is_number_integer() && json.get<std::int64_t>() >= std::numeric_limits<int>::min();
}

bool is_number(const Json& json) {
  return json.is_number();
}

bool is_text(const Json& json) {
  return json.is_string();
}

auto list_of(bool (*is_entry)(const Json&)) {
  return [is_entry](const Json& json) { return json.is_array() && std::all_of(json.begin(), json.end(), is_entry); };
}

}  // namespace

JsonObject::JsonObject(const Json& json, std::string where, std::string path)
    : json_(json), where_(std::move(where)), path_(std::move(path)) {
  if (json_.is_object()) return;
  throw Error(Code::setting_malformed, where_, (path_.empty() ? "the text" : path_) + " is not a JSON object",
              "write {\"key\": value, ...}");
}

std::string JsonObject::full_name(std::string_view key) const {
  std::string name = "'";
  if (!path_.empty()) name.append(path_).append(".");
  return name.append(key).append("'");
}

void JsonObject::wrong_type(const char* key, const std::string& expected) const {
  std::string found;
  print_beginning(json_.at(key), found);
  throw Error(Code::setting_malformed, where_, full_name(key) + " is " + shortened(std::move(found), max_shown),
              "make it " + expected);
}

const Json* JsonObject::find(const char* key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.emplace_back(key);
  const auto found = json_.find(key);
  return found == json_.end() ? nullptr : &*found;
}

std::string JsonObject::meant_key(const std::string& key) const {
  if (key.size() > max_shown) return {};
  const std::string given = lower_case(key);
  const auto is_part = [&](const std::string& known) {  // 'sensor_noise' and 'rate_hz' lack a unit and a word
    return known.starts_with(given + "_") || known.ends_with("_" + given);
  };
  const auto may_misspell = [&](const std::string& known) {
    return count_edits(given, known) <= std::min<std::size_t>(2, std::max(given.size(), known.size()) / 3);
  };
  auto found = std::ranges::find_if(known_, is_part);
  if (found == known_.end()) found = std::ranges::find_if(known_, may_misspell);
  return found == known_.end() ? std::string() : *found;
}

const Json& JsonObject::require(const char* key) {
  if (const Json* json = find(key)) return *json;
  for (const auto& [given, value] : json_.items())
    if (std::string_view(key).starts_with(given + "_"))
      throw Error(Code::setting_missing, where_, full_name(key) + " is missing",
                  "add it, or rename " + full_name(given) + " to it");
  throw Error(Code::setting_missing, where_, full_name(key) + " is missing", "add it");
}

template <class Value, class IsValue>
void JsonObject::read_as(const char* key, Value& value, const IsValue& is_value, const char* expected) {
  const Json* json = find(key);
  if (json == nullptr) return;
  if (!is_value(*json)) wrong_type(key, expected);
  value = json->get<Value>();
}

void JsonObject::read(const char* key, double& value) {
  read_as(key, value, is_number, "a number");
}

void JsonObject::read(const char* key, int& value) {
  read_as(key, value, is_int, "a whole number");
}

void JsonObject::read(const char* key, std::uint64_t& value) {
  const auto is_unsigned = [](const Json& json) { return json.is_number_unsigned(); };
  read_as(key, value, is_unsigned, "a whole number from 0 to 2^64 - 1");
}

void JsonObject::read(const char* key, bool& value) {
  const auto is_boolean = [](const Json& json) { return json.is_boolean(); };
  read_as(key, value, is_boolean, "true or false");
}

void JsonObject::read(const char* key, std::string& value) {
  read_as(key, value, is_text, "a text");
}

void JsonObject::read(const char* key, std::vector<int>& value) {
  read_as(key, value, list_of(is_int), "a list of whole numbers");
}

void JsonObject::read(const char* key, std::vector<double>& value) {
  read_as(key, value, list_of(is_number), "a list of numbers");
}

void JsonObject::read(const char* key, std::vector<std::string>& value) {
  read_as(key, value, list_of(is_text), "a list of texts");
}

void JsonObject::finish(const PlaceOf& place_of) const {
  for (const auto& [key, value] : json_.items()) {
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    const std::string place = place_of ? place_of(key) : std::string(), meant = place.empty() ? meant_key(key) : "";
    throw Error(Code::setting_unknown, where_, "unknown key " + full_name(shortened(key, max_shown)),
                (!place.empty()   ? "move it into " + place + "; "
                 : !meant.empty() ? "call it '" + meant + "' if that is meant; "
                                  : std::string()) +
                    "the keys here are " + joined(known_, ", "));
  }
}

}  // namespace decid
