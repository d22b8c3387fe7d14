/* ---- Spectra of windows ---------------------------------------------------------------------------------------------
   The transform of decid's sim/fft.hpp with the same butterflies and twiddles, so with the same bits, but in place:
   each butterfly writes where it has read, a bin is looked up by its reversed digits, and the last pass leaves out what
   no shown bin needs. Decimation in frequency (Van Loan, Computational Frameworks for the FFT, 1992). */

typedef struct {
  double re;
  double im;
} complex_value;

static complex_value plus(complex_value a, complex_value b) {
  complex_value c;
  c.re = a.re + b.re;
  c.im = a.im + b.im;
  return c;
}

static complex_value minus(complex_value a, complex_value b) {
  complex_value c;
  c.re = a.re - b.re;
  c.im = a.im - b.im;
  return c;
}

static complex_value times(complex_value a, double factor) {
  complex_value c;
  c.re = a.re * factor;
  c.im = a.im * factor;
  return c;
}

static complex_value times_minus_i(complex_value a) {
  complex_value c;
  c.re = a.im;
  c.im = -a.re;
  return c;
}

#if (WINDOW % 2) == 0
static complex_value conjugate(complex_value a) {
  complex_value c;
  c.re = a.re;
  c.im = -a.im;
  return c;
}
#endif

static complex_value product(complex_value a, complex_value factor) {
  complex_value c;
  c.re = (a.re * factor.re) - (a.im * factor.im);
  c.im = (a.re * factor.im) + (a.im * factor.re);
  return c;
}

/* exp(-2 pi i n / WINDOW), 0 <= n < WINDOW: the table is mirrored. */
static complex_value root_of_unity(int32_t n) {
  complex_value root;
  int32_t k = n;
  int32_t lower = 0;
  int32_t left = 0;
  if ((2 * k) > WINDOW) {
    lower = 1;
    k = WINDOW - k;
  }
#if (WINDOW % 2) == 0
  if ((4 * k) > WINDOW) {
    left = 1;
    k = (WINDOW / 2) - k;
  }
#endif
  root.re = (left != 0) ? -turn_cosine[k] : turn_cosine[k];
  root.im = (lower != 0) ? turn_sine[k] : -turn_sine[k];
  return root;
}

#if USES_RADIX_2
static void butterfly_2(complex_value* x) {
  const complex_value sum = plus(x[0], x[1]);
  x[1] = minus(x[0], x[1]);
  x[0] = sum;
}
#endif

#if USES_RADIX_3
static void butterfly_3(complex_value* x) {
  const complex_value sum = plus(x[1], x[2]);
  const complex_value side = times_minus_i(times(minus(x[1], x[2]), 0.86602540378443865));
  const complex_value middle = minus(x[0], times(sum, 0.5));
  x[0] = plus(x[0], sum);
  x[1] = plus(middle, side);
  x[2] = minus(middle, side);
}
#endif

#if USES_RADIX_4
static void butterfly_4(complex_value* x) {
  const complex_value even_sum = plus(x[0], x[2]);
  const complex_value even_difference = minus(x[0], x[2]);
  const complex_value odd_sum = plus(x[1], x[3]);
  const complex_value odd_difference = times_minus_i(minus(x[1], x[3]));
  x[0] = plus(even_sum, odd_sum);
  x[1] = plus(even_difference, odd_difference);
  x[2] = minus(even_sum, odd_sum);
  x[3] = minus(even_difference, odd_difference);
}
#endif

#if USES_RADIX_5
static void butterfly_5(complex_value* x) {
  const double cos1 = 0.30901699437494742;
  const double cos2 = -0.80901699437494742;
  const double sin1 = 0.95105651629515357;
  const double sin2 = 0.58778525229247313;
  const complex_value sum1 = plus(x[1], x[4]);
  const complex_value sum2 = plus(x[2], x[3]);
  const complex_value difference1 = minus(x[1], x[4]);
  const complex_value difference2 = minus(x[2], x[3]);
  const complex_value middle1 = plus(x[0], plus(times(sum1, cos1), times(sum2, cos2)));
  const complex_value middle2 = plus(x[0], plus(times(sum1, cos2), times(sum2, cos1)));
  const complex_value side1 = times_minus_i(plus(times(difference1, sin1), times(difference2, sin2)));
  const complex_value side2 = times_minus_i(minus(times(difference1, sin2), times(difference2, sin1)));
  x[0] = plus(x[0], plus(sum1, sum2));
  x[1] = plus(middle1, side1);
  x[2] = plus(middle2, side2);
  x[3] = minus(middle2, side2);
  x[4] = minus(middle1, side1);
}
#endif

