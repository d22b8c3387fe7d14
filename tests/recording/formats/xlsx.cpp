// Workbooks: what office programs write, what cells may hold, and what an archive may claim.
#include "recording/formats/xlsx.hpp"

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/setting.hpp"
#include "base/text.hpp"
#include "recording/formats/csv.hpp"
#include "recording/formats/detail/xml_scanner.hpp"
#include "recording/formats/detail/zip_member.hpp"
#include "recording/recording.hpp"
#include "sim/protocol/protocol.hpp"
#include "tests/helpers.hpp"
#include "tests/recording/formats/xlsx_file.hpp"

using namespace decid;
using namespace decid::recording;
using namespace decid::test;

namespace {

const std::string where = "r.xlsx";

Recording read(const std::string& bytes, const RecordingOptions& options = {}) {
  const TemporaryFolder folder;
  return read_recording(write_text(folder / "r.xlsx", bytes), options);
}

std::string to_text(const std::string& rows, const std::string& shared = "") {
  return read_xlsx(workbook(rows, shared), where).text;
}

}  // namespace

TEST_CASE("a workbook of openpyxl is the recording of its CSV") {
  const std::filesystem::path path = std::filesystem::path(DECID_SOURCE_DIR) / "tests/recording/xlsx/openpyxl.xlsx";
  const Recording recording = read_recording(path, {.column = "sway", .fill_gaps_s = 0.02});
  CHECK(recording.rate_hz == 50.0);
  const std::vector<double>& sway = recording.signals.at(com_sway).rad;
  REQUIRE(sway.size() == 20);
  for (std::size_t k = 0; k < 20; ++k) CHECK(near(sway[k], static_cast<double>(k + 1) / 8.0 * sim::rad_per_deg, 1e-14));
  CHECK(has(recording.warnings, "sheet_assumed"));
  CHECK(has(recording.warnings, "gaps_filled"));
  check_error([&] { read_recording(path, {.column = "sway"}); }, Code::value_missing, "line 8");
}

TEST_CASE("XLSX: cells of every kind, where they say that they are") {
  CHECK(
      to_text(R"(<row><c><v>1.5E-3</v></c><c t="b"><v>1</v></c><c t="str"><f>A1&amp;"x"</f><v>a&lt;b</v></c></row>)") ==
      "1.5E-3\tTRUE\ta<b\n");
  CHECK(to_text(R"(<row><c><v>1</v></c><c t="b"/><c t="b"><v>0</v></c></row>)") == "1\t\tFALSE\n");
  CHECK(
      to_text(
          R"(<row r="2"><c r="B2" t="s"><v>1</v></c></row><row r="4"><c r="D4" t="e"><v>#N/A</v></c><c r="E4"/></row>)",
          "<si><t>no</t></si><si><r><t>a </t></r><r><t xml:space='preserve'>b</t></r><rPh><t>c</t></rPh></si>") ==
      "\n\ta b\n\n\n");
  CHECK(to_text(R"(<row><c t="inlineStr"><is><t>&#xB0;&#8364;&#x1F600;</t></is></c><c r="AB1"><v>2</v></c></row>)") ==
        "\xC2\xB0\xE2\x82\xAC\xF0\x9F\x98\x80" + std::string(27, '\t') + "2\n");
  CHECK(to_text("<row><c t='inlineStr'><is><t>a\tb\n\"c\"</t></is></c></row>") == "a b 'c'\n");
  CHECK(to_text("<!-- a > b --><row><c><v><![CDATA[7]]></v></c></row><?x y?>") == "7\n");
  CHECK(to_text(R"(<row><c r="A1"><v>1</v></c><c r="ALM1" s="3"/><c r="ALN1" s="3"/></row>)") == "1\n");
  CHECK(to_text("<row><c><v>1</v></c></row><row><c/><c><v>2</v></c></row>") == "1\t\n\t2\n");
}

