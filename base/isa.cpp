// Choice of the instruction set: see isa.hpp.
#include "base/isa.hpp"

#include <cstdlib>

#include "base/error.hpp"
#if defined(__x86_64__)
#include <cpuid.h>
#endif
#if defined(__wasm__)
#include "base/math/relaxed.hpp"
#endif

namespace decid {
namespace {

constexpr Isa all_isas[] = {Isa::reference, Isa::baseline, Isa::avx2, Isa::avx512, Isa::neon, Isa::wasm, Isa::relaxed};

bool runs_here(Isa isa) {
  switch (isa) {
    case Isa::reference:
#if defined(__x86_64__)
    case Isa::baseline:
      return true;
    // __builtin_cpu_supports also checks that the operating system saves the wide registers (XGETBV).
    case Isa::avx2:
      return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    case Isa::avx512:
      return runs_here(Isa::avx2) && __builtin_cpu_supports("avx512f");
#elif defined(__aarch64__)
    case Isa::neon:
      return true;
#elif defined(__wasm__)
    case Isa::wasm:
      return true;
    case Isa::relaxed:
      return relaxed_fuses();
#endif
    default:
      return false;
  }
}

}  // namespace

const char* name(Isa isa) noexcept {
  constexpr const char* names[] = {"reference", "baseline", "avx2", "avx512", "neon", "wasm", "relaxed"};
  return names[static_cast<int>(isa)];
}

std::vector<Isa> available_isas() {
#if defined(__x86_64__)
  __builtin_cpu_init();
#endif
  std::vector<Isa> available;
  for (const Isa isa : all_isas) {
    if (runs_here(isa)) available.push_back(isa);
  }
  return available;
}

Isa chosen_isa() {
  static const Isa chosen = [] {
    const char* wanted = std::getenv("DECID_ISA");
    if (wanted != nullptr && *wanted != '\0') return isa_from_name("DECID_ISA", wanted);
    return available_isas().back();
  }();
  return chosen;
}

bool halves_512_bits() noexcept {
#if defined(__x86_64__)
  static const bool halves = [] {
    unsigned eax = 0, ebx = 0, ecx = 0, edx = 0;
    if (__get_cpuid(0, &eax, &ebx, &ecx, &edx) == 0 || ebx != signature_AMD_ebx) return false;
    if (__get_cpuid(1, &eax, &ebx, &ecx, &edx) == 0) return false;
    const unsigned family = (eax >> 8 & 0xf) + (eax >> 20 & 0xff);
    return family == 0x19 && runs_here(Isa::avx512);  // Zen 3 and Zen 4, of which only Zen 4 has AVX-512
  }();
  return halves;
#else
  return false;
#endif
}

Isa isa_from_name(const std::string& where, const std::string& wanted) {
  std::string available;
  for (const Isa isa : available_isas()) {
    if (wanted == name(isa)) return isa;
    available += (available.empty() ? "" : ", ") + std::string(name(isa));
  }
  bool known = false;
  for (const Isa isa : all_isas) known = known || wanted == name(isa);
  throw Error(known ? Code::not_supported : Code::setting_unknown, where,
              "instruction set '" + wanted + "' " + (known ? "cannot run on this machine" : "is unknown"),
              "use one of " + available);
}

}  // namespace decid
