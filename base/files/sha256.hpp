// SHA-256 (FIPS 180-4), to identify weights and data sets by their content.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace decid {

/// Computes a digest: call update any number of times, then hex once.
class Sha256 {
 public:
  Sha256() noexcept;
  void update(const void* data, std::size_t bytes) noexcept;
  /// Returns 64 hexadecimal digits. The object must not be used afterwards.
  std::string hex();

 private:
  std::array<std::uint32_t, 8> state_;
  std::array<std::uint8_t, 64> buffer_{};
  std::uint64_t length_ = 0;
};

std::string sha256(std::string_view content);

}  // namespace decid