TEST_CASE("XLSX: a formula without a stored value is an error, an empty text that a formula gives is empty") {
  for (const char* value : {"", "<v/>", "<v></v>"}) {
    CAPTURE(value);
    const std::string cell = R"(<c r="B2"><f>SUM(A1,A2)</f>)" + std::string(value) + "</c>";
    check_error([&] { to_text(R"(<row r="2">)" + cell + "</row>"); }, Code::value_missing, where);
  }
  CHECK(to_text(R"(<row><c><v>1</v></c><c t="str"><f>IF(A1,"","")</f><v></v></c></row>)") == "1\n");
  CHECK(to_text(R"(<row><c><f>SUM(A1)</f><v>3</v></c><c t="e"><f>1/0</f><v>#DIV/0!</v></c></row>)") == "3\n");
}

TEST_CASE("XLSX: the first row alone") {
  CHECK(read_first_row(workbook(R"(<row><c><v>1</v></c><c><v>2</v></c></row><row><c><v>3</v></c></row>)", ""), where) ==
        "1\t2\n");
  CHECK(read_first_row("time,sway\n", where).empty());
}

TEST_CASE("XLSX: cells that show dates, as days or as text") {
  // Styles: a number, a date that is built in, own formats of a date, a time and colours, and a date with a time.
  const std::string styles =
      R"(<styleSheet><numFmts><numFmt numFmtId="164" formatCode="[$-407]d\.\ mmmm\ yyyy"/>)"
      R"(<numFmt numFmtId="165" formatCode="[Red]0.0&quot; days&quot;"/><numFmt numFmtId="166" formatCode="hh:mm"/>)"
      R"(</numFmts><cellStyleXfs><xf numFmtId="14"/></cellStyleXfs><cellXfs><xf numFmtId="0"/><xf numFmtId="14"/>)"
      R"(<xf numFmtId="164"/><xf numFmtId="165"/><xf numFmtId="166"/><xf numFmtId="22"/></cellXfs>)"
      R"(<dxfs><xf numFmtId="14"/></dxfs></styleSheet>)";
  const auto cell = [](int style, const char* days) {
    return "<c s='" + std::to_string(style) + "'><v>" + days + "</v></c>";
  };
  std::map<std::string, std::string> parts =
      workbook_parts("<row>" + cell(0, "46086") + cell(1, "46086") + cell(2, "61") + cell(3, "46086") + cell(4, "0.5") +
                     "</row><row>" + cell(5, "46086.502129629627") + cell(1, "60") + cell(2, "36584.9999999") +
                     cell(9, "46086") + "<c s='1' t='str'><v>46086</v></c></row>");
  parts["xl/styles.xml"] = styles;
  parts["xl/_rels/workbook.xml.rels"] =
      R"(<Relationships><Relationship Id="r1" Target="worksheets/sheet1.xml" Type="x/worksheet"/>)"
      R"(<Relationship Id="r2" Target="styles.xml" Type="x/styles"/></Relationships>)";
  const auto text = [&](DateCells dates) { return read_xlsx(zip(parts), where, {}, dates).text; };
  CHECK(text(DateCells::text) ==
        "46086\t2026-03-05\t1900-03-01\t46086\t0.5\n2026-03-05T12:03:04\t60\t2000-02-29\t46086\t46086\n");
  CHECK(text(DateCells::days) == "46086\t46086\t61\t46086\t0.5\n46086.502129629627\t60\t36584.9999999\t46086\t46086\n");
  parts["xl/workbook.xml"] =
      R"(<workbook><workbookPr date1904="1"/><sheets><sheet name="one" r:id="r1"/></sheets></workbook>)";
  CHECK(text(DateCells::text).starts_with("46086\t2030-03-06\t1904-03-02\t"));
  parts["xl/styles.xml"] = "<styleSheet";
  check_error([&] { text(DateCells::text); }, Code::file_damaged, "r.xlsx");
}