#if LARGEST_RADIX > 5
/* Any odd radix: x[j] and x[radix - j] share their cosines and sines. fold: radix - 1 values. needed: of each output,
   whether it is looked at; NULL: all are. */
static void butterfly_odd(complex_value* x, int32_t radix, complex_value* fold, const uint8_t* needed) {
  const int32_t half = radix / 2;
  complex_value* const differences = &fold[half];
  const complex_value first = x[0];
  complex_value total = first;
  int32_t j;
  int32_t r;
  for (j = 1; j <= half; ++j) {
    fold[j - 1] = plus(x[j], x[radix - j]);
    differences[j - 1] = minus(x[j], x[radix - j]);
    total = plus(total, fold[j - 1]);
  }
  x[0] = total;
  for (r = 1; r <= half; ++r) {
    complex_value middle = first;
    complex_value side = {0.0, 0.0};
    int32_t power = r;
    if ((needed != NULL) && (needed[r] == 0U) && (needed[radix - r] == 0U)) {
      continue;
    }
    for (j = 1; j <= half; ++j) {
      const complex_value root = root_of_unity(power * (WINDOW / radix));
      middle = plus(middle, times(fold[j - 1], root.re));
      side = plus(side, times(differences[j - 1], -root.im));
      power += r;
      if (power >= radix) {
        power -= radix;
      }
    }
    side = times_minus_i(side);
    x[r] = plus(middle, side);
    x[radix - r] = minus(middle, side);
  }
}
#endif

#if PASSES > 0
/* Butterfly `number` of pass `pass`; x: room for LARGEST_RADIX values and as many for its sums. */
static void run_butterfly(complex_value* signal, int32_t pass, int32_t number, complex_value* x) {
  const int32_t radix = pass_radix[pass];
  const int32_t groups = pass_groups[pass];
  const int32_t points = groups * radix;
  const int32_t group = number % groups;
  complex_value* const at = &signal[((number / groups) * points) + group];
  const int32_t turn = group * (WINDOW / points);
  const uint8_t* const needed = (pass == (PASSES - 1)) ? last_pass_needed : NULL;
  int32_t j;
  for (j = 0; j < radix; ++j) {
    x[j] = at[j * groups];
  }
  switch (radix) {
#if USES_RADIX_2
    case 2:
      butterfly_2(x);
      break;
#endif
#if USES_RADIX_3
    case 3:
      butterfly_3(x);
      break;
#endif
#if USES_RADIX_4
    case 4:
      butterfly_4(x);
      break;
#endif
#if USES_RADIX_5
    case 5:
      butterfly_5(x);
      break;
#endif
    default:
#if LARGEST_RADIX > 5
      butterfly_odd(x, radix, &x[radix], needed);
#endif
      break;
  }
  at[0] = x[0];
  for (j = 1; j < radix; ++j) {
    if ((needed == NULL) || (needed[j] != 0U)) {
      at[j * groups] = product(x[j], root_of_unity(turn * j));
    }
  }
}

#endif

/* Where bin k is after the last pass. */
static int32_t place_of(int32_t k) {
#if PASSES > 0
  int32_t place = 0;
  int32_t rest = k;
  int32_t pass;
  for (pass = 0; pass < PASSES; ++pass) {
    place += (rest % pass_radix[pass]) * pass_groups[pass];
    rest /= pass_radix[pass];
  }
  return place;
#else
  return k;
#endif
}

/* Bin k, 0 .. WINDOW / 2, of the real signal's spectrum. */
static complex_value spectrum_bin(const complex_value* signal, int32_t k) {
#if (WINDOW % 2) == 0
  /* The spectra of the even and the odd samples are the Hermitian and the anti-Hermitian part. */
  const int32_t half = WINDOW / 2;
  const int32_t lower = ((2 * k) < half) ? k : (half - k);
  const complex_value a = signal[place_of(lower)];
  const complex_value b = conjugate(signal[place_of((lower == 0) ? 0 : (half - lower))]);
  const complex_value even = times(plus(a, b), 0.5);
  const complex_value odd = product(times(times_minus_i(minus(a, b)), 0.5), root_of_unity(lower));
  return ((2 * k) < half) ? plus(even, odd) : conjugate(minus(even, odd));
#else
  return signal[place_of(k)];
#endif
}
