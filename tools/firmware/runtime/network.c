/* ---- The network ----------------------------------------------------------------------------------------------------
   Line by line: a layer makes its next output line as soon as the lines of its input that this needs are there, and of
   an input no more lines are kept than one output needs. A line is a row or a column of the image, see STREAM_ROWS.
   The order of every sum is that of decid's nn/kernels/kernels.hpp. */

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

/* The inputs of one output position, in `channels` channels from data on, in the order of the sums: channel, row,
   column; zeros outside. */
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
        const int32_t l = first_line + y;
        const int32_t p = first_position + x;
#else
        const int32_t l = first_line + x;
        const int32_t p = first_position + y;
#endif
        if ((l >= 0) && (l < src->lines) && (p >= 0) && (p < src->positions)) {
          *to = plane[((l % src->capacity) * src->line_stride) + (p * src->position_stride)];
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

static void convolve(const network_layer* layer, const network_map* dst, const activation* x, activation* to,
                     float* outputs) {
  int32_t first;
  int32_t i;
  for (first = 0; first < dst->channels; first += 4) {
    const weight_value* weight[4];
    accumulator sum[4];
    for (i = 0; i < 4; ++i) {
      const int32_t channel = ((first + i) < dst->channels) ? (first + i) : (dst->channels - 1);
      weight[i] = &layer->weight[channel * layer->taps];
#if QUANTISED
      sum[i] = 0;
#else
      sum[i] = layer->bias[channel];
#endif
    }
    sum_products(weight, x, layer->taps, sum);
    for (i = 0; (i < 4) && ((first + i) < dst->channels); ++i) {
      put_output(layer, dst, to, outputs, first + i, from_accumulator(layer, first + i, sum[i]));
    }
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
    sum = sum * layer->average;
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
    mean = sum * layer->average;
    for (t = 0; t < layer->taps; ++t) {
      const float off = from_accumulator(layer, channel, plane[t]) - mean;
      squares = fma_float(off, off, squares);
    }
    put_output(layer, dst, to, outputs, channel, mean);
    put_output(layer, dst, to, outputs, src->channels + channel,
               (float)square_root((double)fma_float(squares, layer->average, STATISTICS_EPSILON)));
  }
}
#endif

/* The next output line of a layer; memory: the maps, at their offsets. */
static void make_line(const network_layer* layer, int32_t line, activation* memory, activation* patch, float* outputs) {
  const network_map* const src = &network_maps[layer->src];
  const network_map* const dst = &network_maps[layer->dst];
  const activation* const data = &memory[src->offset];
  int32_t position;
#if USES_POOLS
  int32_t channel;
#endif
  for (position = 0; position < dst->positions; ++position) {
    activation* const to =
        &memory[dst->offset + ((line % dst->capacity) * dst->line_stride) + (position * dst->position_stride)];
    switch (layer->kind) {
      case LAYER_CONVOLUTION:
        gather(layer, src, data, src->channels, line, position, patch);
        convolve(layer, dst, patch, to, outputs);
        break;
      case LAYER_ALL:
        convolve(layer, dst, data, to, outputs);
        break;
#if USES_STATISTICS
      case LAYER_STATISTICS:
        summarise(layer, src, dst, data, to, outputs);
        break;
#endif
      default:
#if USES_POOLS
        for (channel = 0; channel < dst->channels; ++channel) {
          gather(layer, src, &data[channel * src->channel_stride], 1, line, position, patch);
          put_output(layer, dst, to, outputs, channel, from_accumulator(layer, channel, pool(layer, patch)));
        }
#endif
        break;
    }
  }
}

/* Makes one line, of the deepest layer that can make one. ready: lines of each map that were made. Returns 0 if no
   layer can. */
static int32_t advance_network(int32_t* ready, activation* memory, activation* patch, float* outputs) {
  int32_t i;
  for (i = LAYERS - 1; i >= 0; --i) {
    const network_layer* const layer = &network_layers[i];
    const network_map* const src = &network_maps[layer->src];
    const network_map* const dst = &network_maps[layer->dst];
    const int32_t line = ready[layer->dst];
    const int32_t needed = ((line * layer->stride_lines) - layer->pad_lines) + layer->kernel_lines;
    if ((line < dst->lines) && (((needed < src->lines) ? needed : src->lines) <= ready[layer->src])) {
      make_line(layer, line, memory, patch, outputs);
      ready[layer->dst] = line + 1;
      return 1;
    }
  }
  return 0;
}
