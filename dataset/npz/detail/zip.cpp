// Zip archives: see zip.hpp for the format.
#include "dataset/npz/detail/zip.hpp"

#include <zlib.h>

#include <stdexcept>

namespace decid::dataset {
namespace {

constexpr std::uint64_t alignment = 64;
/// This value in a field of 32 bits refers to the ZIP64 extra field.
constexpr std::uint32_t in_zip64 = 0xffffffff;
constexpr std::uint16_t plain_version = 20, zip64_version = 45;
/// 1 January 1980, the format's earliest date: equal data sets are equal files.
constexpr std::uint16_t midnight = 0, first_day = (1 << 5) | 1;

/// Numbers in the format's form: little endian, one after the other.
class Fields {
 public:
  Fields& u16(std::uint64_t value) { return number(value, 2); }
  Fields& u32(std::uint64_t value) { return number(value, 4); }
  Fields& u64(std::uint64_t value) { return number(value, 8); }
  /// Writes u32, or the mark if the value is in the ZIP64 field.
  Fields& u32_or_mark(std::uint64_t value) { return u32(value < in_zip64 ? value : in_zip64); }
  Fields& text(const std::string& value) {
    bytes_ += value;
    return *this;
  }
  std::size_t size() const { return bytes_.size(); }
  const std::string& str() const { return bytes_; }

 private:
  Fields& number(std::uint64_t value, int bytes) {
    for (int i = 0; i < bytes; ++i) bytes_ += static_cast<char>(value >> (8 * i) & 0xff);
    return *this;
  }
  std::string bytes_;
};

bool is_large(std::uint64_t value) {
  return value >= in_zip64;
}

/// Writes the common fields of local header and directory: version, flags, method, time, date, CRC and sizes.
Fields& common(Fields& fields, const ZipMember& member, bool zip64) {
  return fields.u16(zip64 ? zip64_version : plain_version)
      .u16(0)
      .u16(0)
      .u16(midnight)
      .u16(first_day)
      .u32(member.crc32)
      .u32_or_mark(member.bytes)
      .u32_or_mark(member.bytes);
}

}  // namespace

std::uint32_t crc32(std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(::crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::uint32_t crc32_joined(std::uint32_t a, std::uint32_t b, std::uint64_t b_bytes) {
  static_assert(sizeof(z_off_t) == 8 || sizeof(void*) == 4, "lengths beyond 2 GiB");
  return static_cast<std::uint32_t>(::crc32_combine(a, b, static_cast<z_off_t>(b_bytes)));
}

std::uint32_t crc32(std::span<const std::span<const std::byte>> pieces) {
  uLong sum = 0;
  for (const auto& piece : pieces) {
    // zlib treats a null pointer, which an empty piece may have, as a request to start again.
    if (!piece.empty()) sum = ::crc32_z(sum, reinterpret_cast<const Bytef*>(piece.data()), piece.size());
  }
  return static_cast<std::uint32_t>(sum);
}

std::string zip_local_header(const ZipMember& member) {
  Fields extra;
  if (is_large(member.bytes)) extra.u16(0x0001).u16(16).u64(member.bytes).u64(member.bytes);
  // Type, length, alignment, then zeros up to the content.
  const std::uint64_t unpadded = member.offset + 30 + member.name.size() + extra.size() + 6;
  const std::uint64_t zeros = (alignment - unpadded % alignment) % alignment;
  extra.u16(0xd935).u16(2 + zeros).u16(alignment).text(std::string(static_cast<std::size_t>(zeros), '\0'));
  Fields header;
  common(header.u32(0x04034b50), member, is_large(member.bytes)).u16(member.name.size()).u16(extra.size());
  return header.text(member.name).text(extra.str()).str();
}

std::string zip_directory(std::span<const ZipMember> members, std::uint64_t offset) {
  Fields directory;
  for (const ZipMember& member : members) {
    Fields values;
    if (is_large(member.bytes)) values.u64(member.bytes).u64(member.bytes);
    if (is_large(member.offset)) values.u64(member.offset);
    Fields extra;
    if (values.size() > 0) extra.u16(0x0001).u16(values.size()).text(values.str());
    common(directory.u32(0x02014b50).u16(zip64_version), member, values.size() > 0);
    directory.u16(member.name.size()).u16(extra.size()).u16(0);  // no comment
    directory.u16(0).u16(0).u32(0).u32_or_mark(member.offset);   // first disk, no attributes
    directory.text(member.name).text(extra.str());
  }
  const std::uint64_t size = directory.size();
  if (is_large(offset)) {
    const std::uint64_t record = offset + size;
    directory.u32(0x06064b50).u64(44).u16(zip64_version).u16(zip64_version).u32(0).u32(0);
    directory.u64(members.size()).u64(members.size()).u64(size).u64(offset);
    directory.u32(0x07064b50).u32(0).u64(record).u32(1);
  }
  directory.u32(0x06054b50).u16(0).u16(0).u16(members.size()).u16(members.size());
  directory.u32(size).u32_or_mark(offset).u16(0);
  return directory.str();
}

void ZipWriter::begin(const std::string& name, std::uint64_t bytes) {
  if (position_ != end_) throw std::logic_error("zip: a member is not finished");
  members_.push_back({name, bytes, position_, 0});
  const std::string header = zip_local_header(members_.back());
  file_.write(position_, header);
  position_ += header.size();
  end_ = position_ + bytes;
}

std::uint32_t ZipWriter::write(std::span<const std::span<const std::byte>> pieces) {
  std::uint64_t bytes = 0;
  for (const auto& piece : pieces) bytes += piece.size();
  file_.write(position_, pieces);
  file_.start_writeback(position_, bytes);
  const std::uint32_t sum = crc32(pieces);
  skip(bytes, sum);
  return sum;
}

void ZipWriter::skip(std::uint64_t bytes, std::uint32_t crc32) {
  if (bytes > end_ - position_) throw std::logic_error("zip: a member is longer than announced");
  members_.back().crc32 = crc32_joined(members_.back().crc32, crc32, bytes);
  position_ += bytes;
}

void ZipWriter::end() {
  if (position_ != end_) throw std::logic_error("zip: a member is shorter than announced");
  file_.write(members_.back().offset, zip_local_header(members_.back()));
}

void ZipWriter::finish() {
  const std::string directory = zip_directory(members_, position_);
  file_.write(position_, directory);
  file_.truncate(position_ + directory.size());
}

}  // namespace decid::dataset
