// JSON as decid reads it: what is nested too deeply or said twice is refused, and errors stay short.
#include "base/files/json_object.hpp"

#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::test;

namespace {

std::string nested(std::size_t levels) {
  return std::string(levels, '[') + std::string(levels, ']');
}

}  // namespace

TEST_CASE("nesting is bounded, with its place") {
  CHECK(parse_json(nested(32), "x.json").is_array());
  check_error([] { parse_json(nested(33), "x.json"); }, Code::setting_malformed, "line 1, column 33");
  check_error([] { parse_json("{\n\"name\":\n  " + nested(100'000) + "}", "x.json"); }, Code::setting_malformed,
              "line 3, column 34");
  // Objects count too, brackets in texts do not, and those that are closed are gone.
  std::string objects = "1";
  for (int i = 0; i < 33; ++i) objects = "{\"a\": " + objects + "}";
  check_error([&] { parse_json(objects, "x.json"); }, Code::setting_malformed, "32");
  CHECK(parse_json("[\"" + std::string(100, '[') + "\\\"" + std::string(100, '{') + "\"]", "x.json").size() == 1);
  std::string row = "[0";
  for (int i = 0; i < 100; ++i) row += ",[{}]";
  CHECK(parse_json(row + "]", "x.json").size() == 101);
  // More brackets closed than opened are the parser's to refuse.
  check_error([] { parse_json("]]]]", "x.json"); }, Code::setting_malformed);
}

TEST_CASE("a key that is repeated is refused") {
  check_error([] { parse_json(R"({"a": 1, "b": 2, "a": 1})", "x.json"); }, Code::setting_conflict, "'a'");
  // In different objects it may.
  CHECK(parse_json(R"([{"a": {"a": 1}, "b": {"a": 1}}, {"a": 1}])", "x.json").size() == 2);
  const std::string length = message_of([] {
    const std::string key(100'000, 'k');
    parse_json("{\"" + key + "\": 1, \"" + key + "\": 1}", "x.json");
  });
  CHECK(contains(length, "is repeated"));
  CHECK(length.size() < 200);
}

TEST_CASE("an object of very many keys is read in a time that grows with their number") {
  std::string text = "{\"key\": 0";
  for (int i = 0; i < 400'000; ++i) text += ", \"" + std::to_string(i) + "\": " + std::to_string(i);
  const Json json = parse_json(text + "}", "x.json");
  CHECK(json.size() == 400'001);
  CHECK(json["399999"] == 399'999);
  CHECK(json.begin().key() == "key");
  check_error([&] { parse_json(text + ", \"7\": 1}", "x.json"); }, Code::setting_conflict, "'7'");
}

TEST_CASE("values are those that the library's own builder makes") {
  const std::string text = R"({"a": [1, -2, 18446744073709551615, 1e999, 2.5e-3, true, false, null, "\u00e4\n"], )"
                           R"("b": {"c": {}, "d": []}, "": ""})";
  check_error([&] { parse_json(text, "x.json"); }, Code::setting_malformed, "x.json");
  const std::string finite = text.substr(0, text.find("1e999")) + "1e99" + text.substr(text.find("1e999") + 5);
  CHECK(parse_json(finite, "x.json") == Json::parse(finite));
  CHECK(parse_json(" 7 ", "x.json") == 7);
  for (const char* wrong : {"", "{", "[1,]", "{\"a\" 1}", "{\"a\": 1} x", "nul", "\"\\ud800\""})
    check_error([&] { parse_json(wrong, "x.json"); }, Code::setting_malformed);
}

TEST_CASE("brackets in a file that is not JSON are no nesting") {
  const std::string archive = "PK\x03\x04" + std::string(40, '[');
  CHECK(contains(message_of([&] { parse_json(archive, "x.npz"); }), "is not valid JSON"));
  CHECK(parse_json("\xEF\xBB\xBF [1]", "x.json").size() == 1);
}

TEST_CASE("an unknown key is shown with its place, or with the key that may be meant") {
  const auto finished = [](const std::string& text, const JsonObject::PlaceOf& place_of = {}) {
    return message_of([&] {
      const Json json = parse_json(text, "x.json");
      JsonObject object(json, "x.json", "part");
      double value = 0.0;
      for (const char* key : {"sample_rate_hz", "size_deg", "name"}) object.read(key, value);
      object.finish(place_of);
    });
  };
  CHECK(contains(finished(R"({"size": 1})"), "'size_deg'"));
  CHECK(contains(finished(R"({"rate_hz": 1})"), "'sample_rate_hz'"));
  CHECK(contains(finished(R"({"smaple_rate_hz": 1})"), "'sample_rate_hz'"));
  CHECK_FALSE(contains(finished(R"({"other": 1})"), "call it"));
  CHECK(contains(finished(R"({"size": 1})", [](const std::string& key) { return "<" + key + ">"; }), "<size>"));
  const std::string missing = message_of([] {
    const Json json = parse_json(R"({"mass": 1})", "x.json");
    JsonObject(json, "x.json", "body").require("mass_kg");
  });
  CHECK(contains(missing, "'body.mass'"));
}

TEST_CASE("errors show the beginning of a value, and each known key once") {
  const auto reading = [](const std::string& value) {
    return message_of([&] {
      const Json json = parse_json("{\"key\": " + value + "}", "x.json");
      JsonObject object(json, "x.json");
      double number = 0.0;
      object.read("key", number);
    });
  };
  CHECK(reading("[1, \"two\", {\"a\": null}]") == "x.json: 'key' is [1, \"two\", {\"a\": null}]; make it a number");
  CHECK(contains(reading("\"short\""), "'key' is \"short\";"));
  std::string wide = "[0";
  for (int i = 0; i < 100'000; ++i) wide += ",[" + std::to_string(i) + "]";
  CHECK(contains(reading(wide + "]"), "'key' is [0, [0], [1], [2], [3], [4], [5], [6]...;"));
  // 36 bytes and a cut through the middle of a character that takes two.
  const std::string umlauts = reading("\"" + std::string(35, 'x') + "\xC3\xA4\xC3\xA4\xC3\xA4\xC3\xA4\"");
  CHECK(contains(umlauts, "'key' is \"" + std::string(35, 'x') + "...;"));
  CHECK(contains(reading(nested(31)), "'key' is " + std::string(31, '[')));
  CHECK(message_of([] { parse_json("{\"" + std::string(100'000, 'x'), "x.json"); }).size() < 300);

  const Json json = parse_json(R"({"first": 1, "second": 2, ")" + std::string(100'000, 'k') + R"(": 3})", "x.json");
  const std::string unknown = message_of([&] {
    JsonObject object(json, "x.json");
    double number = 0.0;
    for (const char* key : {"first", "second", "first"}) object.read(key, number);
    object.finish();
  });
  CHECK(contains(unknown, "the keys here are first, second"));
  CHECK_FALSE(contains(unknown, "second, first"));
  CHECK(unknown.size() < 300);
}