TEST_CASE("XLSX: the first sheet that is not hidden, and the rules for text") {
  std::string rows =
      R"(<row r="1"><c t="inlineStr"><is><t>Ann</t></is></c></row>)"
      R"(<row r="3"><c t="inlineStr"><is><t>time</t></is></c><c t="inlineStr"><is><t>sway_deg</t></is></c></row>)";
  for (int k = 0; k < 5; ++k)
    rows += "<row><c><v>" + std::to_string(k) + "E-2</v></c><c><v>" + std::to_string(k) + "</v></c></row>";
  const Recording recording = read(workbook(rows));
  CHECK(recording.rate_hz == 100.0);
  CHECK(recording.signals.at(com_sway).rad[4] == 4.0 * sim::rad_per_deg);
  CHECK_FALSE(has(recording.warnings, "sheet_assumed"));
  std::map<std::string, std::string> parts = workbook_parts("<row><c><v>1</v></c></row>");
  parts["xl/workbook.xml"] =
      R"(<x:workbook><x:sheets><x:sheet name="a" state="hidden" r:id="none"/><x:sheet name="b &amp; c" r:id="r1"/></x:sheets></x:workbook>)";
  const Sheet sheet = read_xlsx(zip(parts), where);
  CHECK(sheet.sheets == std::vector<std::string>{"b & c"});
  CHECK(sheet.text == "1\n");
}

TEST_CASE("XLSX: --section names a sheet, or a table of the first one") {
  const auto rows = [](int sway) {
    std::string text =
        R"(<row><c t="inlineStr"><is><t>time</t></is></c><c t="inlineStr"><is><t>sway_deg</t></is></c></row>)";
    for (int k = 0; k < 5; ++k)
      text += "<row><c><v>" + std::to_string(k) + "E-2</v></c><c><v>" + std::to_string(sway * k) + "</v></c></row>";
    return text;
  };
  std::map<std::string, std::string> parts = workbook_parts(rows(1));
  parts["xl/workbook.xml"] =
      R"(<workbook><sheets><sheet name="one" r:id="r1"/><sheet name="Trial 7" r:id="r9"/></sheets></workbook>)";
  parts["xl/_rels/workbook.xml.rels"] =
      R"(<Relationships><Relationship Id="r1" Target="worksheets/sheet1.xml" Type="x/worksheet"/>)"
      R"(<Relationship Id="r9" Target="worksheets/sheet2.xml" Type="x/worksheet"/></Relationships>)";
  parts["xl/worksheets/sheet2.xml"] = "<worksheet><sheetData>" + rows(3) + "</sheetData></worksheet>";
  const std::string bytes = zip(parts);
  const auto last = [&](const std::string& section) {
    const Recording recording = read(bytes, {.section = section});
    return std::pair(recording.signals.at(com_sway).rad[4] / sim::rad_per_deg,
                     has(recording.warnings, "sheet_assumed"));
  };
  CHECK(last("trial 7") == std::pair(12.0, false));
  CHECK(last("one") == std::pair(4.0, false));
  CHECK(last("1") == std::pair(4.0, true));
  CHECK(last("") == std::pair(4.0, true));
  check_error([&] { read(bytes, {.section = "Trial 8"}); }, Code::setting_unknown, "'Trial 7'");
}

