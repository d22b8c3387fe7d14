// Tables as text: each dialect with the names and numbers that it must give, and every refusal with its line.
#include "recording/formats/csv.hpp"

#include <cmath>
#include <vector>

#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

using Names = std::vector<std::string>;
using Columns = std::vector<std::vector<double>>;

void check_table(const std::string& text, const Names& names, const Columns& columns, bool has_header = true) {
  INFO(text);
  const CsvTable table(text, "t.csv");
  CHECK(table.has_header() == has_header);
  CHECK(table.names() == names);
  REQUIRE(table.columns() == static_cast<int>(columns.size()));
  for (int c = 0; c < table.columns(); ++c) {
    const std::vector<double>& expected = columns[static_cast<std::size_t>(c)];
    CHECK(table.rows(c) == expected.size());
    CHECK(table.numbers(c) == expected);
  }
}

/// Makes the table and takes the numbers of one column.
auto taking(const std::string& text, int column, Missing missing = Missing::refused) {
  return [=] { CsvTable(text, "t.csv").numbers(column, missing); };
}

auto making(const std::string& text) {
  return [=] { CsvTable(text, "t.csv"); };
}

const Names a_b{"a", "b"}, unnamed{"column 1", "column 2"};
const Columns numbers{{1.5, -2.25}, {3, 4}};

}  // namespace

TEST_CASE("csv: commas, semicolons, tabs and blanks separate") {
  check_table("a,b\n1.5,3\n-2.25,4\n", a_b, numbers);
  check_table("a;b\n1.5;3\n-2.25;4\n", a_b, numbers);
  check_table("a\tb\n1.5\t3\n-2.25\t4\n", a_b, numbers);
  check_table("a b\n1.5 3\n-2.25 4\n", a_b, numbers);
  check_table("  a    b \n 1.5   3\n-2.25   4 \n", a_b, numbers);  // a run of blanks separates once
  check_table("a , b\n 1.5,3 \n-2.25\t, 4\n", a_b, numbers);
  // The second line decides: a header may hold anything.
  check_table("a, all of it;b\n1.5;3\n-2.25;4\n", {"a, all of it", "b"}, numbers);
}

TEST_CASE("csv: a decimal comma where it cannot separate") {
  check_table("a;b\n1,5;3\n-2,25;4\n", a_b, numbers);
  check_table("a\tb\n1,5\t3\n-2,25\t4\n", a_b, numbers);
  check_table("a b\n1,5 3,0\n-2,25 4,0\n", a_b, numbers);
  check_table("1,5 3,0\n-2,25 4,0\n", unnamed, numbers, false);
  check_table("a,b\n\"1,5\",3\n\"-2,25\",4\n", a_b, numbers);
  check_table("a b\n\"1,5\" 3,0\n\"-2,25\" \"4,0\"\n", a_b, numbers);
  check_table("a\n1,5\n-2,25\n", {"a"}, {{1.5, -2.25}});
  // Without a header's word, two numbers.
  check_table("1,5\n2,25\n", unnamed, {{1, 2}, {5, 25}}, false);
  check_table("a, b\n1, 3\n2, 4\n", a_b, {{1, 2}, {3, 4}});
  check_error(taking("a;b\n1,5,5;3\n", 0), Code::value_invalid, "line 2, a");
}

TEST_CASE("csv: numbers as they are written") {
  check_table("+1\n-.5\n2.\n1e3\n1E-2\n-0\n1.7976931348623157e308\n5e-324\n", {"column 1"},
              {{1, -0.5, 2, 1000, 0.01, 0, 1.7976931348623157e308, 5e-324}}, false);
  CHECK(std::signbit(CsvTable("-0\n", "t.csv").numbers(0).front()));
  for (const std::string odd : {"0x10", "1.5.2", "+-1", "++1", "1e", "1 2", "--1", "1_000", "one"}) {
    CAPTURE(odd);
    check_error(taking("a;b\n" + odd + ";3\n", 0), Code::value_invalid, "line 2, a");
  }
  check_error(taking("a;b\n" + std::string(50, 'x') + ";3\n", 0), Code::value_invalid,
              ("'" + std::string(37, 'x') + "...'").c_str());
}

TEST_CASE("csv: a header is a line with a word that is no number") {
  check_table("1.5,3\n-2.25,4\n", unnamed, numbers, false);
  check_table("1.5,b\n1.5,3\n-2.25,4\n", {"1.5", "b"}, numbers);
  check_table("a,,c\n1.5,3,0\n-2.25,4,0\n", {"a", "column 2", "c"}, {{1.5, -2.25}, {3, 4}, {0, 0}});
  // An empty cell is not a word.
  const CsvTable gap("1.5,,0\n", "t.csv");
  CHECK_FALSE(gap.has_header());
  CHECK(gap.columns() == 3);
  CHECK(gap.rows(0) == 1);
}

