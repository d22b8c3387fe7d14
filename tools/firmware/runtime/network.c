/* ---- The network ----------------------------------------------------------------------------------------------------
   Line by line: a layer makes its next output line as soon as the lines of its input that this needs are there, and of
   an input no more lines are kept than one output needs. A line is a row or a column of the image, see STREAM_ROWS.
   The order of every sum is that of decid's nn/kernels/kernels.hpp. */

/* Value k of the self-test's sway or input: a slow triangle with noise on it, in exact arithmetic. */
static float self_test_value(int32_t k) {
  uint32_t x = (uint32_t)k * 2654435761U;
  const int32_t ramp = (k % 2420) - 1210;
  const int32_t triangle = 605 - ((ramp < 0) ? -ramp : ramp);
  x ^= x >> 15;
  x *= 2246822519U;
  x ^= x >> 13;
  return ((float)triangle * 1.52587890625e-05F) + ((float)((int32_t)(x >> 8) - 8388608) * 1.1641532182693481e-10F);
}

#if QUANTISED
static int32_t to_integer(float value, const quantisation_scale* to) {
  float steps = (value * to->steps_per_unit) + (float)to->zero;
  if (!(steps > -128.0F)) {
    steps = -128.0F;
  }
  if (steps > 127.0F) {
    steps = 127.0F;
  }
  return (int32_t)(steps + 128.5F) - 128;
}
#endif

static activation to_activation(float value, const quantisation_scale* to) {
#if QUANTISED
  return (activation)to_integer(value, to);
#else
  (void)to;
  return value;
#endif
}

/* Place of a line's position in a map's channel. */
static int32_t place_in(const network_map* map, int32_t line, int32_t position) {
  return ((line % map->capacity) * map->line_stride) + (position * map->position_stride);
}

#if USES_POOLS
/* The nearest number from 0 to below count. */
static int32_t clamped(int32_t i, int32_t count) {
  const int32_t low = (i < 0) ? 0 : i;
  return (low < count) ? low : (count - 1);
}
#endif

/* The inputs of one output position, in `channels` channels from data on, in the order of the sums: channel, row,
   column. Outside are zeros; to a maximum, values that it has already. */
static void gather(const network_layer* layer, const network_map* src, const activation* data, int32_t channels,
                   int32_t line, int32_t position, activation* patch) {
  const int32_t first_line = (line * layer->stride_lines) - layer->pad_lines;
  const int32_t first_position = (position * layer->stride_positions) - layer->pad_positions;
#if STREAM_ROWS
  const int32_t kernel_rows = layer->kernel_lines;
  const int32_t kernel_columns = layer->kernel_positions;
#else
  const int32_t kernel_rows = layer->kernel_positions;
  const int32_t kernel_columns = layer->kernel_lines;
#endif
  activation* to = patch;
  int32_t channel;
  int32_t y;
  int32_t x;
  for (channel = 0; channel < channels; ++channel) {
    const activation* const plane = &data[channel * src->channel_stride];
    for (y = 0; y < kernel_rows; ++y) {
      for (x = 0; x < kernel_columns; ++x) {
#if STREAM_ROWS
        const int32_t l = first_line + (y * layer->dilation_lines);
        const int32_t p = first_position + (x * layer->dilation_positions);
#else
        const int32_t l = first_line + (x * layer->dilation_lines);
        const int32_t p = first_position + (y * layer->dilation_positions);
#endif
        if ((l >= 0) && (l < src->lines) && (p >= 0) && (p < src->positions)) {
          *to = plane[place_in(src, l, p)];
#if USES_POOLS
        } else if (layer->kind == LAYER_MAX_POOL) {
          *to = plane[place_in(src, clamped(l, src->lines), clamped(p, src->positions))];
#endif
        } else {
          *to = (activation)src->quantisation.zero;
        }
        ++to;
      }
    }
  }
}