TEST_CASE("XLSX: true and false are words; a first sheet without a table names those that have one") {
  std::string rows =
      R"(<row><c t="inlineStr"><is><t>time</t></is></c><c t="inlineStr"><is><t>sway_deg</t></is></c></row>)";
  for (int k = 0; k < 5; ++k)
    rows += "<row><c><v>" + std::to_string(k) + "E-2</v></c><c" + (k == 3 ? " t='b'" : "") + "><v>1</v></c></row>";
  check_error([&] { read(workbook(rows)); }, Code::value_invalid, "line 5, sway_deg");
  std::map<std::string, std::string> parts =
      workbook_parts("<row><c t='inlineStr'><is><t>Measured by Ann</t></is></c></row>");
  parts["xl/workbook.xml"] = R"(<workbook><sheets><sheet name="Notes" r:id="r1"/><sheet name="Chart" r:id="r8"/>)"
                             R"(<sheet name="Trial 7" r:id="r9"/></sheets></workbook>)";
  parts["xl/_rels/workbook.xml.rels"] =
      R"(<Relationships><Relationship Id="r1" Target="worksheets/sheet1.xml" Type="x/worksheet"/>)"
      R"(<Relationship Id="r8" Target="none.xml" Type="x/chartsheet"/>)"
      R"(<Relationship Id="r9" Target="worksheets/sheet2.xml" Type="x/worksheet"/></Relationships>)";
  parts["xl/worksheets/sheet2.xml"] = "<worksheet><sheetData>" + rows + "</sheetData></worksheet>";
  check_error([&] { read(zip(parts)); }, Code::file_empty, "'Notes'");
}

namespace {

/// A sheet of rows of words, and 1, 2, 3 degrees below them.
std::string sheet_below(const std::vector<std::vector<std::string>>& header, double first_time = 0.0,
                        double step = 0.01) {
  std::string rows;
  for (const std::vector<std::string>& names : header) {
    rows += "<row>";
    for (const std::string& name : names) rows += "<c t='str'><v>" + name + "</v></c>";
    rows += "</row>";
  }
  for (int k = 0; k < 3; ++k)
    rows += format("<row><c><v>%.17g</v></c><c><v>%d</v></c></row>", first_time + k * step, k + 1);
  return workbook(rows);
}

}  // namespace

TEST_CASE("XLSX: a second header is refused with the option that reads it") {
  const std::string bytes = sheet_below({{"Zeit", "Schwankung"}, {"Time", "Sway"}});
  const Error error = error_of([&] { read(bytes); });
  CHECK(error.code() == Code::value_invalid);
  CHECK(contains(error.problem(), "line 2, Schwankung: 'Sway'"));
  CHECK(contains(error.remedy(), setting("skip_lines") + " 1 "));
  CHECK_FALSE(contains(error.remedy(), "#"));
  const Recording recording = read(bytes, {.skip_lines = 1});
  CHECK(recording.signals.at(com_sway).column == "Sway");
  CHECK(recording.signals.at(com_sway).rad.size() == 3);
  // Below them all; and a word elsewhere is a cell to correct.
  CHECK(contains(error_of([&] {
                   read(sheet_below({{"Zeit", "Sway"}, {"Time", "Sway"}, {"t", "COM"}}));
                 }).remedy(),
                 setting("skip_lines") + " 2 "));
  const auto text = [](const char* rows) { return [rows] { CsvTable(rows, "r.csv").numbers(1); }; };
  CHECK(contains(error_of(text("Zeit,Sway\nTime,COM\n0,1\n0.01,2\n")).remedy(), setting("skip_lines") + " 1 "));
  CHECK_FALSE(contains(error_of(text("Zeit,Sway\n0,1\n0.01,off\n")).remedy(), setting("skip_lines")));
}

TEST_CASE("XLSX: Unix times are in the unit that their size shows, as in CSV") {
  for (const double per_s : {1.0, 1e3, 1e6, 1e9}) {
    const Recording recording = read(sheet_below({{"timestamp", "sway_deg"}}, 1732876342.0 * per_s, 0.01 * per_s));
    CHECK(recording.rate_hz == 100.0);
  }
}