TEST_CASE("csv: a line of units becomes part of the names") {
  check_table("a,b\ns,deg\n1.5,3\n-2.25,4\n", {"a (s)", "b (deg)"}, numbers);
  check_table("a;b\n[ms];(N m)\n1,5;3\n-2,25;4\n", {"a (ms)", "b (N m)"}, numbers);
  check_table("a,b\n-,deg\n1.5,3\n-2.25,4\n", {"a", "b (deg)"}, numbers);
  check_table("a,b\n,\xC2\xB0\n1.5,3\n-2.25,4\n", {"a", "b (\xC2\xB0)"}, numbers);
  check_table("a,b\n1,1\n2,2\n", a_b, {{1, 2}, {1, 2}});  // "1" is a unit, but numbers are data
  // Below the header only, and known ones only.
  check_error(taking("a,b\n1,1\ns,deg\n", 0), Code::value_invalid, "line 3, a");
  check_table("a,b,c\ns,N.mm,uV\n1,3,5\n2,4,6\n", {"a (s)", "b (N.mm)", "c (uV)"}, {{1, 2}, {3, 4}, {5, 6}});
  check_table("a,b\ns,furlongs\n1,3\n2,4\n", {"a (s)", "b (furlongs)"}, {{1, 2}, {3, 4}});
  check_error(taking("a,b,c\ns,some,word\n1,1,1\n", 0), Code::value_invalid, "line 2, a");
}

TEST_CASE("csv: quotes hold separators, and are no part of names and numbers") {
  check_table("\"a, in s\",\"b\"\n\"1.5\",3\n-2.25,\" 4 \"\n", {"a, in s", "b"}, numbers);
  check_table("\"a;x\";b\n1.5;3\n-2.25;\"4\"\n", {"a;x", "b"}, numbers);
  // Whatever a note holds, it does not decide what separates.
  for (const std::string note : {"x; y", "x\ty", "x y", "x, y", "x"}) {
    CAPTURE(note);
    const CsvTable table("a,b,note\n1.5,3,\"" + note + "\"\n-2.25,4,\n", "t.csv");
    REQUIRE(table.names() == Names{"a", "b", "note"});
    CHECK(table.numbers(0) == numbers[0]);
    CHECK(table.numbers(1) == numbers[1]);
  }
}

TEST_CASE("csv: comments, blank lines, byte order mark, line ends and a last separator are accepted") {
  check_table("# made by hand\n\n% too\na,b\n  \t\n1.5,3\n # a pause\n-2.25,4\n\n", a_b, numbers);
  check_table(
      "\xEF\xBB\xBF"
      "a,b\n1.5,3\n-2.25,4",
      a_b, numbers);
  check_table("a,b\r\n1.5,3\r\n-2.25,4\r\n", a_b, numbers);
  check_table("a,b\r1.5,3\r-2.25,4\r", a_b, numbers);
  check_table("a,b,\n1.5,3,\n-2.25,4,\n", a_b, numbers);
  check_table("a,b\n1.5,3,\n-2.25,4\n", a_b, numbers);
}

TEST_CASE("csv: a line that begins with a spreadsheet's missing value is a row, not a comment") {
  const auto kept = [](const std::string& text, int column) {
    std::vector<double> values = CsvTable(text, "t.csv").numbers(column, Missing::kept);
    for (double& value : values) value = std::isnan(value) ? -99.0 : value;
    return values;
  };
  const double missing = -99.0;
  for (const std::string cell : {"#N/A", "#NV", "#n/a", " #N/A "}) {
    CAPTURE(cell);
    CHECK(kept("sway_deg\n1\n" + cell + "\n3\n4\n", 0) == std::vector{1.0, missing, 3.0, 4.0});
    CHECK(kept("sway_deg\n" + cell + "\n2\n3\n4\n", 0) == std::vector{missing, 2.0, 3.0, 4.0});
    CHECK(kept("a,b\n1,2\n" + cell + ",3\n4,5\n", 0) == std::vector{1.0, missing, 4.0});
    CHECK(kept("a;b\n" + cell + ";" + cell + "\n1;2\n4;5\n6;7\n", 0) == std::vector{missing, 1.0, 4.0, 6.0});
  }
  for (const std::string comment : {"# a remark", "#", "%", "#Nx", "# , 1", "#,1"})
    CHECK(kept("a,b\n1,2\n" + comment + "\n4,5\n", 0) == std::vector{1.0, 4.0});
  check_error(taking("sway_deg\n1\n#N/A\n3\n", 0), Code::value_missing, "line 3");
}

