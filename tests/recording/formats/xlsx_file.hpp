// Writes workbooks for tests: a sheet of rows in an archive.
#pragma once

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

namespace decid::test {

/// A zip archive of these members, stored or deflated.
inline std::string zip(const std::map<std::string, std::string>& members, bool deflated = false) {
  const auto number = [](std::size_t value, int bytes) {
    std::string raw;
    for (int k = 0; k < bytes; ++k) raw += static_cast<char>(value >> (8 * k) & 0xFFU);
    return raw;
  };
  std::string archive, directory;
  for (const auto& [name, content] : members) {
    std::string packed = content;
    if (deflated) {
      z_stream stream{};
      deflateInit2(&stream, 6, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
      packed.resize(deflateBound(&stream, static_cast<uLong>(content.size())));
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(content.data()));
      stream.avail_in = static_cast<uInt>(content.size());
      stream.next_out = reinterpret_cast<Bytef*>(packed.data());
      stream.avail_out = static_cast<uInt>(packed.size());
      deflate(&stream, Z_FINISH);
      packed.resize(stream.total_out);
      deflateEnd(&stream);
    }
    const std::size_t sum = crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size());
    // From the version that is needed to the length of the name.
    const std::string common = number(20, 2) + number(0, 2) + number(deflated ? 8 : 0, 2) + number(0, 4) +
                               number(sum, 4) + number(packed.size(), 4) + number(content.size(), 4) +
                               number(name.size(), 2);
    directory += "PK\x01\x02" + number(20, 2) + common + std::string(12, '\0') + number(archive.size(), 4) + name;
    archive += "PK\x03\x04" + common + number(0, 2) + name + packed;
  }
  return archive + directory + "PK\x05\x06" + number(0, 4) + number(members.size(), 2) + number(members.size(), 2) +
         number(directory.size(), 4) + number(archive.size(), 4) + number(0, 2);
}

/// The parts of a workbook whose only sheet has these rows, with these shared strings.
inline std::map<std::string, std::string> workbook_parts(const std::string& rows, const std::string& shared = "") {
  return {{"xl/workbook.xml",
           R"(<?xml version="1.0"?><workbook><sheets><sheet name="one" r:id="r1"/></sheets></workbook>)"},
          {"xl/_rels/workbook.xml.rels",
           R"(<Relationships><Relationship Id="r1" Target="worksheets/sheet1.xml" Type="x/worksheet"/>)"
           R"(<Relationship Id="r2" Target="/xl/texts.xml" Type="x/sharedStrings"/></Relationships>)"},
          {"xl/texts.xml", "<sst>" + shared + "</sst>"},
          {"xl/worksheets/sheet1.xml", "<worksheet><sheetData>" + rows + "</sheetData></worksheet>"}};
}

inline std::string workbook(const std::string& rows, const std::string& shared = "") {
  return zip(workbook_parts(rows, shared));
}

}  // namespace decid::test