/* Four outputs' sums over the same inputs, each one chain in order. */
static void sum_products(const weight_value* const weight[4], const activation* x, int32_t taps, accumulator sum[4]) {
  const weight_value* const w0 = weight[0];
  const weight_value* const w1 = weight[1];
  const weight_value* const w2 = weight[2];
  const weight_value* const w3 = weight[3];
  accumulator s0 = sum[0];
  accumulator s1 = sum[1];
  accumulator s2 = sum[2];
  accumulator s3 = sum[3];
  int32_t t;
  for (t = 0; t < taps; ++t) {
#if QUANTISED
    const int32_t value = x[t];
    s0 += w0[t] * value;
    s1 += w1[t] * value;
    s2 += w2[t] * value;
    s3 += w3[t] * value;
#else
    const float value = x[t];
    s0 = fma_float(w0[t], value, s0);
    s1 = fma_float(w1[t], value, s1);
    s2 = fma_float(w2[t], value, s2);
    s3 = fma_float(w3[t], value, s3);
#endif
  }
  sum[0] = s0;
  sum[1] = s1;
  sum[2] = s2;
  sum[3] = s3;
}

/* Finishes every output of a layer: BatchNorm where it is not part of the weights, ReLU. */
static float finish(const network_layer* layer, int32_t channel, float value) {
  float y = value;
  if (layer->affine_scale != NULL) {
    y = fma_float(y, layer->affine_scale[channel], layer->affine_shift[channel]);
  } else if (layer->normalises != 0U) {
    y = y + 0.0F; /* a BatchNorm that is part of the weights: turns -0 into 0 */
  } else {
    /* as it is */
  }
  if ((layer->rectifies != 0U) && (y < 0.0F)) {
    y = 0.0F;
  }
  return y;
}

/* Value of an accumulator in the units of the layer's input. */
static float from_accumulator(const network_layer* layer, int32_t channel, accumulator sum) {
#if QUANTISED
  return fma_float((float)sum, layer->scale[channel], layer->bias[channel]);
#else
  (void)layer;
  (void)channel;
  return sum;
#endif
}

/* value: in the units of the layer's input. */
static void put_output(const network_layer* layer, const network_map* dst, activation* to, float* outputs,
                       int32_t channel, float value) {
  const float y = finish(layer, channel, value);
  if (layer->last != 0U) {
    outputs[channel] = y;
  } else {
    to[channel * dst->channel_stride] = to_activation(y, &dst->quantisation);
  }
}

/* Outputs of the channels from `first` to below `end`, which read the same inputs. */
static void convolve(const network_layer* layer, const network_map* dst, const activation* x, int32_t first,
                     int32_t end, activation* to, float* outputs) {
  int32_t next;
  int32_t i;
  for (next = first; next < end; next += 4) {
    const weight_value* weight[4];
    accumulator sum[4];
    for (i = 0; i < 4; ++i) {
      const int32_t channel = ((next + i) < end) ? (next + i) : (end - 1);
      weight[i] = &layer->weight[channel * layer->taps];
#if QUANTISED
      sum[i] = 0;
#else
      sum[i] = layer->bias[channel];
#endif
    }
    sum_products(weight, x, layer->taps, sum);
    for (i = 0; (i < 4) && ((next + i) < end); ++i) {
      put_output(layer, dst, to, outputs, next + i, from_accumulator(layer, next + i, sum[i]));
    }
  }
}

static void convolve_groups(const network_layer* layer, const network_map* src, const network_map* dst,
                            const activation* data, int32_t line, int32_t position, activation* patch, activation* to,
                            float* outputs) {
  const int32_t inputs = src->channels / layer->groups;
  const int32_t made = dst->channels / layer->groups;
  int32_t group;
  for (group = 0; group < layer->groups; ++group) {
    gather(layer, src, &data[(group * inputs) * src->channel_stride], inputs, line, position, patch);
    convolve(layer, dst, patch, group * made, (group + 1) * made, to, outputs);
  }
}

#if USES_POOLS
/* Returns 1 if a pool takes x instead of the largest so far. A NaN stays. */
static int32_t is_larger(accumulator x, accumulator largest) {
#if QUANTISED
  return (x > largest) ? 1 : 0;
#else
  return ((x > largest) || ((float_bits(x) & 0x7fffffffU) > 0x7f800000U)) ? 1 : 0;
#endif
}

