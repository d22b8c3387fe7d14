// SHA-256: see sha256.hpp.
// Definition: FIPS 180-4, sections 5.1.1 (padding) and 6.2; the compression of blocks is in sha256_blocks.cpp.
// A partial block waits in the buffer.
#include "base/files/sha256.hpp"

#include <algorithm>
#include <cstring>

#include "base/files/detail/sha256_blocks.hpp"

namespace decid {
namespace {

Sha256Blocks chosen_blocks() noexcept {
  static const Sha256Blocks chosen = sha256_blocks_x86() != nullptr ? sha256_blocks_x86() : sha256_blocks_plain;
  return chosen;
}

}  // namespace

// The first 32 bits of the fractional parts of the square roots of the first 8 primes.
Sha256::Sha256() noexcept
    : state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19} {}

void Sha256::update(const void* data, std::size_t bytes) noexcept {
  if (bytes == 0) return;
  const auto* next = static_cast<const std::uint8_t*>(data);
  const auto filled = static_cast<std::size_t>(length_ % 64);
  length_ += bytes;
  if (filled > 0) {
    const std::size_t taken = std::min(bytes, 64 - filled);
    std::memcpy(buffer_.data() + filled, next, taken);
    next += taken;
    bytes -= taken;
    if (filled + taken < 64) return;
    chosen_blocks()(state_, buffer_.data(), 1);
  }
  const std::size_t whole = bytes / 64;
  chosen_blocks()(state_, next, whole);
  std::memcpy(buffer_.data(), next + 64 * whole, bytes % 64);
}

std::string Sha256::hex() {
  const std::uint64_t bits = length_ * 8;
  constexpr std::array<std::uint8_t, 64> padding{0x80};
  const auto filled = static_cast<std::size_t>(length_ % 64);
  update(padding.data(), filled < 56 ? 56 - filled : 120 - filled);
  std::array<std::uint8_t, 8> length;
  for (std::size_t i = 0; i < 8; ++i) length[i] = static_cast<std::uint8_t>(bits >> (56 - 8 * i));
  update(length.data(), length.size());

  std::string text;
  for (const std::uint32_t word : state_) {
    for (int shift = 28; shift >= 0; shift -= 4) text += "0123456789abcdef"[word >> shift & 15];
  }
  return text;
}

std::string sha256(std::string_view content) {
  Sha256 hash;
  hash.update(content.data(), content.size());
  return hash.hex();
}

}  // namespace decid
