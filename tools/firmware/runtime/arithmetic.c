/* ---- Arithmetic with the same bits on every processor ---------------------------------------------------------------
   IEEE 754 additions, multiplications and divisions, and what C99 has only in libm: fused multiply-add, square root. */

/* Both make of NaN and infinity what they like: such inputs would be answered as if they were numbers. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ != 0)) || defined(_M_FP_FAST)
#error "Floating-point expressions must be those of IEEE 754: compile without -ffast-math and -ffinite-math-only"
#endif
/* 16: only _Float16, which is not used here, has its own type; gcc's GNU modes say so where the processor has it. */
#if (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "Floating-point expressions must be evaluated in their own type: on x86 compile for SSE (-mfpmath=sse)"
#endif
/* Analysers that read no float.h do not know them. */
#if (defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)) || (defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24))
#error "double must be IEEE 754's of 64 bits, and float of 32: some compilers for small processors need an option"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#endif

/* 1 if the processor has them according to the compiler. */
#if defined(__GNUC__) && (defined(__FP_FAST_FMAF) || defined(__FMA__) || defined(__aarch64__) || \
                          (defined(__ARM_FEATURE_FMA) && defined(__ARM_FP) && ((__ARM_FP & 4) != 0)))
#define HAS_FMA_FLOAT 1
#else
#define HAS_FMA_FLOAT 0
#endif
#if defined(__GNUC__) && (defined(__FP_FAST_FMA) || defined(__FMA__) || defined(__aarch64__) || \
                          (defined(__ARM_FEATURE_FMA) && defined(__ARM_FP) && ((__ARM_FP & 8) != 0)))
#define HAS_FMA_DOUBLE 1
#else
#define HAS_FMA_DOUBLE 0
#endif

typedef union {
  double value;
  uint64_t bits;
} double_bits;

#if (USES_FMA_FLOAT && !HAS_FMA_FLOAT) || (USES_FMA_DOUBLE && !HAS_FMA_DOUBLE)
#define USES_DOUBLE_OF 1
#else
#define USES_DOUBLE_OF (USES_SQUARE_ROOT || USES_LOG || USES_EXPONENTIAL)
#endif

/* Returns 0 if the processor flushes subnormal numbers to 0, where they arise or where they are read: for self-tests.
 */
static int32_t keeps_subnormals(void) {
  volatile double smallest = DBL_MIN; /* of the normal ones; volatile, so that the processor computes */
  const double wide = smallest;
  volatile double subnormal = wide * 0.5;
  const double kept = subnormal;
#if USES_FLOAT_BITS
  volatile float smallest_float = FLT_MIN;
  const float narrow = smallest_float;
  volatile float subnormal_float = narrow * 0.5F;
  const float kept_float = subnormal_float;
  return (((kept * 2.0) >= wide) && ((kept_float * 2.0F) >= narrow)) ? 1 : 0;
#else
  return ((kept * 2.0) >= wide) ? 1 : 0;
#endif
}

#if USES_DOUBLE_OF || USES_IS_FINITE
static uint64_t bits_of(double value) {
  double_bits u;
  u.value = value;
  return u.bits;
}
#endif

#if USES_IS_FINITE
/* By its bits: where doubles are computed in software, a comparison is a call; and see is_finite_float. */
static int32_t is_finite(double value) {
  const uint64_t infinity = 0x7ff0000000000000U;
  return (int32_t)((bits_of(value) & infinity) != infinity);
}
#endif

#if USES_FLOAT_BITS
static uint32_t float_bits(float value) {
  union {
    float value;
    uint32_t bits;
  } u;
  u.value = value;
  return u.bits;
}

/* By its bits too: a compiler that takes every number for finite may leave a comparison out. */
static int32_t is_finite_float(float value) {
  const uint32_t infinity = 0x7f800000U;
  return (int32_t)((float_bits(value) & infinity) != infinity);
}
#endif

#if USES_DOUBLE_OF
static double double_of(uint64_t bits) {
  double_bits u;
  u.bits = bits;
  return u.value;
}
#endif

#if USES_FMA_FLOAT
/* a b + c, rounded once. */
static float fma_float(float a, float b, float c) {
#if HAS_FMA_FLOAT
  return __builtin_fmaf(a, b, c);
#else
  /* The product is exact in double. The sum is rounded to odd there, so that the second rounding, to float, is as if
     from the exact sum: Boldo and Melquiond, IEEE Trans. Computers 57 (2008). */
  const double product = (double)a * (double)b;
  const double wide = (double)c;
  const double sum = product + wide;
  const double from_c = sum - product;
  const double error = (product - (sum - from_c)) + (wide - from_c);
  uint64_t bits = bits_of(sum);
  if (((error < 0.0) || (error > 0.0)) && ((bits & 1U) == 0U)) {
    const uint64_t opposed = (bits ^ bits_of(error)) >> 63;
    bits = (opposed != 0U) ? (bits - 1U) : (bits + 1U);
  }
  return (float)double_of(bits);
#endif
}
#endif

