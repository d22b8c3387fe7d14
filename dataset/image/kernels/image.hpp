// The kernels of images, one table an instruction set. All compute the same bits.
// Eight windows are drawn at once, one a lane, wherever they are; the layout is that of RealFft::forward_lanes.
#pragma once

#include "base/isa.hpp"
#include "dataset/image/channel.hpp"

namespace decid::dataset {

inline constexpr int image_lanes = 8;

/// Where a channel of eight windows goes.
struct DrawRequest {
  Channel channel;
  int bins;                ///< of the spectra, as far as they are shown
  int window;              ///< samples: bin k also stands for row window - k
  int rows, columns;       ///< of the image
  int lanes;               ///< windows that are there, 1 .. image_lanes
  const double* mean;      ///< complex, of each bin
  const double* residual;  ///< real, of each bin
  float* const* planes;    ///< row 0 of the channel at each window's column, of the lanes that are there
};

struct ImageKernels {
  /// signal[n * image_lanes + l] = windows[l][n] for the lanes that are there, 0 for the others.
  void (*load_windows)(const float* const* windows, int window, int lanes, double* signal);
  /// mean and residual of the first `used` values of `fold` spectra of `bins`, one behind the other; see
  /// ImageSettings::fold.
  void (*fold_spectra)(int fold, int bins, int used, const double* spectra, double* mean, double* residual);
  void (*draw)(const DrawRequest& request);
  /// shown[i] = asinh(values[i] / knee); count: a multiple of image_lanes.
  void (*asinh)(int count, const double* values, double knee, float* shown);
};

const ImageKernels& image_kernels(Isa isa);

/// For table_of.
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
