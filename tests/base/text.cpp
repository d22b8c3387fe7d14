// Text for people.
#include "base/text.hpp"

#include <doctest/doctest.h>

using namespace decid;

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
