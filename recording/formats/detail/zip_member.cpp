// Members of a zip archive: see zip_member.hpp. An archive may claim anything: every offset is checked against the
// bytes present, and memory grows only with decompressed data.
#include "recording/formats/detail/zip_member.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "recording/formats/detail/inflation.hpp"

namespace decid::recording {

namespace {

using namespace std::string_view_literals;

constexpr std::size_t end_bytes = 22, entry_bytes = 46, local_bytes = 30, max_comment_bytes = 65535;
constexpr std::size_t stored = 0, deflated = 8;

[[noreturn]] void refuse_archive(const std::string& where, const std::string& what) {
  throw Error(Code::file_damaged, where, "is a truncated or damaged workbook: " + what,
              "save it again, or save the sheet as CSV");
}

std::string inflate_raw(std::string_view packed, std::size_t max_bytes, const std::string& where) {
  Inflation inflation(packed, -MAX_WBITS);
  z_stream& stream = inflation.stream;
  std::string content;
  int status = Z_OK;
  while (status == Z_OK) {
    const std::size_t begin = content.size(), more = std::max<std::size_t>(std::size_t{1} << 16, begin / 2);
    content.resize(std::min(begin + more, max_bytes + 1));
    stream.next_out = reinterpret_cast<Bytef*>(content.data() + begin);
    stream.avail_out = static_cast<uInt>(content.size() - begin);
    status = inflate(&stream, Z_NO_FLUSH);
    content.resize(content.size() - stream.avail_out);
    if (content.size() > max_bytes) refuse_archive(where, "a part is larger than its stated size");
  }
  if (status != Z_STREAM_END) refuse_archive(where, "in its compressed data");
  return content;
}

}  // namespace

std::size_t ZipMembers::number(std::size_t at, std::size_t bytes) const {
  if (at > bytes_.size() || bytes > bytes_.size() - at) refuse_archive(where_, "its directory points beyond its end");
  std::size_t value = 0;
  for (std::size_t k = bytes; k-- > 0;) value = value * 256 + static_cast<unsigned char>(bytes_[at + k]);
  return value;
}

ZipMembers::ZipMembers(std::string_view bytes, const std::string& where) : bytes_(bytes), where_(where) {
  const std::size_t end = bytes.rfind("PK\x05\x06"sv);
  if (end == bytes.npos || bytes.size() - end > end_bytes + max_comment_bytes)
    refuse_archive(where, "its end is missing");
  const std::size_t count = number(end + 10, 2);
  std::size_t at = number(end + 16, 4);
  for (std::size_t i = 0; i < count; ++i) {
    if (number(at, 4) != 0x02014B50) refuse_archive(where, "its directory is missing");
    const Entry entry{number(at + 8, 2),  number(at + 10, 2), number(at + 16, 4),
                      number(at + 20, 4), number(at + 24, 4), number(at + 42, 4)};
    const std::size_t name = number(at + 28, 2), rest = number(at + 30, 2) + number(at + 32, 2);
    number(at + entry_bytes, name);
    entries_.emplace(bytes.substr(at + entry_bytes, name), entry);
    at += entry_bytes + name + rest;
  }
}

std::string ZipMembers::read(const std::string& name) {
  const auto found = entries_.find(name);
  if (found == entries_.end()) refuse_archive(where_, "it has no " + name);
  const Entry& entry = found->second;
  if ((entry.flags & 1U) != 0)
    throw Error(Code::file_unsupported, where_, "is protected by a password", "save the sheet as CSV");
  if (entry.method != stored && entry.method != deflated)
    throw Error(Code::file_unsupported, where_, "uses a compression that decid does not read", "save the sheet as CSV");
  if (number(entry.local, 4) != 0x04034B50) refuse_archive(where_, name + " is missing");
  const std::size_t begin = entry.local + local_bytes + number(entry.local + 26, 2) + number(entry.local + 28, 2);
  if (begin > bytes_.size() || entry.packed > bytes_.size() - begin) refuse_archive(where_, name + " is cut short");
  if (entry.size > left_)
    throw Error(Code::file_too_large, where_, "is larger than 128 MiB, decompressed", "save only one trial");
  const std::string_view packed = bytes_.substr(begin, entry.packed);
  std::string content = entry.method == stored ? std::string(packed) : inflate_raw(packed, entry.size, where_);
  if (content.size() != entry.size ||
      crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size()) != entry.crc)
    refuse_archive(where_, name + " fails its checksum");
  left_ -= content.size();
  return content;
}

}  // namespace decid::recording
