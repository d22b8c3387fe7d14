// Thousands separators: numbers that can only be read so, columns that tell, and columns that do not.
#include "recording/table/detail/thousands.hpp"

#include <vector>

#include "recording/formats/csv.hpp"
#include "recording/table/cells.hpp"
#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

std::vector<double> column(const std::string& text, int index = 0) {
  return CsvTable(text, "t.csv").numbers(index);
}

}  // namespace

TEST_CASE("digits in groups of three are one number") {
  for (const char* cell : {"1,234.5", "1.234,5", "1'234.5", "+1,234.5"}) {
    CAPTURE(std::string(cell));
    CHECK(is_plainly_grouped(cell));
    CHECK(parse_number(cell).value == 1234.5);
  }
  CHECK(parse_number("-1,234,567").value == -1234567.0);
  CHECK(parse_number("1.234.567,25").value == 1234567.25);
  CHECK(parse_number("1,234").value == 1.234);  // by itself a decimal comma
  for (const char* cell : {"1,2345.0", "0,123.4", ",123.4", "1,,234.5", "1,234.5.6", "12,34.5", "1,5,5", "1.5.2"}) {
    CAPTURE(std::string(cell));
    CHECK_FALSE(is_plainly_grouped(cell));
    CHECK_FALSE(parse_number(cell).is_number);
  }
}

TEST_CASE("the rest of a column decides the meaning of its commas") {
  const std::vector<double> thousands{990, 1000, 1010};
  CHECK(column("a,b\n\"990\",0.1\n\"1,000\",0.2\n\"1,010\",0.3\n") == thousands);
  CHECK(column("a;b\n990;1\n1,000;2\n1,010;3\n") == thousands);
  CHECK(column("a,b\n\"998.5\",1\n\"1,015\",2\n") == std::vector<double>{998.5, 1015});
  // Points in other columns: a comma between quotes is none then.
  CHECK(column("a,b\n\"1,015\",0.12\n\"1,016\",0.13\n") == std::vector<double>{1015, 1016});
  // Decimal commas.
  CHECK(column("a,b\n\"0,998\",1\n\"1,015\",2\n") == std::vector<double>{0.998, 1.015});
  CHECK(column("a;b\n1,015;2\n1,5;2\n") == std::vector<double>{1.015, 1.5});
  CHECK(column("a;b\n1,015;2,1\n1,016;2,2\n") == std::vector<double>{1.015, 1.016});
  CHECK(column("a;b\n990,0;1\n1.000,0;2\n1.010;3\n") == thousands);
  CHECK(column("a,b\n1.015,2\n1.016,2\n") == std::vector<double>{1.015, 1.016});
  CHECK(column("1,015\n1,016\n", 1) == std::vector<double>{15, 16});
}

TEST_CASE("a column that may be read in both ways is refused by name") {
  check_error([] { column("a,b\n\"1,015\",2\n\"1,016\",3\n"); }, Code::table_unclear, "'1,015'");
  check_error([] { column("a,b\n\"1,015.5\",2\n\"1,5\",3\n"); }, Code::value_invalid, "line 3, a");
}

TEST_CASE("times and positions with thousands separators are read rightly") {
  check_one_two_three("time_ms,sway_deg\n\"990\",1\n\"1,000\",2\n\"1,010\",3\n");
  check_one_two_three("Zeit_ms;sway_Grad\n990,0;1,0\n1.000,0;2,0\n1.010,0;3,0\n");
  const Recording positions =
      read("time_s,COM_x_mm\n0,\"1,000.0\"\n0.01,\"1,010.0\"\n0.02,\"990.0\"\n", {.com_height_m = 1.0});
  CHECK(near(positions.signals.at(com_sway).rad[1], std::asin(0.01), 1e-12));
}
