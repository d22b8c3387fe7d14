// Headers behind # and %: every rule by name holds for them, and remarks are not headers.
#include "recording/table/detail/commented_header.hpp"

#include <string>

#include "recording/formats/csv.hpp"
#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

using Names = std::vector<std::string>;

TEST_CASE("a commented header names the columns") {
  for (const char* header : {"# time,sway_deg\n", "%time,sway_deg\n", "# by lab 3, A and B\n#time, sway_deg\n",
                             "# time sway_deg\n", "# time,sway\n# s,deg\n", "# lab 3\n\n## time (s),sway (deg)\n"}) {
    INFO(std::string(header));
    const std::string text = header + std::string("0,1\n0.01,2\n0.02,3\n");
    check_one_two_three(text);
    CHECK(read(text).warnings.empty());
  }
  check_one_two_three("% time_ms  sway_deg\n0 1\n10 2\n20 3\n");
  check_one_two_three("#\ttime\tsway_deg\n1\t0\t1\n2\t0.01\t2\n3\t0.02\t3\n");
  check_one_two_three("# sway_deg\n1\n2\n3\n", {.rate_hz = 100.0});
  check_one_two_three("Subject: A, B, C\n# time,sway_deg\n0,1\n0.01,2\n0.02,3\n");
}

TEST_CASE("its units and quantities count") {
  check_error(reading("# time,COM_x_cm\n0,1\n0.01,2\n0.02,3\n"), Code::column_unsuitable, "COM_x_cm");
  check_error(reading("% time,torque\n0,1\n0.01,2\n0.02,3\n"), Code::column_unsuitable);
  CHECK(read("# time,com_sway_rad\n0,0.1\n0.01,0.2\n").signals.at(com_sway).rad[1] == 0.2);
}

TEST_CASE("a commented header above rows with words, and rows with words without a header") {
  check_one_two_three("# time,mode,pitch_deg\n0,BALANCE,1\n0.01,BALANCE,2\n0.02,BALANCE,3\n");
  check_one_two_three("# time,mode,pitch_deg\n0,STAND,1\n0.01,,2\n0.02,BALANCE,3\n");
  check_one_two_three(
      "%time_ns,field.header.seq,field.header.stamp,field.header.frame_id,field.y_deg\n"
      "1732876342100000000,0,1732876342100000000,base_link,1\n1732876342110000000,1,1732876342110000000,base_link,2\n"
      "1732876342120000000,2,1732876342120000000,base_link,3\n");
  check_one_two_three("0,BALANCE,1\n0.01,BALANCE,2\n0.02,BALANCE,3\n", {.unit = Unit::degree});
  CHECK(CsvTable("a,2\nb,3\n", "t").rows(0) == 2);
  // Names: of a quantity, or above other kinds of cells.
  CHECK(CsvTable("sway,2\na,3\n", "t").names() == Names{"sway", "2"});
  CHECK(CsvTable("name,2,x\n1,2,3\n", "t").names() == Names{"name", "2", "x"});
  CHECK(CsvTable("a,b\n1,word\n", "t").names() == Names{"a", "b"});
}

TEST_CASE("remarks are no header, and a header of its own is another") {
  for (const char* remark : {"# by hand, twice\n", "# two words\n", "% 2026-03-05\n", "# 1,2\n"}) {
    INFO(std::string(remark));
    check_one_two_three(remark + std::string("0,1\n0.01,2\n0.02,3\n"), {.unit = Unit::degree});
    CHECK_FALSE(CsvTable(remark + std::string("0,1\n0.01,2\n"), "t").has_header());
  }
  CHECK(CsvTable("# sway of subject 3\n1\n2\n", "t").names() == Names{"column 1"});
  CHECK(CsvTable("# time,COM_x_cm\na,b\n1,2\n", "t").names() == Names{"a", "b"});
  CHECK(CsvTable("1,2\n# time,sway\n3,4\n", "t").names() == Names{"column 1", "column 2"});
}

TEST_CASE("comments state a rate") {
  check_one_two_three("# Sampling rate: 100 Hz\n# x,sway_deg\n7,1\n7,2\n7,3\n");
  // A first column of time stays one, a counter does not become one.
  check_one_two_three("# fs: 100\n0,1\n0.01,2\n0.02,3\n", {.unit = Unit::degree});
  check_one_two_three("# fs: 100\n1,1\n2,2\n3,3\n", {.column = "2", .unit = Unit::degree});
}
