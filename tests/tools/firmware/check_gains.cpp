// NAME_check of exported controllers: its answers beside the program's stability, and what it refuses.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "base/math/random.hpp"
#include "base/text.hpp"
#include "posterior/frf/stability.hpp"
#include "sim/streams.hpp"
#include "tests/tools/firmware/models.hpp"

namespace decid::tools {
namespace {

using namespace test;

/// Parameters, then the margins of delay and gain.
using Asked = std::array<double, 8>;

/// Reads sets from asked.bin and writes an answer per set; then checks what does not depend on numbers.
const std::string check_main =
    std::string("#include <math.h>\n#include <stdio.h>\n#include <string.h>\n#include \"c.h\"\n") + R"(
static int code(int member, double value, double delay_margin_s, double gain_margin) {
  c_parameters p = c_identified;
  double* const members[6] = {&p.kp, &p.kd, &p.kp_pass, &p.kd_pass, &p.theta, &p.delay};
  *members[member] = value;
  return c_check(&p, delay_margin_s, gain_margin);
}
int main(int argc, char** argv) {
  static const double bad[] = {-1.0, NAN, INFINITY, -INFINITY};
  double asked[8];
  FILE* const in = fopen(argv[1], "rb");
  FILE* const out = fopen(argv[2], "wb");
  int i, member;
  if (argc != 3 || in == NULL || out == NULL) return 2;
  while (fread(asked, sizeof asked, 1, in) == 1) {
    c_parameters p = c_identified;
    signed char answer;
    p.kp = asked[0];
    p.kd = asked[1];
    p.kp_pass = asked[2];
    p.kd_pass = asked[3];
    p.theta = asked[4];
    p.delay = asked[5];
    answer = (signed char)c_check(&p, asked[6], asked[7]);
    if (fwrite(&answer, 1, 1, out) != 1) return 2;
  }
  if (fclose(out) != 0) return 2;
  for (i = 0; i < 4; ++i) {
    for (member = 0; member < 6; ++member)
      if (code(member, bad[i], 0.0, 1.0) != C_ERROR_RANGE) return 3;
    if (c_check(NULL, bad[i], 1.0) != C_ERROR_RANGE || c_check(NULL, 0.0, bad[i]) != C_ERROR_RANGE) return 4;
  }
  if (c_check(NULL, 1.001, 1.0) != C_ERROR_RANGE || c_check(NULL, 0.0, 0.999) != C_ERROR_RANGE) return 5;
  if (c_check(NULL, 0.0, 100.1) != C_ERROR_RANGE || code(5, 1.001, 0.0, 1.0) != C_ERROR_RANGE) return 6;
  /* Gains whose squares are infinite, and a body that nothing holds. */
  for (member = 0; member < 4; ++member)
    if (code(member, 1e300, 0.0, 1.0) != C_ERROR_UNSTABLE) return 7;
  if (code(0, 0.0, 0.0, 1.0) != C_ERROR_UNSTABLE) return 8;
  for (member = 0; member < 4; ++member)
    if (code(member, 1.01e6 * C_MGH_NM_RAD, 0.0, 1.0) != C_ERROR_UNSTABLE) return 14;
  if (code(3, 0.99e6 * C_MGH_NM_RAD, 0.0, 1.0) != C_OK) return 15;
  /* The header's margins are of one change each, and they are the borders. */
  if (c_check(NULL, 0.0, 1.0) != C_OK || C_IS_STABLE != 1 || C_CHECKS_GAINS != 1) return 9;
  if (c_check(NULL, C_DELAY_MARGIN_S - 1e-6, 1.0) != C_OK) return 10;
  if (c_check(NULL, C_DELAY_MARGIN_S + 1e-6, 1.0) != C_ERROR_UNSTABLE) return 11;
  {
    const double margin = fmin(1.0 / C_GAIN_MARGIN_LOW, C_GAIN_MARGIN_HIGH);
    if (c_check(NULL, 0.0, margin - 1e-6) != C_OK) return 12;
    if (c_check(NULL, 0.0, margin + 1e-6) != C_ERROR_UNSTABLE) return 13;
  }
  return 0;
}
)";

/// Returns sets over and far beyond the ranges of a body: some of them stable, and some with a delay of 0 or with more
/// passive stiffness than m g h, or without damping.
std::vector<Asked> some_sets(const sim::Body& body, int count) {
  const Random random(11, sim::streams::vestibular_noise, 0);
  std::vector<Asked> sets;
  for (int k = 0; k < count; ++k) {
    const auto draw = [&](int i) { return random.uniform(static_cast<std::uint64_t>(8 * k + i)); };
    const double scale = body.mgh();
    sets.push_back({scale * 2.5 * draw(0), scale * draw(1), scale * 1.2 * draw(2), scale * 0.4 * draw(3), 0.001,
                    k % 7 == 0 ? 0.0 : 0.3 * draw(4), k % 5 == 0 ? 0.0 : 0.15 * draw(5),
                    k % 3 == 0 ? 1.0 : 1.0 + draw(6)});
    if (k % 11 == 0) sets.back()[1] = sets.back()[3] = 0.0;  // no damping
  }
  return sets;
}

/// Returns whether decid takes the loop to be stable, with a factor of kp and kd.
bool is_stable(const sim::Body& body, const Asked& of, double step_s, double factor) {
  sim::Coefficients c = sim::single_pendulum().family.coefficients(sim::single_pendulum().parameters.middle());
  using enum sim::Coefficient;
  c[kp] = factor * of[0];
  c[kd] = factor * of[1];
  c[kp_pass] = of[2];
  c[kd_pass] = of[3];
  c[delay] = (of[5] + step_s) + of[6];
  return frf::is_stable(body, sim::single_pendulum().family, c);
}

void check_answers(const std::string& options, const sim::Body& body, double step_s, const std::string& compiler) {
  CAPTURE(compiler);
  const Folder folder;
  run_ok("export controller --name c --quiet" + options + " -o " + folder / "c");
  const std::vector<Asked> sets = some_sets(body, 4000);
  std::string bytes(sets.size() * sizeof(Asked), '\0');
  std::memcpy(bytes.data(), sets.data(), bytes.size());
  write_text(folder / "asked.bin", bytes);
  write_text(folder / "main.c", check_main);
  compile(compiler + " -I " + folder / "c" + " -c " + folder / "c" + "/c.c -o " + folder / "c.o");
  REQUIRE(shell(std::string(DECID_C_COMPILER) + " -std=c99 -O1 -I " + folder / "c" + " " + folder / "main.c" + " " +
                folder / "c.o" + " -lm -o " + folder / "main") == 0);
  REQUIRE(shell(folder / "main" + " " + folder / "asked.bin" + " " + folder / "answers.bin") == 0);
  const std::string answers = read_text(folder / "answers.bin");
  REQUIRE(answers.size() == sets.size());
  int accepted = 0, differing = 0, unstable_between = 0, undamped = 0;
  for (std::size_t k = 0; k < sets.size(); ++k) {
    const double margin = sets[k][7];
    const bool expected = is_stable(body, sets[k], step_s, 1.0 / margin) && is_stable(body, sets[k], step_s, margin);
    differing += answers[k] != (expected ? 0 : -6) ? 1 : 0;
    if (answers[k] != 0) continue;
    ++accepted;
    undamped += sets[k][1] == 0.0 && sets[k][3] == 0.0 ? 1 : 0;
    // Both ends are stable, so is each factor between, with less delay too.
    for (int i = 0; i <= 20; ++i) {
      Asked less = sets[k];
      if (i % 2 == 1) less[6] = 0.0;
      unstable_between += is_stable(body, less, step_s, std::pow(margin, 0.1 * (i - 10))) ? 0 : 1;
    }
  }
  CHECK(differing == 0);
  CHECK(unstable_between == 0);
  CHECK(undamped == 0);
  CHECK(accepted > 300);
  CHECK(accepted < 3000);
}

}  // namespace

