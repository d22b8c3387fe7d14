/* ---- Bins of the image -------------------------------------------------------------------------------------- */

#define MODULUS_FLOOR_RAD 1e-6
#define ASINH_KNEE_RAD 1e-3

#if USES_MODULUS
static double modulus_of(complex_value z) {
  return square_root((z.re * z.re) + (z.im * z.im));
}
#endif

#if USES_LOG_MODULUS || USES_LOG_RESIDUAL
static double floored_log(double modulus) {
  return natural_log((MODULUS_FLOOR_RAD > modulus) ? MODULUS_FLOOR_RAD : modulus);
}
#endif

/* Returns a channel's value for the bin whose mean over the cycles is z; residual: how the cycles differ. */
static double shown(int32_t channel, complex_value z, double residual) {
  double value = 0.0;
  (void)residual;
  switch (channel) {
#if USES_CHANNEL_MODULUS
    case CHANNEL_MODULUS:
      value = modulus_of(z);
      break;
#endif
#if USES_LOG_MODULUS
    case CHANNEL_LOG_MODULUS:
      value = floored_log(modulus_of(z));
      break;
#endif
#if USES_PHASE
    case CHANNEL_PHASE:
      value = angle_of(z.im, z.re);
      break;
#endif
#if USES_COS_PHASE
    case CHANNEL_COS_PHASE:
      value = modulus_of(z);
      value = (value > 0.0) ? (z.re / value) : 1.0;
      break;
#endif
#if USES_SIN_PHASE
    case CHANNEL_SIN_PHASE:
      value = modulus_of(z);
      value = (value > 0.0) ? (z.im / value) : 0.0;
      break;
#endif
    case CHANNEL_REAL:
      value = z.re;
      break;
    case CHANNEL_IMAGINARY:
      value = z.im;
      break;
#if USES_ASINH
    case CHANNEL_ASINH_REAL:
      value = inverse_sinh(z.re / ASINH_KNEE_RAD);
      break;
    case CHANNEL_ASINH_IMAGINARY:
      value = inverse_sinh(z.im / ASINH_KNEE_RAD);
      break;
#endif
#if USES_LOG_RESIDUAL
    case CHANNEL_LOG_RESIDUAL:
      value = floored_log(residual);
      break;
#endif
    default:
      break;
  }
  return value;
}

/* Returns 1 if a channel changes its sign from z to its conjugate. */
static int32_t is_odd(int32_t channel) {
  return ((channel == CHANNEL_PHASE) || (channel == CHANNEL_SIN_PHASE) || (channel == CHANNEL_IMAGINARY) ||
          (channel == CHANNEL_ASINH_IMAGINARY))
             ? 1
             : 0;
}

/* Draws bin k of a column in every channel. earlier: that bin in the cycles before the last, `apart` values apart. */
static void draw_bin(activation* image, const complex_value* signal, const complex_value* earlier, int32_t apart,
                     int32_t k, int32_t column) {
  const complex_value last = spectrum_bin(signal, k);
  complex_value mean = {0.0, 0.0};
  double residual = 0.0;
  const int32_t mirror = WINDOW - k;
  int32_t channel;
#if FOLD > 1
  int32_t cycle;
  for (cycle = 0; cycle < (FOLD - 1); ++cycle) {
    mean = plus(mean, earlier[cycle * apart]);
  }
#else
  (void)earlier;
  (void)apart;
#endif
  mean = plus(mean, last);
  mean.re = mean.re / (double)FOLD;
  mean.im = mean.im / (double)FOLD;
#if USES_LOG_RESIDUAL
  {
    double squares = 0.0;
    complex_value difference;
#if FOLD > 1
    for (cycle = 0; cycle < (FOLD - 1); ++cycle) {
      difference = minus(earlier[cycle * apart], mean);
      squares = squares + ((difference.re * difference.re) + (difference.im * difference.im));
    }
#endif
    difference = minus(last, mean);
    squares = squares + ((difference.re * difference.re) + (difference.im * difference.im));
    residual = square_root(squares / (double)FOLD);
  }
#endif
  for (channel = 0; channel < IMAGE_CHANNELS; ++channel) {
    const int32_t what = image_channel[channel];
    const double value = shown(what, mean, residual);
    draw_pixel(image, channel, k, column, value);
    if ((k > 0) && (mirror >= SHOWN_BINS) && (mirror < IMAGE_ROWS)) {
      /* A real z is its own conjugate: its phase stays pi. */
      const int32_t negated = ((is_odd(what) != 0) && (mean.im != 0.0)) ? 1 : 0;
      draw_pixel(image, channel, mirror, column, (negated != 0) ? -value : value);
    }
  }
}