/* One channel's window. */
static accumulator pool(const network_layer* layer, const activation* x) {
  accumulator sum = 0;
  int32_t t;
  if (layer->kind == LAYER_MAX_POOL) {
    sum = x[0];
    for (t = 1; t < layer->taps; ++t) {
      if (is_larger(x[t], sum) != 0) {
        sum = x[t];
      }
    }
  } else {
    for (t = 0; t < layer->taps; ++t) {
      sum += x[t];
    }
#if !QUANTISED
    sum = sum * layer->factor;
#endif
  }
  return sum;
}
#endif

#if USES_STATISTICS
/* Mean and deviation of every channel. */
static void summarise(const network_layer* layer, const network_map* src, const network_map* dst,
                      const activation* data, activation* to, float* outputs) {
  int32_t channel;
  for (channel = 0; channel < src->channels; ++channel) {
    const activation* const plane = &data[channel * src->channel_stride];
    float sum = 0.0F;
    float squares = 0.0F;
    float mean;
    int32_t t;
    for (t = 0; t < layer->taps; ++t) {
      sum = sum + from_accumulator(layer, channel, plane[t]);
    }
    mean = sum * layer->factor;
    for (t = 0; t < layer->taps; ++t) {
      const float off = from_accumulator(layer, channel, plane[t]) - mean;
      squares = fma_float(off, off, squares);
    }
    put_output(layer, dst, to, outputs, channel, mean);
    put_output(layer, dst, to, outputs, src->channels + channel,
               (float)square_root((double)fma_float(squares, layer->factor, STATISTICS_EPSILON)));
  }
}
#endif

#if USES_FUNCTIONS
static float function_of(const network_layer* layer, float x) {
  float y = x;
  switch (layer->kind) {
#if USES_LEAKY_RELU
    case LAYER_LEAKY_RELU:
      y = (x > 0.0F) ? x : (layer->factor * x);
      break;
#endif
#if USES_TANH
    case LAYER_TANH:
      y = (float)hyperbolic_tangent((double)x);
      break;
#endif
#if USES_SIGMOID
    case LAYER_SIGMOID:
      y = (float)logistic((double)x);
      break;
#endif
#if USES_GELU
    case LAYER_GELU:
      y = (float)((double)x * normal_distribution((double)x));
      break;
#endif
    default:
      /* other layers have other code */
      break;
  }
  return y;
}
#endif

#if USES_LAYER_NORM
/* All lines: each value less the mean of all, over their standard deviation, by the channel's factor and shift. */
static void normalise(const network_layer* layer, const network_map* src, const network_map* dst,
                      const activation* data, activation* to, float* outputs) {
  const double count = (double)(src->channels * layer->taps);
  double mean = 0.0;
  double squares = 0.0;
  double inverse;
  int32_t channel;
  int32_t t;
  for (t = 0; t < (src->channels * layer->taps); ++t) {
    mean = mean + (double)data[t];
  }
  mean = mean / count;
  for (t = 0; t < (src->channels * layer->taps); ++t) {
    const double off = (double)data[t] - mean;
    squares = squares + (off * off);
  }
  inverse = 1.0 / square_root((squares / count) + 1e-5);
  for (channel = 0; channel < src->channels; ++channel) {
    for (t = 0; t < layer->taps; ++t) {
      const double normal = ((double)data[(channel * src->channel_stride) + t] - mean) * inverse;
      put_output(layer, dst, &to[t], outputs, channel,
                 (float)(((double)layer->weight[channel] * normal) + (double)layer->bias[channel]));
    }
  }
}
#endif