TEST_CASE("XLSX: stored and deflated archives, and bounds of their sizes") {
  const std::string rows = "<row><c><v>1</v></c><c><v>2</v></c></row>";
  const std::string bytes = workbook(rows);
  CHECK(read_xlsx(bytes, where).text == "1\t2\n");
  CHECK(read_xlsx(zip(workbook_parts(rows), true), where).text == "1\t2\n");
  for (std::size_t length = 0; length < bytes.size(); length += 7)
    check_error([&] { read_xlsx(bytes.substr(0, length), where); }, Code::file_damaged, "r.xlsx");
  // Data that differ from their checksum: another digit, and deflated, where a bit makes `=` of the sheet's first `<`.
  std::string wrong = bytes, flipped = zip(workbook_parts(rows), true);
  wrong[wrong.find("<v>1</v>") + 3] = '7';
  const std::string sheet = "xl/worksheets/sheet1.xml";
  flipped[flipped.find(sheet) + sheet.size() + 1] ^= 4;
  for (const std::string& damaged : {wrong, flipped})
    check_error([&] { read_xlsx(damaged, where); }, Code::file_damaged, sheet + " fails its checksum");
  const auto changed = [&](const std::function<void(std::map<std::string, std::string>&)>& change) {
    std::map<std::string, std::string> parts = workbook_parts(rows);
    change(parts);
    return [made = zip(parts)] { read_xlsx(made, where); };
  };
  for (const char* part : {"xl/workbook.xml", "xl/_rels/workbook.xml.rels", "xl/worksheets/sheet1.xml"})
    check_error(changed([&](auto& parts) { parts.erase(part); }), Code::file_damaged, part);
  check_error(changed([](auto& parts) { parts["xl/workbook.xml"] = "<workbook/>"; }), Code::file_damaged);
  check_error(changed([](auto& parts) { parts["xl/_rels/workbook.xml.rels"] = "<a/>"; }), Code::file_damaged);
  std::string locked = bytes;
  for (std::size_t at = 0; (at = locked.find("PK\x01\x02", at)) != locked.npos; ++at) locked[at + 8] = 1;
  check_error([&] { read_xlsx(locked, where); }, Code::file_unsupported);
  std::string packed = bytes;
  for (std::size_t at = 0; (at = packed.find("PK\x01\x02", at)) != packed.npos; ++at) packed[at + 10] = 12;
  check_error([&] { read_xlsx(packed, where); }, Code::file_unsupported);
}

TEST_CASE("XLSX: sheets that are out of order, too large or no XML") {
  const auto refused = [](const std::string& rows, Code code, const char* fact) {
    CAPTURE(rows);
    check_error([&] { to_text(rows); }, code, fact);
  };
  refused("<row r='2'/><row r='2'/>", Code::file_damaged, "rows are out of order");
  refused("<row r='9999999'/>", Code::file_damaged, "rows are out of order");
  refused("<c><v>1</v></c>", Code::file_damaged, "outside of all rows");
  refused("<row><c r='B1'><v>1</v></c><c r='A1'><v>1</v></c></row>", Code::file_damaged, "cells are out of order");
  refused("<row><c r='ALM1'><v>1</v></c></row>", Code::file_too_large, "more than 1000 columns");
  refused("<row><c r='ZZZZZZZZZZZZZZZZZZ1'><v>1</v></c></row>", Code::file_too_large, "more than 1000 columns");
  refused("<row><c t='s'><v>0</v></c></row>", Code::file_damaged, "text is missing");
  refused("<row><c t='s'><v>-1</v></c></row>", Code::file_damaged, "text is missing");
  refused("<row><c/></row>", Code::file_empty, "without cells");
  refused("", Code::file_empty, "without cells");
  refused("<!--", Code::file_damaged, "does not end");
  refused("<row><c><v>&amp</v></c></row>", Code::file_damaged, "entity does not end");
  refused("<!DOCTYPE a>", Code::file_damaged, "document type");
  // A text that many cells share.
  std::string many;
  for (int k = 0; k < 100; ++k) many += "<row><c t='s'><v>0</v></c></row>";
  check_error([&] { to_text(many, "<si><t>" + std::string(1'000'000, 'a') + "</t></si>"); }, Code::file_too_large,
              "64 MiB");
}
