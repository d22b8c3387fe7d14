// Chooses the kernels at run time: the fastest set that the processor and the operating system support, or the one that
// DECID_ISA names.
#include <cstdlib>
#include <type_traits>

#include "base/error.hpp"
#include "nn/kernels/isa.hpp"

namespace decid::nn {
namespace {

/// One set of kernels this program was built with.
struct Candidate {
  const char* name;
  bool (*runs_here)();
  const Kernels<float>& (*table)();
};

bool always() {
  return true;
}

#if defined(__x86_64__)
// __builtin_cpu_supports also asks whether the operating system saves the wide registers (XGETBV).
bool has_avx2() {
  __builtin_cpu_init();
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}
bool has_avx512() {
  __builtin_cpu_init();
  return has_avx2() && __builtin_cpu_supports("avx512f");
}
#endif

/// Slowest first.
constexpr Candidate candidates[] = {
    {"reference", always, reference_kernels<float>},
#if defined(__x86_64__)
    {"baseline", always, baseline_kernels},
    {"avx2", has_avx2, avx2_kernels},
    {"avx512", has_avx512, avx512_kernels},
#elif defined(__aarch64__)
    {"neon", always, neon_kernels},
#endif
};

/// All that DECID_ISA may say on some machine.
constexpr const char* known_names[] = {"reference", "baseline", "avx2", "avx512", "neon"};

const Kernels<float>& choose(const std::string& where, const std::string& name) {
  for (const Candidate& c : candidates)
    if (name == c.name && c.runs_here()) return c.table();
  bool known = false;
  for (const char* n : known_names) known = known || name == n;
  std::string available;
  for (const std::string& n : available_kernels()) available += (available.empty() ? "" : ", ") + n;
  throw Error(where, "instruction set '" + name + "' " + (known ? "cannot run on this machine" : "is unknown"),
              "use one of " + available);
}

const Kernels<float>& choose_from_environment() {
  const char* name = std::getenv("DECID_ISA");
  if (name != nullptr && *name != '\0') return choose("DECID_ISA", name);
  return choose("DECID_ISA", available_kernels().back());
}

}  // namespace

template <class T>
const Kernels<T>& kernels() {
  if constexpr (std::is_same_v<T, float>) {
    static const Kernels<float>& chosen = choose_from_environment();
    return chosen;
  } else {
    return reference_kernels<T>();
  }
}

template const Kernels<float>& kernels();
template const Kernels<double>& kernels();

std::vector<std::string> available_kernels() {
  std::vector<std::string> names;
  for (const Candidate& c : candidates)
    if (c.runs_here()) names.emplace_back(c.name);
  return names;
}

const Kernels<float>& kernels_named(const std::string& name) {
  return choose("kernels_named", name);
}

}  // namespace decid::nn