TEST_CASE("csv: a blank line between the rows of one column is a missing sample") {
  const auto kept = [](const std::string& text) {
    std::vector<double> values = CsvTable(text, "t.csv").numbers(0, Missing::kept);
    for (double& value : values) value = std::isnan(value) ? -99.0 : value;
    return values;
  };
  const double missing = -99.0;
  for (const std::string end : {"\n", "\r\n", "\r"}) {
    std::string text = "\n\nsway_deg\n\n1\n2\n\n4\n# a pause\n5\n \n\n8\n9\n10\n\n\n";
    for (std::size_t at = 0; (at = text.find('\n', at)) != text.npos; at += end.size()) text.replace(at, 1, end);
    CHECK(kept(text) == std::vector{1.0, 2.0, missing, 4.0, 5.0, missing, missing, 8.0, 9.0, 10.0});
    check_error(taking(text, 0), Code::value_missing, "line 7");
    const CsvTable table(text, "t.csv");
    CHECK(table.locate(3) == "line 8");
    CHECK(table.locate(9) == "line 15");
  }
  CHECK(kept("\"1\"\n\"2\"\n\n\"4\"\n") == std::vector{1.0, 2.0, missing, 4.0});
  // As many between all rows: the program's line ends. A few more than half: unclear.
  CHECK(kept("1\r\r\n2\r\r\n3\r\r\n4\r\r\n") == std::vector{1.0, 2.0, 3.0, 4.0});
  CHECK(kept("sway\n\n\n1\n\n\n2\n\n\n3\n") == std::vector{1.0, 2.0, 3.0});
  check_error(making("1\n\n2\n\n3\n4\n\n5\n"), Code::table_unclear, "3 blank lines");
  CHECK(kept("a,b\n1,2\n\n3,4\n5,6\n") == std::vector{1.0, 3.0, 5.0});  // of several columns: no samples
}

TEST_CASE("csv: rows are found in the file") {
  const CsvTable table("# c\n\na,b\ns,deg\r\n1,2\n\n# c\n3,4\r5,6\n", "t.csv");
  REQUIRE(table.rows(0) == 3);
  CHECK(table.locate(0) == "line 5");
  CHECK(table.locate(1) == "line 8");
  CHECK(table.locate(2) == "line 9");
  CHECK(CsvTable("1,2\n3,4\n", "t.csv").locate(1) == "line 2");
  check_error(taking("# c\n\na,b\ns,deg\r\n1,2\n\n# c\n3,x\n5,6\n", 1), Code::value_invalid, "line 8, b (deg)");
}

TEST_CASE("csv: kept rows keep their cells, quoted, between blanks and plain") {
  for (const char* text :
       {"a,b,c\n1,2,x\n3,4,y\n5,6,z\n7,8,y\n", "a,b,c\n\"1\",2,x\n3, \"4\",\"y\"\n5,6,z\n7,8,\" y\"\n",
        "a b c\n1  2 x\n 3 4 y\n5 6 z\n7 8 y\n"}) {
    INFO(text);
    CsvTable table(text, "t.csv");
    table.keep_rows(0, {1, 3});
    CHECK(table.numbers(0) == std::vector{3.0, 7.0});
    CHECK(table.numbers(1) == std::vector{4.0, 8.0});
    CHECK(table.labels(2).values == Names{"y"});
    CHECK(table.label(2, 1) == "y");
    CHECK(table.locate(1) == "line 5");
    table.keep_rows(0, {1});
    CHECK(table.numbers(1) == std::vector{8.0});
    CHECK(table.locate(0) == "line 5");
  }
}

TEST_CASE("csv: missing cells are refused or kept as gaps; invalid cells are always refused") {
  for (const std::string cell : {"", "nan", "NaN", "-nan", "NA", "n/a", "N/A", "null", "-"}) {
    CAPTURE(cell);
    const std::string text = "a,b\n1,2\n3," + cell + "\n5,6\n";
    const std::vector<double> kept = CsvTable(text, "t.csv").numbers(1, Missing::kept);
    REQUIRE(kept.size() == 3);
    CHECK(kept[0] == 2);
    CHECK(std::isnan(kept[1]));
    CHECK(kept[2] == 6);
    check_error(taking(text, 1, Missing::refused), Code::value_missing, "line 3, b");
    CHECK(error_of([&] { CsvTable(text, "t.csv").numbers(1); }).remedy() == remedy_for_missing);
    CHECK(CsvTable(text, "t.csv").numbers(0) == std::vector<double>{1, 3, 5});  // of no concern to another column
  }
  for (const std::string cell : {"inf", "-inf", "1e999", "1.5.2", "x"}) {
    CAPTURE(cell);
    check_error(taking("a,b\n1,2\n3," + cell + "\n", 1, Missing::kept), Code::value_invalid, "line 3, b");
  }
}