TEST_CASE("an exported controller checks gains as the program does: each answer, on other bodies and steps too") {
  check_answers("", sim::Body{}, 0.001, c99);
  const Folder folder;
  write_text(folder / "robot.json", R"({"body": {"mass_kg": 60, "com_height_m": 0.8, "inertia_kgm2": 42}})");
  check_answers(
      " --step 0.005 --kp 500 --kd 130 --kp-pass 120 --kd-pass 60 --delay 0.06 --protocol " + folder / "robot.json",
      sim::Body{60.0, 0.8, 42.0}, 0.005, "gcc -std=gnu99 -O0 -ffp-contract=off");
  if (have("clang++-14")) check_answers("", sim::Body{}, 0.001, "clang++-14 -x c++ -std=c++17 -O2");
}

// The counts are those of docs/guide/control-loop.md. A passive torque that motors apply as late as the active one is
// an active one of half its gains, because the active torque is 2 (kp a + kd a'). One that is late by the margin only,
// as of motors without the controller's delay, is covered too.
TEST_CASE(
    "gains that the check accepts hold the body in a loop with the margins' latency and motors that are off by them, "
    "and "
    "with a late passive torque if its halves are checked as active gains") {
  const Folder folder;
  run_ok("export controller --name c --quiet -o " + folder / "c");
  // A body of a sine, from a lean of 0.1 degrees: 1 if it stands and its last swings are no larger than earlier ones.
  // passive_steps: of the passive torque's lateness, -1 for the body's own stiffness.
  write_text(folder / "main.c",
             std::string("#include <math.h>\n#include <stddef.h>\n#include <stdio.h>\n#include \"c.h\"\n") + R"(
static c_state state;
static double line[256], passive_line[256];
static int stands(const c_parameters* p, int late_steps, int passive_steps, double gain) {
  double sway = 0.002, rate = 0.0, early = 0.0, late = 0.0;
  int i;
  if (c_begin(&state, p) != C_OK) return 0;
  for (i = 0; i < 256; ++i) line[i] = passive_line[i] = 0.0;
  for (i = 0; i < 120000; ++i) {
    double torque = 0.0;
    if (c_step(&state, sway, rate, 0.0, 0.0, &torque) != C_OK) return 0;
    line[i % 256] = gain * torque;
    passive_line[i % 256] = c_passive(&state, sway, rate);
    torque = line[(i + 256 - late_steps) % 256];
    torque += (passive_steps < 0) ? passive_line[i % 256] : gain * passive_line[(i + 256 - passive_steps) % 256];
    rate += C_STEP_S * (C_MGH_NM_RAD * sin(sway) + torque) / C_INERTIA_KGM2;
    sway += C_STEP_S * rate;
    if (!(fabs(sway) < 0.5)) return 0;
    if (i >= 30000 && i < 60000) early = fmax(early, fabs(sway));
    if (i >= 90000) late = fmax(late, fabs(sway));
  }
  return late <= early;
}
static double next(unsigned* seed) {
  *seed = *seed * 1664525U + 1013904223U;
  return (double)(*seed >> 8) / 16777216.0;
}
int main(void) {
  int accepted = 0, refused = 0, fell = 0, stood = 0, late_fell = 0, k;
  int halves = 0, halves_fell = 0, halves_fell_as_late = 0, refused_halves_stood_as_late = 0;
  unsigned seed = 1U;
  for (k = 0; k < 60; ++k) {
    c_parameters p = c_identified, half;
    const int late_steps = (int)(50.0 * next(&seed));
    const double gain = 1.0 + next(&seed);
    int own, late, as_late, delay_steps;
    p.kp = C_MGH_NM_RAD * (0.5 + 1.5 * next(&seed));
    p.kd = C_MGH_NM_RAD * 0.6 * next(&seed);
    p.kp_pass = C_MGH_NM_RAD * 0.5 * next(&seed);
    p.kd_pass = C_MGH_NM_RAD * 0.2 * next(&seed);
    p.delay = 0.15 * next(&seed);
    p.theta = 0.0;
    own = stands(&p, late_steps, -1, gain) && stands(&p, late_steps, -1, 1.0 / gain) && stands(&p, 0, -1, gain) && stands(&p, 0, -1, 1.0);
    late = stands(&p, late_steps, late_steps, gain) && stands(&p, late_steps, late_steps, 1.0 / gain) && stands(&p, 0, 0, gain);
    delay_steps = (int)(p.delay / C_STEP_S + 0.5);
    as_late = stands(&p, late_steps, delay_steps + late_steps, gain) && stands(&p, late_steps, delay_steps + late_steps, 1.0 / gain) && stands(&p, 0, delay_steps, gain);
    if (c_check(&p, late_steps * C_STEP_S, gain) == C_OK) {
      ++accepted;
      fell += !own;
      late_fell += !late;
    } else {
      ++refused;
      stood += own;
    }
    half = p;
    half.kp += 0.5 * p.kp_pass;
    half.kd += 0.5 * p.kd_pass;
    half.kp_pass = half.kd_pass = 0.0;
    if (c_check(&half, late_steps * C_STEP_S, gain) == C_OK) {
      ++halves;
      halves_fell += !late;
      halves_fell_as_late += !as_late;
    } else {
      refused_halves_stood_as_late += as_late;
    }
  }
  printf("%d accepted, %d fell; %d refused, %d stood; %d of the accepted fell with a late passive torque; ", accepted, fell, refused, stood, late_fell);
  printf("%d halves accepted, %d and %d fell; %d of the others stood\n", halves, halves_fell, halves_fell_as_late, refused_halves_stood_as_late);
  return 0;
}
)");
  REQUIRE(shell(c99 + "-I " + folder / "c" + " " + folder / "main.c" + " " + folder / "c" + "/c.c -lm -o " +
                folder / "main") == 0);
  REQUIRE(shell("(" + folder / "main" + " >" + folder / "counts.txt" + ")") == 0);
  CHECK(read_text(folder / "counts.txt") ==
        "36 accepted, 0 fell; 24 refused, 0 stood; 1 of the accepted fell with a late passive torque; "
        "28 halves accepted, 0 and 0 fell; 0 of the others stood\n");
}

