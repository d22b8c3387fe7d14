// Tables as workbooks: see table.hpp. libxlsxwriter's manual: https://libxlsxwriter.github.io
#ifdef DECID_XLSXWRITER_SONAME
#include <xlsxwriter.h>
#endif

#include <cmath>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/shared_library.hpp"
#include "base/text.hpp"
#include "tools/decid/results/table.hpp"

namespace decid::tools {
#ifdef DECID_XLSXWRITER_SONAME
namespace {

/// The functions of libxlsxwriter used here.
class Library {
  SharedLibrary library_{DECID_XLSXWRITER_SONAME, "workbooks (.xlsx)", "need libxlsxwriter",
                         "install Debian's libxlsxwriter4, or write CSV"};

 public:
  decltype(&::workbook_new) create = library_.find<decltype(create)>("workbook_new");
  decltype(&::workbook_add_worksheet) add_sheet = library_.find<decltype(add_sheet)>("workbook_add_worksheet");
  decltype(&::workbook_set_properties) set_properties =
      library_.find<decltype(set_properties)>("workbook_set_properties");
  decltype(&::worksheet_write_number) number = library_.find<decltype(number)>("worksheet_write_number");
  decltype(&::worksheet_write_string) text = library_.find<decltype(text)>("worksheet_write_string");
  decltype(&::worksheet_freeze_panes) freeze = library_.find<decltype(freeze)>("worksheet_freeze_panes");
  decltype(&::workbook_close) close = library_.find<decltype(close)>("workbook_close");
};

void write_cell(const Library& library, lxw_worksheet* sheet, std::size_t row, std::size_t column, const Cell& cell) {
  constexpr std::size_t max_text = 32'767;  // Excel's, in characters
  const auto r = static_cast<lxw_row_t>(row);
  const auto c = static_cast<lxw_col_t>(column);
  if (const double* const number = std::get_if<double>(&cell)) {
    if (std::isfinite(*number)) library.number(sheet, r, c, *number, nullptr);
  } else if (const std::string* const text = std::get_if<std::string>(&cell); text != nullptr && !text->empty()) {
    library.text(sheet, r, c, valid_utf8(text->substr(0, max_text)).c_str(), nullptr);
  }
}

}  // namespace

void write_xlsx(const std::filesystem::path& path, const ResultTable& table) {
  const Library library;
  PendingFile pending(path);
  lxw_workbook* const book = library.create(pending.path().c_str());
  if (book == nullptr) throw std::bad_alloc();
  lxw_doc_properties properties{};
  properties.created = 1'577'836'800;  // a fixed date, 2020-01-01: the same table makes the same bytes
  library.set_properties(book, &properties);
  lxw_worksheet* const sheet = library.add_sheet(book, "results");
  for (std::size_t c = 0; c < table.names.size(); ++c) write_cell(library, sheet, 0, c, table.names[c]);
  for (std::size_t r = 0; r < table.rows.size(); ++r)
    for (std::size_t c = 0; c < table.rows[r].size(); ++c) write_cell(library, sheet, r + 1, c, table.rows[r][c]);
  library.freeze(sheet, 1, 1);
  if (library.close(book) != LXW_NO_ERROR) throw WriteError(path.string(), "cannot be written", "is the disk full?");
  pending.commit();
}

#else

void write_xlsx(const std::filesystem::path& path, const ResultTable&) {
  throw Error(Code::not_supported, path.string(), "is a workbook, and this decid was built without libxlsxwriter",
              "write CSV, or build with Debian's libxlsxwriter-dev");
}

#endif

}  // namespace decid::tools
