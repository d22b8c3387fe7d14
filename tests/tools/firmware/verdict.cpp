// The verdict of examples/firmware on an identification: each reason alone, and trials that it must and must not
// accept.
#include "base/text.hpp"
#include "tests/tools/firmware/models.hpp"

namespace decid::tools {
namespace {

using namespace test;

const std::string example = DECID_SOURCE_DIR "/examples/firmware";

/// Compiles the verdict with a main and other sources, and runs it with the arguments.
void check_run(const Folder& folder, const std::string& main, const std::string& sources,
               const std::string& arguments = {}) {
  test::write_text(folder / "main.c", "#include <stdio.h>\n#include \"posture.h\"\n#include \"verdict.h\"\n" + main);
  compile(c99 + "-I " + folder / "c" + " -I " + example + " " + folder / "main.c " + example + "/verdict.c " + sources +
          " -o " + folder / "main");
  CHECK(shell(folder / "main" + arguments) == 0);
}

/// Deviations and distance of any size, for the header of a model that has them.
const std::string stand_ins = R"(
static float width(int p) {
  static const float low[] = POSTURE_MINIMA, high[] = POSTURE_MAXIMA;
  return high[p] - low[p];
}
#if POSTURE_GIVES_STDDEVS
static float part[POSTURE_PARAMETERS];
static int stddevs_result = POSTURE_OK;
int posture_stddevs(float* stddevs, void* arena) {
  int p;
  (void)arena;
  for (p = 0; p < POSTURE_PARAMETERS; ++p) stddevs[p] = part[p] * width(p);
  return stddevs_result;
}
#endif
#if POSTURE_GIVES_DISTANCE
static double given = 0.5;
static int distance_result = POSTURE_OK;
int posture_distance(double* distance, void* arena) {
  (void)arena;
  *distance = given;
  return distance_result;
}
#endif
static float value[POSTURE_PARAMETERS];
static void centre(void) {
  static const float low[] = POSTURE_MINIMA;
  int p;
  for (p = 0; p < POSTURE_PARAMETERS; ++p) value[p] = low[p] + 0.5F * width(p);
}
#define IS(verdict) do { if (judge(POSTURE_OK, value, NULL) != (verdict)) { printf("line %d\n", __LINE__); return 1; } } while (0)
)";

}  // namespace

TEST_CASE("the example's verdict: return codes and ranges") {
  const Folder folder;
  run_ok("export c " + test::firmware_model + " --name posture --quiet -o " + folder / "c");
  check_run(folder, stand_ins + R"(
int main(void) {
  static const float low[] = POSTURE_MINIMA, high[] = POSTURE_MAXIMA;
  const float infinite = 1e38F * 1e38F;
  int p;
  centre();
  IS(VERDICT_USABLE);
  for (p = POSTURE_ERROR_SELF_TEST; p <= POSTURE_MORE; ++p)
    if (p != POSTURE_OK && judge(p, value, NULL) != VERDICT_NOT_USABLE) return 2;
  for (p = 0; p < POSTURE_PARAMETERS; ++p) {
    value[p] = high[p] + 0.04F * width(p);
    IS(VERDICT_USABLE);
    value[p] = high[p] + 0.06F * width(p);
    IS(VERDICT_CAUTION);
    value[p] = high[p] + 1.1F * width(p);
    IS(VERDICT_NOT_USABLE);
    value[p] = infinite;
    IS(VERDICT_NOT_USABLE);
    value[p] = infinite - infinite;
    IS(VERDICT_NOT_USABLE);
    value[p] = low[p] - 0.04F * width(p);
    IS(VERDICT_USABLE);
    value[p] = low[p] - 0.06F * width(p);
    IS(value[p] < 0.0F ? VERDICT_NOT_USABLE : VERDICT_CAUTION);
    value[p] = -0.1F * width(p);
    IS(VERDICT_NOT_USABLE);
    centre();
  }
  /* A caution does not hide a worse reason behind it. */
  value[POSTURE_KP] = high[POSTURE_KP] + 0.06F * width(POSTURE_KP);
  value[POSTURE_THETA] = -1.0F;
  IS(VERDICT_NOT_USABLE);
  return 0;
}
)",
            "");
}

TEST_CASE("the example's verdict: deviations and distance") {
  const Folder folder;
  run_ok("export c --ood-score --name posture --quiet -o " + folder / "c");
  const std::string header = read_text(folder / "c/posture.h");
  CHECK(contains(header, "#define POSTURE_DISTANCE_USABLE 0.77\n"));
  CHECK(contains(header, "#define POSTURE_DISTANCE_NOT_USABLE 1.17\n"));
  check_run(folder, stand_ins + R"(
int main(void) {
  int p;
  centre();
  IS(VERDICT_USABLE);
  for (p = 0; p < POSTURE_PARAMETERS; ++p) {
    const int decides = (p == POSTURE_KP || p == POSTURE_KD || p == POSTURE_DELAY);
    part[p] = 0.19F;
    IS(VERDICT_USABLE);
    part[p] = 0.21F;
    IS(decides ? VERDICT_CAUTION : VERDICT_USABLE);
    part[p] = 0.0F;
  }
  stddevs_result = POSTURE_ERROR_NOT_FINITE;
  IS(VERDICT_NOT_USABLE);
  stddevs_result = POSTURE_OK;
  given = 0.99;
  IS(VERDICT_USABLE);
  given = 1.01;
  IS(VERDICT_CAUTION);
  given = 1.16;
  IS(VERDICT_CAUTION);
  given = 1.18;
  IS(VERDICT_NOT_USABLE);
  given = 0.5;
  distance_result = POSTURE_ERROR_STATE;
  IS(VERDICT_NOT_USABLE);
  return 0;
}
)",
            "");
}

TEST_CASE("the example's verdict of the built-in model: a simulated trial, and the trial with the other sign") {
  const Folder folder;
  run_ok("export c --ood-score --name posture --quiet -o " + folder / "c");
  run_ok("simulate --seed 20 --nv 0.2 --quiet -o " + folder / "t.csv");
  run_ok("export sway " + folder / "t.csv" + " --quiet -o " + folder / "0.bin");
  const std::string bytes = read_text(folder / "0.bin");
  std::vector<float> sway(bytes.size() / sizeof(float));
  std::memcpy(sway.data(), bytes.data(), bytes.size());
  for (float& value : sway) value = -value;
  test::write_text(folder / "2.bin", test::as_bytes(sway));
  check_run(folder, R"(
static posture_arena arena;
static float sway[POSTURE_SAMPLES];
int main(int count, char** files) {
  float parameters[POSTURE_PARAMETERS];
  int file;
  for (file = 1; file < count; ++file) {
    FILE* const in = fopen(files[file], "rb");
    verdict found;
    if (in == NULL || fread(sway, sizeof sway, 1, in) != 1) return 2;
    fclose(in);
    found = judge(posture_identify(sway, parameters, &arena), parameters, &arena);
    printf("verdict %d\n", (int)found);
    if (found != (file == 1 ? VERDICT_USABLE : VERDICT_NOT_USABLE)) return 3;
  }
  return judge(posture_identify(NULL, parameters, &arena), parameters, &arena) == VERDICT_NOT_USABLE ? 0 : 4;
}
)",
            folder / "c/posture.c", " " + folder / "0.bin" + " " + folder / "2.bin");
}

}  // namespace decid::tools
