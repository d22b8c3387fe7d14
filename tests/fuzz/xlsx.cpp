// Workbooks: archives as they are, and the input as the rows, the texts and the list of sheets of one, whose checksums
// are right.
#include "recording/formats/xlsx.hpp"

#include "recording/recording.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/recording/formats/xlsx_file.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile input("recording.xlsx");
  const std::string bytes(fuzz::to_text(data, size));
  const auto read = [](const std::string& archive) {
    fuzz::accepts([&] { REQUIRE_THAT(recording::read_xlsx(archive, "recording.xlsx").sheets.size() > 0); });
  };
  read(bytes);
  const std::string rows = test::workbook(bytes, "<si><t>a</t></si>");
  read(rows);
  read(test::workbook("<row><c t='s'><v>1</v></c></row>", bytes));
  std::map<std::string, std::string> parts = test::workbook_parts("<row><c><v>1</v></c></row>");
  parts["xl/workbook.xml"] = bytes;
  read(test::zip(parts));
  fuzz::accepts([&] { recording::read_recording(input.write(rows), {.rate_hz = 50.0}); });
  return 0;
}
