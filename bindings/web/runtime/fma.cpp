// fma() of a double, which the linker puts before the C library's (--wrap): that works on integers, this on relaxed
// vectors where these round once, else on base/math/exact_fma.hpp. All have the same bits.
#include "base/math/exact_fma.hpp"
#include "base/math/relaxed.hpp"

extern "C" {
double __real_fma(double a, double b, double c);
double __wrap_fma(double a, double b, double c);
float __wrap_fmaf(float a, float b, float c);
}

namespace decid {

double slow_fma(double a, double b, double c) {
  // To a zero the C library adds the product as it is rounded, which loses the sign of one that underflows.
  return c == 0.0 && a != 0.0 && b != 0.0 ? a * b : __real_fma(a, b, c);
}

}  // namespace decid

double __wrap_fma(double a, double b, double c) {
  if (decid::relaxed_fuses()) return decid::relaxed_fma(a, b, c);
  return decid::exact_fma(decid::ExactLanes{a, a}, decid::ExactLanes{b, b}, decid::ExactLanes{c, c})[0];
}

float __wrap_fmaf(float a, float b, float c) {
  const double product = static_cast<double>(a) * static_cast<double>(b);
  return static_cast<float>(decid::sum_to_odd(decid::ExactLanes{product, product}, decid::ExactLanes{c, c})[0]);
}