// A compiler's or an editor's error in the check alone, which no step of the controller computes.
TEST_CASE("a controller's self-test covers the check of gains") {
  const Folder folder;
  run_ok("export controller --name c --quiet -o " + folder / "c");
  const std::string source = read_text(folder / "c" + "/c.c");
  write_text(folder / "main.c",
             "#include \"c.h\"\n"
             "static c_state state;\nint main(void) { return (c_self_test(&state) == EXPECTED) ? 0 : 1; }\n");
  const auto answers = [&](const std::string& changed, const std::string& expected) {
    write_text(folder / "c" + "/c.c", changed);
    REQUIRE(shell(std::string(DECID_C_COMPILER) + " -std=c99 -O1 -DEXPECTED=" + expected + " -I " + folder / "c" + " " +
                  folder / "main.c" + " " + folder / "c" + "/c.c -o " + folder / "main") == 0);
    return shell(folder / "main") == 0;
  };
  CHECK(answers(source, "C_OK"));
  for (const auto& [right, wrong] :
       std::vector<std::pair<std::string, std::string>>{{"pi_high = 3.141592653589793116", "pi_high = 3.1416"},
                                                        {"-0.33333333333330150769", "-0.3333"},
                                                        {"2.0 * kd * kd", "2.001 * kd * kd"},
                                                        {"(4.0 * kp * kp)", "(4.001 * kp * kp)"}}) {
    const std::string& mistake = wrong;
    CAPTURE(mistake);
    REQUIRE(contains(source, right));
    std::string changed = source;
    changed.replace(changed.find(right), right.size(), wrong);
    CHECK(answers(changed, "C_ERROR_SELF_TEST"));
  }
}

TEST_CASE("a controller without a check of gains says so, and has none") {
  const Folder folder;
  for (const char* controller : {"dec2015", "ic"}) {
    CAPTURE(controller);
    run_ok("export controller --name c --quiet --controller " + std::string(controller) + " -o " + folder / controller);
    const std::string header = read_text(folder / controller + "/c.h");
    CHECK(contains(header, "#define C_CHECKS_GAINS 0\n"));
    CHECK(!contains(header, "c_check("));
  }
}

}  // namespace decid::tools
