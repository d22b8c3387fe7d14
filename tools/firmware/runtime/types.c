/* ---- Types of the tables below ------------------------------------------------------------------------------ */

#if QUANTISED
typedef int8_t activation;
typedef int8_t weight_value;
typedef int32_t accumulator;
#else
typedef float activation;
typedef float weight_value;
typedef float accumulator;
#endif

/* An integer q stands for (q - zero) / steps_per_unit. Without quantisation zero is 0 and the rest has no effect. */
typedef struct {
  float steps_per_unit;
  int32_t zero;
} quantisation_scale;

/* The buffer between two layers. Value (line, channel, position) is at offset + (line % capacity) line_stride +
   channel channel_stride + position position_stride. */
typedef struct {
  int32_t offset;
  int32_t channels;
  int32_t lines;
  int32_t positions;
  int32_t capacity; /* lines that are kept */
  int32_t line_stride;
  int32_t channel_stride;
  int32_t position_stride;
  quantisation_scale quantisation;
} network_map;

/* Kinds of layers: LAYER_ALL reads all values of its input, which lie in order, in one go; LAYER_STATISTICS those of
   one channel after the other, LAYER_NORM all, and makes all lines in one go. LAYER_ADD and LAYER_CONCAT end a block,
   whose input they read too. */
enum {
  LAYER_CONVOLUTION,
  LAYER_ALL,
  LAYER_MAX_POOL,
  LAYER_AVERAGE_POOL,
  LAYER_STATISTICS,
  LAYER_LEAKY_RELU,
  LAYER_TANH,
  LAYER_SIGMOID,
  LAYER_GELU,
  LAYER_NORM,
  LAYER_ADD,
  LAYER_CONCAT
};

typedef struct {
  uint8_t kind;
  uint8_t src; /* maps */
  uint8_t dst;
  uint8_t kept; /* the block's input */
  uint8_t normalises;
  uint8_t rectifies;
  uint8_t last;
  int32_t kernel_lines;
  int32_t kernel_positions;
  int32_t stride_lines;
  int32_t stride_positions;
  int32_t pad_lines;
  int32_t pad_positions;
  int32_t dilation_lines;
  int32_t dilation_positions;
  int32_t groups;             /* of channels */
  int32_t taps;               /* inputs of one sum */
  float factor;               /* of an average, or a leaky ReLU's slope */
  const weight_value* weight; /* [output][tap], or a LAYER_NORM's factors */
  const float* bias;          /* without quantisation the sums begin with it; with it, value = scale sum + bias */
  const float* scale;
  const float* affine_scale;
  const float* affine_shift;
} network_layer;

enum {
  CHANNEL_MODULUS,
  CHANNEL_LOG_MODULUS,
  CHANNEL_PHASE,
  CHANNEL_COS_PHASE,
  CHANNEL_SIN_PHASE,
  CHANNEL_REAL,
  CHANNEL_IMAGINARY,
  CHANNEL_ASINH_REAL,
  CHANNEL_ASINH_IMAGINARY,
  CHANNEL_LOG_RESIDUAL,
  CHANNEL_SWAY,
  CHANNEL_SWAY_CHANGE,
  CHANNEL_SWAY_BEND,
  CHANNEL_TORQUE
};
