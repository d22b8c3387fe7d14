// Selects a component's table for an instruction set. Not installed.
#pragma once

#include "base/isa.hpp"

namespace decid {

/// Returns a table. Tables has a static function reference(), and one for each instruction set of this processor's
/// family, each defined by the folder's kernels/target.cpp, compiled for it: baseline(), avx2() and avx512(), or
/// neon(), or wasm() and relaxed().
template <class Tables>
const auto& table_for(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::baseline:
      return Tables::baseline();
    case Isa::avx2:
      return Tables::avx2();
    case Isa::avx512:
      return Tables::avx512();
#elif defined(__aarch64__)
    case Isa::neon:
      return Tables::neon();
#elif defined(__wasm__)
    case Isa::wasm:
      return Tables::wasm();
    case Isa::relaxed:
      return Tables::relaxed();
#endif
    default:
      return Tables::reference();
  }
}

}  // namespace decid
