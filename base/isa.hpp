// Choice of the instruction set: the fastest that this program was built with and that the processor and the operating
// system support, or the one in the environment variable DECID_ISA. The bits of results do not depend on it.
#pragma once

#include <string>
#include <vector>

namespace decid {

/// reference: plain definitions, against which the others are tested. baseline: common to all x86-64 processors (SSE2).
/// wasm: WebAssembly's vectors, which lack a fused multiply-add; it is emulated exactly. relaxed: WebAssembly with
/// relaxed vectors, if their multiply-add rounds once.
enum class Isa { reference, baseline, avx2, avx512, neon, wasm, relaxed };
const char* name(Isa isa) noexcept;

/// Returns the instruction sets that can run here, slowest first.
std::vector<Isa> available_isas();
/// Returns the chosen instruction set; determined once. Throws Error if DECID_ISA names none that can run here.
Isa chosen_isa();
/// Returns an instruction set. Throws Error, naming `where`, if it is unknown or cannot run here.
Isa isa_from_name(const std::string& where, const std::string& name);

/// Returns true if the processor computes 512-bit registers as two consecutive halves (AMD's Zen 4). Caches then have
/// twice the time for each. Affects only speed.
bool halves_512_bits() noexcept;

}  // namespace decid
