// Plan of a model in firmware: its layers in the order in which lines of the network input go through them, and the
// offset of each buffer in the arena. Weights are for inference, with BatchNorm folded into convolutions.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "identify/network/model.hpp"
#include "nn/inference.hpp"

namespace decid::tools {

/// The buffer between two layers; network_map in runtime/types.c has the same members.
struct FirmwareMap {
  nn::Shape shape;
  bool whole = false;  ///< all lines are kept, channel by channel as in an image; else the last `capacity` of them
  int lines = 0, positions = 0, capacity = 0;
  int line_stride = 0, channel_stride = 0, position_stride = 0;
  int offset = 0;               ///< in values
  float steps_per_unit = 1.0F;  ///< of 8-bit integers
  int zero = 0;

  long long values() const { return whole ? shape.size() : 1LL * capacity * shape.channels * positions; }
};

/// Rows and columns of a kernel, a stride or a pool.
struct Extent {
  int rows = 1, columns = 1;
};

struct FirmwareLayer {
  /// all: every value of the input, fully connected; statistics: means and deviations of the channels, a statspool; add
  /// and concat: the end of a block, which also reads the block's input.
  enum class Kind {
    convolution,
    all,
    max_pool,
    average_pool,
    statistics,
    leaky_relu,
    tanh,
    sigmoid,
    gelu,
    layer_norm,
    add,
    concat
  };
  Kind kind = Kind::convolution;
  int src = 0, dst = 0;     ///< maps
  int kept = 0;             ///< the map with the block's input
  bool normalises = false;  ///< a BatchNorm that is folded away follows, which makes -0 a 0
  bool rectifies = false;
  Extent kernel, stride, pad{0, 0};
  int dilation = 1;                ///< of the kernel's rows; its columns have zeros between their taps instead
  int groups = 1;                  ///< of channels
  float slope = 0.0F;              ///< of a leaky ReLU
  int taps = 0;                    ///< inputs of one sum
  std::vector<float> weight;       ///< [output][tap], empty for pools
  std::vector<float> bias;         ///< [output]
  nn::Affine<float> affine;        ///< follows the sum; empty: nothing
  std::vector<std::int8_t> steps;  ///< 8-bit weights, if there are any; then value = scale[output] sum + bias[output]
  std::vector<float> scale;

  /// Products with weights.
  bool sums() const { return kind == Kind::convolution || kind == Kind::all; }
  bool pools() const { return kind == Kind::max_pool || kind == Kind::average_pool; }
  /// Returns a number that outputs are multiplied by: of an average, or a leaky ReLU's slope.
  float factor() const {
    return kind == Kind::leaky_relu ? slope : 1.0F / static_cast<float>(kernel.rows * kernel.columns);
  }
  /// Reads its input whole.
  bool reads_all() const { return kind == Kind::all || kind == Kind::statistics || kind == Kind::layer_norm; }
  /// Ends a residual or concat.
  bool joins() const { return kind == Kind::add || kind == Kind::concat; }
  /// Returns the rows from the kernel's first to its last, and the columns.
  Extent extent() const { return {(kernel.rows - 1) * dilation + 1, kernel.columns}; }
  /// Returns true if it also has arithmetic in 8-bit integers.
  bool has_integers() const {
    return kind <= Kind::statistics && dilation == 1 && groups == 1 && (sums() || (pad.rows == 0 && pad.columns == 0));
  }
};

/// Bytes from the start of the arena, multiples of 8.
struct ArenaPlan {
  long long maps = 0, patch = 0, signal = 0, scratch = 0, spectra = 0, samples = 0;
  long long outputs = 0;  ///< of a network alone
  long long bytes = 0;
};

struct FirmwareOptions {
  bool incremental = false;  ///< samples are fed as they arrive
  bool int8 = false;
  bool ood_score = false;  ///< the trial's distance from those of the training can be asked for
};

struct FirmwarePlan {
  FirmwareOptions options;
  bool stream_rows = true;  ///< lines are the image's rows, which then is kept whole; else its columns
  std::vector<FirmwareMap> maps;
  std::vector<FirmwareLayer> layers;
  bool outputs_in_map = false;  ///< the last map is kept whole, and is the outputs; else a value for each channel is
  std::vector<int> radices;     ///< of the transform's passes
  ArenaPlan arena;

  int max_radix() const;
  /// Returns the size of weights, biases and scales.
  long long weight_bytes() const;
  /// Returns the size of all maps if each were kept whole.
  long long whole_map_bytes() const;
};

/// Plans by rows or by columns, whichever needs the smaller arena. Incremental plans go by columns if the network input
/// has several; inputs of time series, of one column, go by rows, which are times. Throws Error for models that do not
/// fit a firmware: outputs that are neither parameters nor a mixture, more than 250 layers, an arena above 1 GiB.
FirmwarePlan plan_firmware(const Model& model, const FirmwareOptions& options);
/// The plan of a network alone, whose input is given whole. Throws Error also for layers that the runtime does not
/// have.
FirmwarePlan plan_network(const nn::Network<float>& network);

}  // namespace decid::tools
