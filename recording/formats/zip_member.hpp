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
  /// `bytes`: the whole archive, which must outlive this as `where` must, which names it. Throws Error for a directory
  /// that is damaged.
  ZipMembers(std::string_view bytes, const std::string& where);

  /// A member's content. Throws Error if there is none of that name, it is damaged, encrypted or compressed in a way
  /// other than deflate, or if all that was read of this archive is more than 128 MiB.
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
