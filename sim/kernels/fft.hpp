// Arguments of the Fourier transform kernels: see generic_fft.hpp for the layout and the method.
#pragma once

#include <cstddef>

namespace decid::sim {

/// One pass over the data: `groups * stride` butterflies of `radix` points each.
struct FftPass {
  int radix;
  int groups;              ///< butterflies with different twiddles
  int stride;              ///< butterflies that share them
  const double* twiddles;  ///< complex, (radix - 1) * groups values
  const double* roots;     ///< complex, the `radix` roots of unity, for radices above 5
};

struct FftKernels {
  void (*pass)(const FftPass& pass, const double* in, double* out, double* fold);
  void (*join_halves)(int half, const double* roots, double* z);
  void (*split_halves)(int half, const double* roots, const double* spectrum, double* z);
  void (*reverse_and_scale)(int length, double factor, double* z);
  void (*turn)(int count, const double* in, const double* factors, double* out);
};

}  // namespace decid::sim