TEST_CASE("csv: text that is not a table is refused with its line") {
  check_error(making(""), Code::file_empty, "t.csv");
  check_error(making("# c\n\n"), Code::file_empty);
  check_error(making("a,b\n"), Code::file_empty);
  check_error(making("a,b\ns,deg\n"), Code::file_empty);
  check_error(making(std::string("a\0b", 3)), Code::file_unsupported, "UTF-8");
  check_error(making("a,b\n1,2\n# c\n3,4,5\n"), Code::table_unclear, "line 4");
  check_error(making("a,b\n1,2\n3\n"), Code::table_unclear, "line 3");
  // The first lines decide what separates.
  check_error(making("Subject: 7\nRate: 100\nPlace: lab\ntime,sway_deg\n0,1\n"), Code::table_unclear, "line 4");
  check_error(making("a;b\n1;2\n3\n"), Code::table_unclear);
  check_error(making("a\tb\n1\t2\n3\n"), Code::table_unclear);
  check_error(making("1,2\n3,4,,\n"), Code::table_unclear, "line 2");
  const auto wide = [](int columns) {
    std::string line = "1";
    for (int c = 1; c < columns; ++c) line += ",1";
    return line + "\n";
  };
  CHECK(CsvTable(wide(1000), "t.csv").columns() == 1000);
  check_error(making(wide(1001)), Code::file_too_large, "1001 columns");
  check_error(making("a,b\n1,2\n" + wide(100'000)), Code::file_too_large, "line 3");
}

TEST_CASE("csv: a truncated last line is left out with a note") {
  const std::string three = "a,b,c\n1,2,0.10\n3,4,0.20\n5,6,0.30\n";
  std::string twenty = "a,b,c\n";
  for (int i = 0; i < 20; ++i) twenty += "5,6,0.30\n";
  const auto check_cut = [](const std::string& above, const std::string& cut, std::size_t rows) {
    CAPTURE(cut);
    const CsvTable table(above + cut, "t.csv");
    CHECK(table.rows(0) == rows);
    CHECK(table.cut_line() == rows + 2);
    REQUIRE(table.warnings().size() == 1);
    CHECK(table.warnings().front().code == "last_line_cut");
    CHECK(table.warnings().front().severity == Severity::info);
    CHECK(contains(table.warnings().front().text, "line " + std::to_string(rows + 2)));
    CHECK(table.numbers(2).size() == rows);
    CHECK(table.numbers(2).back() == 0.3);
    check_error([&] { require_whole(table, "t.csv"); }, Code::file_damaged, "line " + std::to_string(rows + 2));
  };
  for (const char* cut : {"7", "7,", "7,8", "7,8,", "7,8,-", "7,8,0.4x"}) {
    check_cut(three, cut, 3);
    check_cut(twenty, cut, 20);
  }
  // Fewer decimals: programs write the same number in all rows, people do not.
  for (const char* shorter : {"7,8,0", "7,8,0.", "7,8,0.4"}) {
    check_cut(twenty, shorter, 20);
    const CsvTable typed(three + shorter, "t.csv");
    CHECK(typed.rows(0) == 4);
    CHECK(typed.cut_line() == 0);
    CHECK(typed.warnings().empty());
    require_whole(typed, "t.csv");
  }
  // Whole lines without a line end, and numbers of any length.
  for (const std::string& whole : {three + "7,8,NaN", three + "7,8,0.40", three + "7,8,0.45", three + "7,8,12.00",
                                   std::string("a,b\n1,0.1\n2,0.25\n3,0.3\n4,0")}) {
    CAPTURE(whole);
    const CsvTable table(whole, "t.csv");
    CHECK(table.rows(0) == 4);
    CHECK(table.warnings().empty());
  }
  // A line end says that the line was written to its end.
  check_error(making(three + "7,8\n"), Code::table_unclear, "line 5");
  check_error(making(three + "x,8"), Code::table_unclear, "line 5");
}