#if USES_BLOCKS
/* The end of a block, at one position: kept: the map with its input. */
static void join_block(const network_layer* layer, const network_map* src, const network_map* dst,
                       const activation* memory, int32_t line, int32_t position, activation* to, float* outputs) {
  const network_map* const kept = &network_maps[layer->kept];
  const activation* const past = &memory[kept->offset + place_in(kept, line, position)];
  const activation* const made = &memory[src->offset + place_in(src, line, position)];
  int32_t channel;
  for (channel = 0; channel < dst->channels; ++channel) {
    float value;
    if (layer->kind == LAYER_ADD) {
      value = past[channel * kept->channel_stride] + made[channel * src->channel_stride];
    } else if (channel < kept->channels) {
      value = past[channel * kept->channel_stride];
    } else {
      value = made[(channel - kept->channels) * src->channel_stride];
    }
    put_output(layer, dst, to, outputs, channel, value);
  }
}
#endif

/* The next output line of a layer; memory: the maps, at their offsets. */
static void make_line(const network_layer* layer, int32_t line, activation* memory, activation* patch, float* outputs) {
  const network_map* const src = &network_maps[layer->src];
  const network_map* const dst = &network_maps[layer->dst];
  const activation* const data = &memory[src->offset];
  int32_t position;
#if USES_POOLS || USES_FUNCTIONS
  int32_t channel;
#endif
  for (position = 0; position < dst->positions; ++position) {
    activation* const to = &memory[dst->offset + place_in(dst, line, position)];
    switch (layer->kind) {
      case LAYER_CONVOLUTION:
        convolve_groups(layer, src, dst, data, line, position, patch, to, outputs);
        break;
      case LAYER_ALL:
        convolve(layer, dst, data, 0, dst->channels, to, outputs);
        break;
#if USES_STATISTICS
      case LAYER_STATISTICS:
        summarise(layer, src, dst, data, to, outputs);
        break;
#endif
#if USES_LAYER_NORM
      case LAYER_NORM:
        if (position == 0) {
          normalise(layer, src, dst, data, to, outputs);
        }
        break;
#endif
#if USES_BLOCKS
      case LAYER_ADD:
      case LAYER_CONCAT:
        join_block(layer, src, dst, memory, line, position, to, outputs);
        break;
#endif
#if USES_POOLS
      case LAYER_MAX_POOL:
      case LAYER_AVERAGE_POOL:
        for (channel = 0; channel < dst->channels; ++channel) {
          gather(layer, src, &data[channel * src->channel_stride], 1, line, position, patch);
          put_output(layer, dst, to, outputs, channel, from_accumulator(layer, channel, pool(layer, patch)));
        }
        break;
#endif
      default:
#if USES_FUNCTIONS
        for (channel = 0; channel < dst->channels; ++channel) {
          const activation x = data[(channel * src->channel_stride) + place_in(src, line, position)];
          put_output(layer, dst, to, outputs, channel, function_of(layer, x));
        }
#endif
        break;
    }
  }
}

/* Returns 1 if the inputs of a layer's next line are there. */
static int32_t can_make(const network_layer* layer, const int32_t* ready, int32_t line) {
  const network_map* const src = &network_maps[layer->src];
  const int32_t extent = ((layer->kernel_lines - 1) * layer->dilation_lines) + 1;
  const int32_t needed = ((line * layer->stride_lines) - layer->pad_lines) + extent;
  int32_t can = (((needed < src->lines) ? needed : src->lines) <= ready[layer->src]) ? 1 : 0;
#if USES_BLOCKS
  if (((layer->kind == LAYER_ADD) || (layer->kind == LAYER_CONCAT)) && (ready[layer->kept] <= line)) {
    can = 0;
  }
#endif
  return can;
}

/* Makes one line, of the deepest layer that can make one. ready: lines of each map that were made. Returns 0 if no
   layer can. */
static int32_t advance_network(int32_t* ready, activation* memory, activation* patch, float* outputs) {
  int32_t i;
  for (i = LAYERS - 1; i >= 0; --i) {
    const network_layer* const layer = &network_layers[i];
    const network_map* const dst = &network_maps[layer->dst];
    const int32_t line = ready[layer->dst];
    if ((line < dst->lines) && (can_make(layer, ready, line) != 0)) {
      make_line(layer, line, memory, patch, outputs);
      ready[layer->dst] = (layer->kind == LAYER_NORM) ? dst->lines : (line + 1);
      return 1;
    }
  }
  return 0;
}
