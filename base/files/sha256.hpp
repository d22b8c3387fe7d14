// SHA-256 (FIPS 180-4), for naming weights and data sets by their content.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace decid {

/// Feed any number of pieces, then read the digest once.
class Sha256 {
 public:
  Sha256() noexcept;
  void update(const void* data, std::size_t bytes) noexcept;
  /// 64 hexadecimal digits. The object cannot be fed afterwards.
  std::string hex();

 private:
  std::array<std::uint32_t, 8> state_;
  std::array<std::uint8_t, 64> buffer_{};
  std::uint64_t length_ = 0;
};

std::string sha256(std::string_view content);

}  // namespace decid
