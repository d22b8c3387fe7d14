// Tests whether the multiply-add of WebAssembly's relaxed vectors rounds once on this machine: the standard leaves it
// open.
#pragma once

namespace decid {

/// Returns true if relaxed vectors are compiled in (bindings/web/CMakeLists.txt) and round once, tested with operands
/// whose fused and unfused results differ.
bool relaxed_fuses();

/// Returns a b + c by relaxed vectors, on a machine where they round once.
double relaxed_fma(double a, double b, double c);

}  // namespace decid
