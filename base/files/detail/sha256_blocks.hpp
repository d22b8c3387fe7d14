// The compression function of SHA-256 (FIPS 180-4, 6.2), by its definition and by the processor's own instructions. Not
// installed.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace decid {

/// The hash's eight words, a to h.
using Sha256State = std::array<std::uint32_t, 8>;

/// Processes `count` blocks of 64 bytes into the state.
using Sha256Blocks = void (*)(Sha256State& state, const std::uint8_t* blocks, std::size_t count);

void sha256_blocks_plain(Sha256State& state, const std::uint8_t* blocks, std::size_t count) noexcept;
/// Returns the version by the SHA extensions of x86-64, some ten times as fast; nullptr without them.
Sha256Blocks sha256_blocks_x86() noexcept;

}  // namespace decid
