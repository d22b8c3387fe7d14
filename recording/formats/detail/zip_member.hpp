// Reads members of a zip archive in memory, as office programs write them. Not installed.
// Format: PKWARE's APPNOTE 6.3.10, sections 4.3.6 to 4.3.16, without encryption and ZIP64.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>

namespace decid::recording {

class ZipMembers {
 public:
  /// Opens an archive from all of its bytes. These and `where`, which names the file, must outlive this object. Throws
  /// Error for a damaged directory.
  ZipMembers(std::string_view bytes, const std::string& where);

  /// Returns a member's content. Throws Error if the member is missing, damaged, encrypted or compressed otherwise than
  /// by deflate. Throws Error if the content read from this archive exceeds 128 MiB in total.
  std::string read(const std::string& name);

 private:
  struct Entry {
    std::size_t flags, method, crc, packed, size, local;
  };
  std::size_t number(std::size_t at, std::size_t bytes) const;

  std::string_view bytes_;
  const std::string& where_;
  std::map<std::string, Entry> entries_;
  std::size_t left_ = std::size_t{1} << 27;
};

}  // namespace decid::recording
