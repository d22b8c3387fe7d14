// The decimator of examples/firmware: its delay and gain, as docs/guide/control-loop.md has them.
#include "tests/tools/firmware/models.hpp"

namespace decid::tools {

using namespace test;

TEST_CASE("the example's decimator delays by 9 ms, keeps the sway and removes what would alias onto it") {
  const Folder folder;
  test::write_text(folder / "main.c", std::string("#include <math.h>\n#include <stdio.h>\n#include \"decimator.h\"\n") +
                                          R"(
static const double pi = 3.14159265358979323846;
static decimator state;
/* Returns the amplitude of the values in phase with the input at their own times; error: what else they have. */
static double gain(double hz, double* error) {
  double in_phase = 0.0, quadrature = 0.0, worst = 0.0;
  static float values[1000];
  int sample, value, values_made = 0;
  decimator_begin(&state);
  for (sample = 0; sample < 10000; ++sample)
    if (decimator_take(&state, (float)sin(2.0 * pi * hz * (sample * 0.001) + 0.3), &values[values_made]) == 1) {
      if (sample != 10 * values_made + DECIMATOR_DELAY_SAMPLES) return -1.0;
      ++values_made;
    }
  if (values_made != 1000) return -1.0;
  for (value = 100; value < 1000; ++value) {
    in_phase += 2.0 / 900.0 * (double)values[value] * sin(2.0 * pi * hz * (value * 0.01) + 0.3);
    quadrature += 2.0 / 900.0 * (double)values[value] * cos(2.0 * pi * hz * (value * 0.01) + 0.3);
  }
  for (value = 100; value < 1000; ++value)
    worst = fmax(worst, fabs((double)values[value] - in_phase * sin(2.0 * pi * hz * (value * 0.01) + 0.3)));
  *error = worst + fabs(quadrature);
  return in_phase;
}
int main(void) {
  double error = 0.0, at_2_hz, at_5_hz;
  int hz;
  at_2_hz = gain(2.0, &error);
  if (!(error < 1e-6)) return 1; /* no delay after the shift */
  at_5_hz = gain(5.0, &error);
  if (!(error < 1e-6)) return 2;
  printf("%f %f\n", at_2_hz, at_5_hz);
  if (!(fabs(at_2_hz - 0.9987) < 5e-5 && fabs(at_5_hz - 0.9919) < 5e-5)) return 3;
  for (hz = 95; hz <= 105; ++hz)
    if (!(fabs(gain((double)hz, &error)) < 0.0029)) return 4;
  return 0;
}
)");
  const std::string example = DECID_SOURCE_DIR "/examples/firmware";
  compile(c99 + "-I " + example + " " + folder / "main.c" + " " + example + "/decimator.c -lm -o " + folder / "main");
  CHECK(shell(folder / "main") == 0);
}

}  // namespace decid::tools
