// The kernels of images, one table per instruction set. All compute the same bits. They process eight windows in
// parallel, one per lane, at any addresses; the layout is that of RealFft::forward_lanes.
#pragma once

#include "base/isa.hpp"
#include "dataset/image/channel.hpp"

namespace decid::dataset {

inline constexpr int image_lanes = 8;

/// The destination of a channel of eight windows.
struct DrawRequest {
  Channel channel;
  int bins;                ///< of the spectra, as far as shown
  int window;              ///< samples: bin k also stands for row window - k
  int rows, columns;       ///< of the image
  int lanes;               ///< used windows, 1 .. image_lanes
  const double* mean;      ///< complex, per bin
  const double* residual;  ///< real, per bin
  float* const* planes;    ///< row 0 of the channel at each window's column, for the used lanes
};

struct ImageKernels {
  /// Computes signal[n * image_lanes + l] = windows[l][n] for the used lanes, 0 for the others.
  void (*load_windows)(const float* const* windows, int window, int lanes, double* signal);
  /// Computes mean and residual of the first `used` values of `fold` consecutive spectra of `bins`; see
  /// ImageSettings::fold.
  void (*average_cycles)(int fold, int bins, int used, const double* spectra, double* mean, double* residual);
  void (*draw)(const DrawRequest& request);
  /// Computes shown[i] = asinh(values[i] / knee); count: a multiple of image_lanes.
  void (*asinh)(int count, const double* values, double knee, float* shown);
};

const ImageKernels& image_kernels(Isa isa);

/// Gives table_for access to the tables.
struct ImageTables {
  static const ImageKernels& reference();
  static const ImageKernels& baseline();
  static const ImageKernels& avx2();
  static const ImageKernels& avx512();
  static const ImageKernels& neon();
  static const ImageKernels& wasm();
  static const ImageKernels& relaxed();
};

}  // namespace decid::dataset
