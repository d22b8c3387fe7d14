// A zip archive of stored members, written in one pass with constant memory. Private to the writers of .npz files.
// Format: PKWARE's APPNOTE 6.3.10, sections 4.3 (records) and 4.5.3 (ZIP64: sizes and offsets of 4 GiB and more).
// Contents start at multiples of 64 bytes of the file, so that arrays in them may be mapped. The padding is an extra
// field of type 0xD935, as in Android's zipalign.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "base/files/disk_file.hpp"

namespace decid::dataset {

/// Returns the CRC-32 of bytes, as zip defines it.
std::uint32_t crc32(std::span<const std::byte> bytes);
/// Returns the CRC-32 of a followed by b, from the CRC-32 of each and b's length.
std::uint32_t crc32_joined(std::uint32_t a, std::uint32_t b, std::uint64_t b_bytes);
/// Returns the CRC-32 of the pieces in order.
std::uint32_t crc32(std::span<const std::span<const std::byte>> pieces);

struct ZipMember {
  std::string name;          ///< ASCII
  std::uint64_t bytes = 0;   ///< of its content
  std::uint64_t offset = 0;  ///< of its local header, which precedes the content
  std::uint32_t crc32 = 0;
};

/// Returns the bytes before a member's content. Their number depends only on name, bytes and offset.
std::string zip_local_header(const ZipMember& member);
/// Returns the bytes after the last member, at `offset`.
std::string zip_directory(std::span<const ZipMember> members, std::uint64_t offset);

/// Writes members in order, from the start of the file. For each: begin, then exactly `bytes` bytes by write and skip,
/// then end. The file is an archive only after finish().
class ZipWriter {
 public:
  explicit ZipWriter(DiskFile& file) : file_(file) {}

  void begin(const std::string& name, std::uint64_t bytes);
  void write(std::span<const std::byte> bytes) { write(std::span<const std::span<const std::byte>>(&bytes, 1)); }
  /// Writes the pieces in order; returns their CRC-32.
  std::uint32_t write(std::span<const std::span<const std::byte>> pieces);
  /// Skips bytes that an earlier run wrote.
  void skip(std::uint64_t bytes, std::uint32_t crc32);
  void end();
  /// Writes the directory and ends the file there.
  void finish();

  /// Returns the position of the next byte.
  std::uint64_t position() const noexcept { return position_; }

 private:
  DiskFile& file_;
  std::vector<ZipMember> members_;
  std::uint64_t position_ = 0, end_ = 0;
};

}  // namespace decid::dataset
