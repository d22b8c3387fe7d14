// Text for people.
#include "base/text.hpp"

#include <doctest/doctest.h>

#include <clocale>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/helpers.hpp"

using namespace decid;

#ifndef __wasi__
// glibc's file of a locale: a magic number per category, the number of fields, their offsets. Here: the decimal comma,
// no separator of thousands, both again as wide characters, the encoding. Another C library rejects it.
TEST_CASE("format: decimal points in a host's locale of decimal commas") {
  using namespace std::string_literals;
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(folder / "comma");
  std::string file;
  for (const std::uint32_t number : {0x20031115U ^ LC_NUMERIC, 6U, 32U, 34U, 35U, 36U, 40U, 44U})
    for (unsigned shift = 0; shift < 32; shift += 8) file += static_cast<char>(number >> shift & 0xFFU);
  test::write_text(folder / "comma/LC_NUMERIC", file + ",\0\0\0,\0\0\0\0\0\0\0UTF-8\0"s);
  REQUIRE(::setenv("LOCPATH", folder.path().c_str(), 1) == 0);
  const bool is_set = std::setlocale(LC_NUMERIC, "comma") != nullptr;
  ::unsetenv("LOCPATH");
  if (!is_set) {
    MESSAGE("skipped: the C library does not read the locale");
    return;
  }
  char by_host[8];
  std::snprintf(by_host, sizeof by_host, "%g", 1.5);
  const std::string by_decid = format("%g", 1.5);
  char afterwards[8];
  std::snprintf(afterwards, sizeof afterwards, "%g", 1.5);
  std::setlocale(LC_NUMERIC, "C");
  CHECK(std::string(by_host) == "1,5");
  CHECK(by_decid == "1.5");
  CHECK(std::string(afterwards) == "1,5");
}
#endif

TEST_CASE("counted: the plural of all but one") {
  CHECK(counted(0, "trial") == "0 trials");
  CHECK(counted(1, "trial") == "1 trial");
  CHECK(counted(12100, "sample") == "12100 samples");
}

TEST_CASE("joined, lower_case") {
  CHECK(joined(std::vector<std::string>{"a", "b"}, ", ") == "a, b");
  CHECK(joined(std::vector<int>{1, 2, 3}, "-", [](int i) { return std::to_string(i); }) == "1-2-3");
  CHECK(joined(std::vector<std::string>{}, ", ").empty());
  CHECK(lower_case("aZ 9\u00C4") == "az 9\u00C4");
}

TEST_CASE("duration_text: rounded up") {
  CHECK(duration_text(41.2) == "42 s");
  CHECK(duration_text(200) == "3 min 20 s");
  CHECK(duration_text(4320) == "1 h 12 min");
}

TEST_CASE("one_line: control characters are question marks") {
  CHECK(one_line("a\nb\x1b[31m") == "a?b?[31m");
}

TEST_CASE("csv_cell: quoted where RFC 4180 asks for it") {
  CHECK(csv_cell("trial 1.csv") == "trial 1.csv");
  CHECK(csv_cell("").empty());
  CHECK(csv_cell("a,b") == "\"a,b\"");
  CHECK(csv_cell("a \"b\"") == "\"a \"\"b\"\"\"");
  CHECK(csv_cell("a\nb") == "\"a\nb\"");
  CHECK(csv_cell("a\rb") == "\"a\rb\"");
  CHECK(csv_cell(" a") == "\" a\"");
  CHECK(csv_cell("=HYPERLINK(\"x\")") == "\"'=HYPERLINK(\"\"x\"\")\"");
  CHECK(csv_cell("-1.csv") == "'-1.csv");
  for (const char* number : {"-1.5", "-3", "+0.25", "-99"}) CHECK(csv_cell(number) == number);
  CHECK(csv_cell("-0,25") == "\"-0,25\"");
  for (const char* text : {"-", "+49 170", "-1-2", "-1.", "-.5", "=1", "-1.5e3"})
    CHECK(csv_cell(text) == std::string("'") + text);
  CHECK(csv_cell("a=b") == "a=b");
}

TEST_CASE("shell_quoted: a shell reads the word as it is") {
  CHECK(shell_quoted("data/sub-01_a.csv") == "data/sub-01_a.csv");
  CHECK(shell_quoted("--range=delay=0.05,0.2") == "--range=delay=0.05,0.2");
  CHECK(shell_quoted("").size() == 2);
  CHECK(shell_quoted("it's.csv") == "'it'\\''s.csv'");
  for (const char* text : {"a b", "`id`", "~/a.csv", "!a", "#a", "{a,b}", "$HOME", "a\\b", "m\xC3\xBCller.csv"})
    CHECK(shell_quoted(text) == "'" + std::string(text) + "'");
}
