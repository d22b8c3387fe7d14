#if USES_PHASE
/* Angle of (x, y) in (-pi, pi], both finite: atan2_lanes of decid's base/math/math_lanes.hpp, for one value. */
static double angle_of(double y, double x) {
  static const double coefficient[10] = {0.021259853041374648389,  -0.043590960689364359747, 0.056925393114080000979,
                                         -0.066411212591859809478, 0.076900683088481778084,  -0.090907824130680211688,
                                         0.11111106653612671953,   -0.14285714195261893414,  0.19999999999088961715,
                                         -0.33333333333330150769};
  const double pi_high = 3.141592653589793116;
  const double pi_low = 1.2246467991473532072e-16;
  const double three_quarters_high = 2.3561944901923448370;
  const double three_quarters_low = 9.1848509936051484375e-17;
  const double width = (x < 0.0) ? -x : x;
  const double height = (y < 0.0) ? -y : y;
  const int32_t steep = (height > width) ? 1 : 0;
  const int32_t left = (x < 0.0) ? 1 : 0;
  double small = (steep != 0) ? width : height;
  double large = (steep != 0) ? height : width;
  double scale = 1.0;
  int32_t turned;
  double r;
  double z;
  double sum;
  double tail;
  double sign;
  double high = 0.0;
  double low = 0.0;
  double part;
  double top;
  double angle;
  int32_t i;
  if (large == 0.0) {
    large = 1.0;
  }
  if (large > 1.0715086071862673e301) {
    scale = 7.8886090522101181e-31;
  } else if (large < 1.1830521861667747e-271) {
    scale = 1.6069380442589903e60;
  } else {
    /* in range */
  }
  small = small * scale;
  large = large * scale;
  turned = (small > (large * 0.41421356237309503)) ? 1 : 0;
  r = ((turned != 0) ? (small - large) : small) / ((turned != 0) ? (small + large) : large);
  z = r * r;
  sum = coefficient[0];
  for (i = 1; i < 10; ++i) {
    sum = (sum * z) + coefficient[i];
  }
  tail = r * z * sum;
  if (steep != 0) {
    high = pi_high / 2.0;
    low = pi_low / 2.0;
    sign = (left != 0) ? 1.0 : -1.0;
  } else {
    high = (left != 0) ? pi_high : 0.0;
    low = (left != 0) ? pi_low : 0.0;
    sign = (left != 0) ? -1.0 : 1.0;
  }
  if (turned != 0) {
    if (left != 0) {
      high = three_quarters_high;
      low = three_quarters_low;
    } else {
      high = high + (sign * (pi_high / 4.0));
      low = low + (sign * (pi_low / 4.0));
    }
  }
  part = sign * r;
  top = high + part;
  angle = top + ((part - (top - high)) + (low + (sign * tail)));
  return (y < 0.0) ? -angle : angle;
}
#endif
