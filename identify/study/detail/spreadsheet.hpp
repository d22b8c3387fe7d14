// Tables of text as spreadsheets save them: CSV (RFC 4180) between commas, semicolons or tabs, or a workbook. Not
// installed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace decid {

/// Reads the rows of a file as cells, without blanks around them. The file's lines count as rows; rows without any text
/// stay, so that messages can name lines. Reads UTF-8, UTF-16 and Windows-1252, Excel's line "sep=;" and, of a
/// workbook, the first sheet. A quote opens a quoted text only at the start of a cell. Throws Error for an unreadable
/// file, for more than 4 MiB, and, with the line, for a quote whose pair is missing or seems to be of another cell.
std::vector<std::vector<std::string>> read_spreadsheet(const std::filesystem::path& path);

}  // namespace decid
