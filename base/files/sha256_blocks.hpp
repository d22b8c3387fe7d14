// The compression function of SHA-256 (FIPS 180-4, 6.2), as it is written there and by the processor's own
// instructions. Not installed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace decid {

/// The hash's eight words, a to h.
using Sha256State = std::array<std::uint32_t, 8>;

/// Takes `count` blocks of 64 bytes into the state.
using Sha256Blocks = void (*)(Sha256State& state, const std::uint8_t* blocks, std::size_t count);

void sha256_blocks_plain(Sha256State& state, const std::uint8_t* blocks, std::size_t count) noexcept;
/// By the SHA extensions of x86-64, some ten times as fast; nullptr where there are none.
Sha256Blocks sha256_blocks_x86() noexcept;

}  // namespace decid
