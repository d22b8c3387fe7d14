/* ---- The image ------------------------------------------------------------------------------------------------------
   The network's input: decid's dataset/image/image.hpp. Rows of spectra are frequencies and columns windows; of time
   series, rows are blocks of time. */

/* Puts a value where the network reads it. */
static void put_pixel(activation* image, int32_t channel, int32_t row, int32_t column, float value) {
  const network_map* const map = &network_maps[0];
#if STREAM_ROWS
  image[((row % map->capacity) * map->line_stride) + (channel * map->channel_stride) +
        (column * map->position_stride)] = to_activation(value, &map->quantisation);
#else
  image[((column % map->capacity) * map->line_stride) + (channel * map->channel_stride) +
        (row * map->position_stride)] = to_activation(value, &map->quantisation);
#endif
}

static void draw_pixel(activation* image, int32_t channel, int32_t row, int32_t column, double value) {
  float scaled = (float)value;
#if STANDARDIZES_ROWS
  const int32_t of_row = (channel * IMAGE_ROWS) + row;
  scaled = (scaled - row_mean[of_row]) / row_deviation[of_row];
#endif
  put_pixel(image, channel, row, column, scaled);
}