#if USES_FMA_DOUBLE
#if !HAS_FMA_DOUBLE
/* A positive number: (high 2^64 + low) 2^exponent. */
typedef struct {
  uint64_t high;
  uint64_t low;
  int32_t exponent;
} wide_number;

/* The significand of a finite double and the power of two that it counts. */
static uint64_t significand_of(uint64_t bits, int32_t* exponent) {
  const int32_t field = (int32_t)((bits >> 52) & 0x7ffU);
  const uint64_t fraction = bits & 0x000fffffffffffffU;
  *exponent = ((field == 0) ? 1 : field) - 1075;
  return (field == 0) ? fraction : (fraction | 0x0010000000000000U);
}

static void shift_left(wide_number* x, int32_t by) {
  if (by >= 64) {
    x->high = x->low << (by - 64);
    x->low = 0U;
  } else if (by > 0) {
    x->high = (x->high << by) | (x->low >> (64 - by));
    x->low <<= by;
  } else {
    /* nothing to shift */
  }
  x->exponent -= by;
}

/* Shifts right; any bit that falls out sets the last bit to 1. */
static void shift_right_sticky(wide_number* x, int32_t by) {
  uint64_t lost = 0U;
  if (by >= 128) {
    lost = x->high | x->low;
    x->high = 0U;
    x->low = 0U;
  } else if (by >= 64) {
    lost = x->low;
    if (by > 64) {
      lost |= x->high << (128 - by);
    }
    x->low = (by == 64) ? x->high : (x->high >> (by - 64));
    x->high = 0U;
  } else if (by > 0) {
    lost = x->low << (64 - by);
    x->low = (x->low >> by) | (x->high << (64 - by));
    x->high >>= by;
  } else {
    /* nothing to shift */
  }
  if (lost != 0U) {
    x->low |= 1U;
  }
  x->exponent += by;
}

static int32_t leading_zeros(const wide_number* x) {
  int32_t count = 0;
  uint64_t part = x->high;
  if (part == 0U) {
    count = 64;
    part = x->low;
  }
  while ((part & 0x8000000000000000U) == 0U) {
    part <<= 1;
    ++count;
  }
  return count;
}

static wide_number product_of(uint64_t a, uint64_t b) {
  const uint64_t mask = 0xffffffffU;
  const uint64_t low = (a & mask) * (b & mask);
  const uint64_t cross = (a & mask) * (b >> 32);
  const uint64_t across = (a >> 32) * (b & mask);
  const uint64_t middle = (low >> 32) + (cross & mask) + (across & mask);
  wide_number x;
  x.low = (low & mask) | (middle << 32);
  x.high = ((a >> 32) * (b >> 32)) + (cross >> 32) + (across >> 32) + (middle >> 32);
  x.exponent = 0;
  return x;
}

/* Rounds to nearest, ties to even. x is not 0. */
static double round_wide(wide_number x, uint64_t sign) {
  uint64_t bits;
  int32_t field;
  int32_t zeros = leading_zeros(&x);
  shift_left(&x, zeros); /* the first bit is bit 127 */
  field = x.exponent + 127 + 1023;
  if (field >= 2047) {
    return double_of(sign | 0x7ff0000000000000U);
  }
  /* 53 bits stay above 75, fewer where the result is subnormal. */
  shift_right_sticky(&x, 11 + ((field < 1) ? (1 - field) : 0));
  bits = x.high;
  if (field >= 1) {
    bits += ((uint64_t)(uint32_t)(field - 1)) << 52;
  }
  if ((x.low > 0x8000000000000000U) || ((x.low == 0x8000000000000000U) && ((bits & 1U) != 0U))) {
    ++bits; /* a carry moves on to the exponent, as it should */
  }
  return double_of(sign | bits);
}

