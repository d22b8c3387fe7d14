// Whether the multiply-add of WebAssembly's relaxed vectors is one rounding on this machine: the standard leaves it
// open.
#pragma once

namespace decid {

/// True where relaxed vectors are compiled in (bindings/web/CMakeLists.txt) and round once, asked of operands whose
/// fused and unfused results differ.
bool relaxed_fuses();

/// a b + c with them; for a machine where they round once.
double relaxed_fma(double a, double b, double c);

}  // namespace decid
