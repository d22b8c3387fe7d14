// Encodings of text files: the same text whatever its bytes, and blanks of other kinds.
#include "recording/formats/encoding.hpp"

#include <string>

#include "recording/formats/csv.hpp"
#include "recording/table/cells.hpp"
#include "tests/helpers.hpp"
#include "tests/recording/table/reading.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

/// ASCII in UTF-16, little or big endian, without a mark.
std::string utf16(const std::string& text, bool little_endian) {
  std::string wide;
  for (const char c : text) {
    if (!little_endian) wide += '\0';
    wide += c;
    if (little_endian) wide += '\0';
  }
  return wide;
}

}  // namespace

TEST_CASE("text in UTF-8, UTF-16 and Windows-1252 is the same text") {
  const std::string text = "time,sway (\xC2\xB0)\n0,1\n";
  CHECK(to_utf8(text, "t") == text);
  CHECK(to_utf8("\xEF\xBB\xBF" + text, "t") == text);
  CHECK(to_utf8("time,sway (\xB0)\n0,1\n", "t") == text);
  const std::string ascii = "time,sway\n0,1\n";
  CHECK(to_utf8(utf16(ascii, true), "t") == ascii);
  CHECK(to_utf8(utf16(ascii, false), "t") == ascii);
  CHECK(to_utf8("\xFF\xFE" + utf16(ascii, true), "t") == ascii);
  CHECK(to_utf8("\xFE\xFF" + utf16(ascii, false), "t") == ascii);
  // A degree sign, a euro sign, and a pair of surrogates (U+1D11E), by their code points.
  CHECK(to_utf8(std::string("\xFF\xFE\xB0\x00\xAC\x20\x34\xD8\x1E\xDD", 10), "t") ==
        "\xC2\xB0\xE2\x82\xAC\xF0\x9D\x84\x9E");
  CHECK(to_utf8(std::string("\xFF\xFE\x34\xD8\x41\x00", 6), "t") ==
        "\xEF\xBF\xBD"
        "A");  // half of a pair
  CHECK(to_utf8("\x80 \x9F \xFF", "t") == "\xE2\x82\xAC \xC5\xB8 \xC3\xBF");
  // Surrogates, code points beyond U+10FFFF, and more bytes than needed are not UTF-8.
  CHECK(to_utf8("\xED\xA0\x80", "t") == "\u00ED\u00A0\u20AC");
  CHECK(to_utf8("\xF4\x90\x80\x80", "t") == "\u00F4\u0090\u20AC\u20AC");
  CHECK(to_utf8("\xE0\x81\x81", "t") == "\u00E0\u0081\u0081");
  CHECK(to_utf8("\xED\x9F\xBF \xF4\x8F\xBF\xBF", "t") == "\xED\x9F\xBF \xF4\x8F\xBF\xBF");
  CHECK(to_utf8("\xC3\xB6\xF6", "t") == "\xC3\x83\xC2\xB6\xC3\xB6");  // not all of it is UTF-8: none is
  check_error([] { to_utf8(std::string("ab\0cd\0\0\0efgh", 12), "t.csv"); }, Code::file_unsupported, "t.csv");
  check_one_two_three("\xFF\xFE" + utf16("time;sway_deg\r\n0;1\r\n0,01;2\r\n0,02;3\r\n", true));
  check_one_two_three("Zeit [s];sway [\xB0]\n0;1\n0,01;2\n0,02;3\n");
}

TEST_CASE("Unicode's minus signs are hyphens") {
  CHECK(with_plain_minus("\u22121,2;\u2212\u22123\u2212") == "-1,2;--3-");
  CHECK(with_plain_minus("1-2 \u2211") == "1-2 \u2211");
}

TEST_CASE("no-break blanks are blanks, and characters of no width are nothing") {
  CHECK(with_plain_blanks("a\u00A0b\u202Fc\u2009d") == "a b c d");
  CHECK(with_plain_blanks("\uFEFFa\u200Bb\u2060") == "ab");
  CHECK(trim_all("\u200B\u2009 a\u00A0b \u2007\t\uFEFF") == "a\u00A0b");
  CHECK(with_plain_blanks("1\u00A0000 \u00B0 1\u202F0000 \u00E4\u00A0") == "1000 \u00B0 1 0000 \u00E4 ");
  const std::string rows = "0,1\n0.01,2\n0.02,3\n";
  check_one_two_three("time\u00A0(s),sway\u202F[deg]\n" + rows);
  check_one_two_three("\xEF\xBB\xBF\xEF\xBB\xBFtime,sway_deg\n" + rows);
  check_one_two_three("time,sway_deg\n\u00A00,1\u00A0\n0.01,\u200B2\n0.02,3\n");
  check_one_two_three("time,KSP\u00A0(deg)\n" + rows, {.column = "KSP\u00A0(deg)"});
  check_one_two_three("Zeit [s];sway\xA0[\xB0]\n0;1\n0,01;2\xA0\n0,02;3\n");  // Windows-1252
  CHECK(CsvTable("x;y\n1\u00A0000,5;2\n1\u202F001,5;2\n", "t").numbers(0) == std::vector<double>{1000.5, 1001.5});
}
