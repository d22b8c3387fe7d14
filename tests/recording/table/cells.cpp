// Cells of text files: separators, decimal commas and clock times, and invalid ones.
#include "recording/table/cells.hpp"

#include <string>
#include <tuple>
#include <vector>

#include "tests/helpers.hpp"

using namespace decid::recording;

namespace {

std::vector<std::string> parts(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  split(line, separator, cells);
  return {cells.begin(), cells.end()};
}

/// Seconds from the first time to the second.
double between(std::string_view first, std::string_view second) {
  const auto a = clock_time(first), b = clock_time(second);
  REQUIRE(a);
  REQUIRE(b);
  return 86400.0 * (b->day - a->day) + b->s - a->s;
}

}  // namespace

TEST_CASE("cells: the separator is the one in the data, outside quotes") {
  CHECK(guess_separator("", "1;2") == ';');
  CHECK(guess_separator("a,b", "\"1;2\",3") == ',');
  CHECK(guess_separator("a", "7") == ',');
  CHECK(guess_separator("", "1 2 3") == ' ');
  // Commas between blanks are decimal ones if a digit follows each and every word is a number.
  CHECK(guess_separator("", "1,5 2,7") == ' ');
  CHECK(guess_separator("", "1,5 2,") == ',');
  CHECK(guess_separator("", "1, 2") == ',');
  CHECK(guess_separator("", "1,5 x2") == ',');
  CHECK(guess_separator("", "1,a 2") == ',');
  CHECK(guess_separator("", "1,/ 2") == ',');
  // One number with a decimal comma is one column below one name, and two columns below two, or below none.
  CHECK(guess_separator("sway", "1,5") == ' ');
  CHECK(guess_separator("a,b", "1,5") == ',');
  CHECK(guess_separator("a b", "1,5") == ',');
  CHECK(guess_separator("", "1,5") == ',');
  CHECK(guess_separator("2", "1,5") == ',');
  CHECK(guess_separator("sway", "1,5,2") == ',');
  // A time of the day has a blank within.
  CHECK(guess_separator("", "2026-01-31 12:00:00") == ',');
}

TEST_CASE("cells: quotes hold separators, and belong to no cell") {
  using Parts = std::vector<std::string>;
  CHECK(parts("\"a,b\",2", ',') == Parts{"a,b", "2"});
  CHECK(parts("\"a\"x,\"", ',') == Parts{"\"a\"x", "\""});
  CHECK(parts(" 1   2 ", ' ') == Parts{"1", "2"});
  CHECK(parts("1,,", ',') == Parts{"1", "", ""});
}

TEST_CASE("cells: dates of four kinds, times of the day and durations") {
  for (const auto& [first, second, s] : {std::tuple{"2024-02-28 12:00:00", "2024-03-01 12:00:01", 2 * 86400.0 + 1.0},
                                         {"28.02.2023 12:00:00", "01.03.2023 12:00:00,5", 86400.0 + 0.5},
                                         {"2023/12/31T23:59:59Z", "1/1/2024 00:00:00", 1.0},
                                         {"3/1/2026 00:00:00", "2026-03-01 00:00:01", 1.0},
                                         {"2100-02-28 00:00:00", "2100-03-01 00:00:00", 86400.0},
                                         {"1900-01-01 00:00:00", "2000-01-01 00:00:00", 36524 * 86400.0},
                                         {"05-Mar-2026 12:03:04.250", "2026-03-05 12:03:05.250", 1.0},
                                         {"31-Dec-2025 23:59:59", "01-Jan-2026 00:00:00.5", 1.5},
                                         {"2026-03-01 00:00:01+05:30", "2026-03-01 00:00:01", 0.0},
                                         {"23:59:59.25", "24:00:00", 0.75},
                                         {"00:00:00", "1:02:03.5 PM", 13.0 * 3600.0 + 123.5},
                                         {"00:00:00", "12:00:00 am", 0.0},
                                         {"00:00:00", "2:03.5", 123.5},
                                         {"00:00:00", "01:02:03:250", 3723.25},
                                         {"00:00:00", "2 days 00:00:01.5", 2 * 86400.0 + 1.5},
                                         {"0.01 sec", "0.035 sec", 0.025},
                                         {"1 sec", "0.5 min", 29.0}}) {
    const std::string from = first;  // clang 14 captures no structured binding
    CAPTURE(from);
    CHECK(decid::test::within(between(from, second), s, 1e-9));
  }
  for (const std::string none : {"12",
                                 "12:00",
                                 "12:00:00:00",
                                 "12:00:61",
                                 "12:60:00",
                                 "25:00:00",
                                 "12:-1:00",
                                 "12:00:0x",
                                 "x:00:00",
                                 "",
                                 "2:03",
                                 "x days 00:00:01",
                                 "1:2:3:4",
                                 "12:00:00+0",
                                 "-1:00.5",
                                 "12:00:00.5e1",
                                 "12:00:00.5E1",
                                 "12:00:00.5x",
                                 "2024-13-01 12:00:00",
                                 "2024-00-01 12:00:00",
                                 "2024-01-00 12:00:00",
                                 "2024-01-32 12:00:00",
                                 "12024-01-01 12:00:00",
                                 "2024-01 12:00:00",
                                 "2024_01_01 12:00:00",
                                 "1.2.3 12:00",
                                 "05-Mae-2026 12:00:00",
                                 "05-anF-2026 12:00:00",
                                 "x sec",
                                 "nan sec",
                                 "12 h",
                                 "T12:00:00"}) {
    INFO(none);
    CHECK_FALSE(clock_time(none));
  }
}

TEST_CASE("cells: Fortran's exponents are numbers, other letters are not") {
  CHECK(parse_number("1.0D-03").value == 1.0e-3);
  CHECK(parse_number("-2.5d+02").value == -250.0);
  CHECK(parse_number("+.5D1").value == 5.0);
  CHECK(parse_number("3.D0").value == 3.0);
  for (const char* cell : {"3D", "2D1", "1.0D", "1.0D-", "D1.0", "1.5deg", "1.0D1D1", "1.0D-03x"}) {
    INFO(cell);
    CHECK_FALSE(parse_number(cell).is_number);
  }
}