/* a b + c with integers, for processors without such an instruction. */
static double fma_with_integers(double a, double b, double c) {
  const uint64_t sign_bit = 0x8000000000000000U;
  const uint64_t infinity = 0x7ff0000000000000U;
  const uint64_t a_bits = bits_of(a);
  const uint64_t b_bits = bits_of(b);
  const uint64_t c_bits = bits_of(c);
  const uint64_t sign = (a_bits ^ b_bits) & sign_bit;
  const uint64_t c_sign = c_bits & sign_bit;
  int32_t a_exponent;
  int32_t b_exponent;
  int32_t zeros;
  wide_number x;
  wide_number y;
  if (((a_bits & infinity) == infinity) || ((b_bits & infinity) == infinity) || ((c_bits & infinity) == infinity)) {
    /* An infinite or undefined result has no rounding; a b must not overflow beside an infinite c. */
    if (((c_bits & ~sign_bit) == infinity) && ((a_bits & infinity) != infinity) && ((b_bits & infinity) != infinity)) {
      return c;
    }
    return (a * b) + c;
  }
  if (((a_bits & ~sign_bit) == 0U) || ((b_bits & ~sign_bit) == 0U)) {
    return (a * b) + c; /* the product is exact */
  }
  x = product_of(significand_of(a_bits, &a_exponent), significand_of(b_bits, &b_exponent));
  x.exponent = a_exponent + b_exponent;
  if ((c_bits & ~sign_bit) == 0U) {
    return round_wide(x, sign);
  }
  y.high = 0U;
  y.low = significand_of(c_bits, &y.exponent);
  /* Both with their first bit at 126, so that a sum has room; then the smaller one is moved to the larger's exponent.
     If bits fall out, the result keeps far more than it needs, so one sticky bit stands for them. */
  zeros = leading_zeros(&x);
  shift_left(&x, zeros);
  shift_right_sticky(&x, 1);
  zeros = leading_zeros(&y);
  shift_left(&y, zeros);
  shift_right_sticky(&y, 1);
  if (x.exponent > y.exponent) {
    shift_right_sticky(&y, x.exponent - y.exponent);
  } else {
    shift_right_sticky(&x, y.exponent - x.exponent);
  }
  if (sign == c_sign) {
    x.low += y.low;
    x.high += y.high + ((x.low < y.low) ? 1U : 0U);
    return round_wide(x, sign);
  }
  if ((x.high == y.high) && (x.low == y.low)) {
    return 0.0;
  }
  if ((x.high > y.high) || ((x.high == y.high) && (x.low > y.low))) {
    x.high -= y.high + ((x.low < y.low) ? 1U : 0U);
    x.low -= y.low;
    return round_wide(x, sign);
  }
  y.high -= x.high + ((y.low < x.low) ? 1U : 0U);
  y.low -= x.low;
  return round_wide(y, c_sign);
}
#endif

/* a b + c, rounded once. */
static double fma_double(double a, double b, double c) {
#if HAS_FMA_DOUBLE
  return __builtin_fma(a, b, c);
#else
  return fma_with_integers(a, b, c);
#endif
}
#endif

#if USES_SQUARE_ROOT
/* Returns the square root of x >= 0, rounded to nearest: the integer square root, bit by bit. */
static double square_root(double x) {
  uint64_t bits = bits_of(x);
  int32_t exponent = (int32_t)(bits >> 52) - 1075;
  uint64_t rest = bits & 0x000fffffffffffffU;
  uint64_t root = 0U;
  uint64_t remainder = 0U;
  int32_t i;
  if (x == 0.0) {
    return x;
  }
  if ((bits >> 52) >= 0x7ffU) {
    return x; /* infinite or undefined */
  }
  if ((bits >> 52) == 0U) {
    exponent = -1074;
    while ((rest & 0x0010000000000000U) == 0U) {
      rest <<= 1;
      --exponent;
    }
  }
  rest |= 0x0010000000000000U;
  if ((exponent & 1) != 0) {
    rest <<= 1;
    --exponent;
  }
  /* sqrt(rest 2^exponent): 54 bits of the root of rest 2^54, whose last one rounds. rest has 53 or 54 bits. */
  rest <<= 10;
  for (i = 0; i < 54; ++i) {
    const uint64_t next = (remainder << 2) | (rest >> 62);
    const uint64_t trial = (root << 2) | 1U;
    rest <<= 2;
    if (next >= trial) {
      remainder = next - trial;
      root = (root << 1) | 1U;
    } else {
      remainder = next;
      root <<= 1;
    }
  }
  /* root has 54 bits, the root's exponent is (exponent - 54) / 2 + ...: root 2^((exponent - 54) / 2). A root is never
     halfway between two doubles. */
  root = (root >> 1) + (root & 1U);
  exponent = ((exponent - 54) / 2) + 1;
  return double_of(((uint64_t)(uint32_t)(exponent + 1075 - 1) << 52) + root);
}
#endif
