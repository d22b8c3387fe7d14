// Which instruction set runs: the fastest that this program was built with and that the processor and the operating
// system support, or the one that the environment variable DECID_ISA names. The bits of results do not depend on it.
#pragma once

#include <string>
#include <vector>

namespace decid {

/// reference: plain definitions, to hold the others to. baseline: what every x86-64 processor has (SSE2).
/// wasm: WebAssembly's vectors, which have no fused multiply-add: it is computed exactly. relaxed: WebAssembly with
/// relaxed vectors, whose multiply-add is one rounding here.
enum class Isa { reference, baseline, avx2, avx512, neon, wasm, relaxed };
const char* name(Isa isa) noexcept;

/// What can run here, slowest first.
std::vector<Isa> available_isas();
/// The one that is used; looked up once. Throws Error if DECID_ISA names none that can run here.
Isa chosen_isa();
/// Throws Error, naming `where`, if there is no such instruction set or it cannot run here.
Isa isa_from_name(const std::string& where, const std::string& name);

/// Does the processor compute 512-bit registers as two halves, one after the other (AMD's Zen 4)? Then caches have
/// twice the time for each. Only speed depends on it.
bool halves_512_bits() noexcept;

}  // namespace decid
