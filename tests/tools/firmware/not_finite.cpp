// Exported C and what is no number: flags that would hide it, self-tests that feed it, pools that pass it on, states
// that were never begun.
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

#include "base/text.hpp"
#include "nn/network_file.hpp"
#include "tests/tools/firmware/models.hpp"
#include "tools/firmware/c_text.hpp"
#include "tools/firmware/text.hpp"

namespace decid::tools {
namespace {

using namespace test;

std::vector<std::string> compilers() {
  std::vector<std::string> all{DECID_C_COMPILER};
  for (const char* other : {"gcc", "clang-14"})
    if (test::have(other) && other != all.front()) all.emplace_back(other);
  return all;
}

/// A shell's exit code, without a message where it is not 0.
int quiet_code(const std::string& command) {
  const int status = std::system((command + " >/dev/null 2>&1 </dev/null").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// Compiles folder/c/NAME.c with a main and runs it: its exit code.
int run_main(const Folder& folder, const std::string& name, const std::string& compiler, const std::string& main) {
  const std::string c = folder / "c";
  test::write_text(folder / "main.c", "#include <math.h>\n#include <stdio.h>\n#include \"" + name + ".h\"\n" + main);
  compile(compiler + " -I " + c + " -c " + c + "/" + name + ".c -o " + folder / "c.o");
  REQUIRE(shell(std::string(DECID_C_COMPILER) + " -std=gnu99 -O1 -I " + c + " " + folder / "main.c" + " " +
                folder / "c.o" + " -lm -o " + folder / "main") == 0);
  return quiet_code(folder / "main");
}

void replace_in(const std::string& path, const std::string& what, const std::string& by) {
  const std::string text = test::read_text(path);
  REQUIRE(contains(text, what));
  test::write_text(path, replaced(text, what, by));
}

/// A small model of one column of pixels, whose first convolution makes infinity of 2 and whose second NaN of that.
Model overflowing_model(const std::string& pool) {
  Model model = test::made_up_model(sim::short_protocol(), {.channels = {dataset::Channel::sway}, .block = 600},
                                    "conv 1 1x1; conv 1 1x1; " + pool + "; fc 7");
  for (const std::size_t layer : {0U, 1U})
    for (nn::Parameter<float>& p : model.network.layers()[layer].parameters()) p.value.assign(p.value.size(), 0.0F);
  model.network.layers()[0].parameters()[0].value[0] = std::numeric_limits<float>::max();
  return model;
}

}  // namespace

TEST_CASE("exported C is refused by compilers that may take NaN for a number") {
  const Folder folder;
  const std::string c = folder / "c";
  run_ok("export controller --name controller --quiet -o " + c);
  run_ok("export c " + test::firmware_model + " --name model --quiet -o " + c);
  for (const std::string& compiler : compilers())
    for (const char* name : {"controller", "model"}) {
      const auto compiled = [&](const std::string& flags) {
        return quiet_code(compiler + " -std=c99 " + flags + " -I " + c + " -c " + c + "/" + name + ".c -o " +
                          folder / "c.o");
      };
      CAPTURE(compiler);
      CAPTURE(name);
      CHECK(compiled("-O2") == 0);
      CHECK(compiled("-O2 -fno-math-errno") == 0);
      for (const char* flags : {"-O2 -ffast-math", "-O2 -ffinite-math-only", "-Ofast"}) {
        CAPTURE(flags);
        CHECK(compiled(flags) != 0);
      }
    }
}

TEST_CASE("an exported controller detects NaN by its bits, and a state that was never initialised") {
  const Folder folder;
  run_ok("export controller --name controller --quiet -o " + folder / "c");
  const std::string main = R"(
static controller_state state, never;
int main(void) {
  controller_parameters p = controller_identified;
  double torque = 7.0, bad[3];
  int i, k;
  bad[0] = (double)NAN; bad[1] = (double)INFINITY; bad[2] = -(double)INFINITY;
  if (controller_step(&never, 0.01, 0.0, 0.0, 0.0, &torque) != CONTROLLER_ERROR_STATE) return 1;
  if (controller_step_scaled(&never, 0.01, 0.0, 0.0, 0.0, &torque) != CONTROLLER_ERROR_STATE) return 2;
  if (torque != 7.0 || !isnan(controller_passive(&never, 0.01, 0.0)) || !isnan(controller_passive(NULL, 0.0, 0.0)))
    return 3;
  p.delay = bad[0];
  if (controller_begin(&never, &p) != CONTROLLER_ERROR_RANGE) return 4;
  if (controller_step(&never, 0.01, 0.0, 0.0, 0.0, &torque) != CONTROLLER_ERROR_STATE) return 5;
  if (controller_begin(&state, NULL) != CONTROLLER_OK) return 6;
  for (k = 0; k < 3; ++k) {
    p = controller_identified; p.delay = bad[k];
    if (controller_begin(&state, &p) != CONTROLLER_ERROR_RANGE) return 7;
    p = controller_identified; p.kp = bad[k];
    if (controller_begin(&state, &p) != CONTROLLER_ERROR_RANGE) return 8;
    for (i = 0; i < 4; ++i) {
      double in[4] = {0.01, 0.0, 0.001, 0.0};
      in[i] = bad[k];
      if (controller_step(&state, in[0], in[1], in[2], in[3], &torque) != CONTROLLER_ERROR_NOT_FINITE) return 9;
    }
  }
  /* The parameters that were refused left the state as it was. */
  if (torque != 7.0 || controller_step(&state, 0.01, 0.0, 0.0, 0.0, &torque) != CONTROLLER_OK) return 10;
  return 0;
}
)";
  for (const std::string& compiler : compilers()) {
    CAPTURE(compiler);
    CHECK(run_main(folder, "controller", compiler + " -std=c99 -O2", main) == 0);
    // Who talks the preprocessor out of it still has these errors, except where clang of version 17 and later marks
    // arguments as numbers (nofpclass), which no code can undo.
    if (compiler.find("clang-19") != std::string::npos) continue;
    CHECK(run_main(folder, "controller", compiler + " -std=c99 -O2 -ffast-math -U__FAST_MATH__ -U__FINITE_MATH_ONLY__",
                   main) == 0);
  }
}

TEST_CASE("an exported controller refuses inputs whose torque is infinite, and gains below 0") {
  const Folder folder;
  run_ok("export controller --controller dec2015 --name controller --quiet -o " + folder / "c");
  const std::string main = R"(
static controller_state state;
int main(void) {
  controller_parameters p = controller_identified;
  double torque = 7.0, large = 1e308;
  int i;
  if (controller_begin(&state, NULL) != CONTROLLER_OK) return 1;
  if (controller_step(&state, large, 0.0, 0.0, 0.0, &torque) != CONTROLLER_ERROR_NOT_FINITE || torque != 7.0) return 2;
  while (controller_step(&state, large, 0.0, 0.0, 0.0, &torque) != CONTROLLER_OK) large *= 0.5;
  if (large < 1e300) return 3;
  for (i = 0; i < 2000; ++i) {
    const double sway = (i == 0) ? -large : 0.0;
    if (controller_step(&state, sway, 0.0, 0.0, 0.0, &torque) != CONTROLLER_OK || !isfinite(torque)) return 4;
  }
  if (!isnan(controller_passive(&state, 1e308, 0.0)) || !isfinite(controller_passive(&state, 0.01, 0.0))) return 5;
  p.tilt_gain = -0.5;
  if (controller_begin(&state, &p) != CONTROLLER_ERROR_RANGE) return 6;
  p = controller_identified; p.slow_gain = -0.1;
  if (controller_begin(&state, &p) != CONTROLLER_ERROR_RANGE) return 7;
  p = controller_identified; p.slow_gain = 0.0;
  return (controller_begin(&state, &p) == CONTROLLER_OK) ? 0 : 8;
}
)";
  CHECK(run_main(folder, "controller", c99, main) == 0);
}

TEST_CASE("self-tests of exported C feed NaN: they fail where it passes for a number") {
  const Folder folder;
  const std::string c = folder / "c";
  const std::string compiler = std::string(DECID_C_COMPILER) + " -std=c99 -O1";
  run_ok("export controller --name controller --quiet -o " + c);
  const std::string controller_main =
      "static controller_state state;\nint main(void) { return (controller_self_test(&state) == %s) ? 0 : 1; }\n";
  const auto main_of = [](const std::string& text, const char* code) { return replaced(text, "%s", code); };
  CHECK(run_main(folder, "controller", compiler, main_of(controller_main, "CONTROLLER_OK")) == 0);
  replace_in(c + "/controller.c", "((bits_of(value) & infinity) != infinity)",
             "((bits_of(value) & infinity) <= infinity)");
  CHECK(run_main(folder, "controller", compiler, main_of(controller_main, "CONTROLLER_ERROR_SELF_TEST")) == 0);

  const std::string model_main =
      "static model_arena arena;\nint main(void) { return (model_self_test(&arena) == %s) ? 0 : 1; }\n";
  for (const std::string& model : {std::string(DECID_SOURCE_DIR "/models/ideal.safetensors"), test::firmware_model}) {
    CAPTURE(model);
    run_ok("export c " + model + " --name model --quiet -o " + c);
    CHECK(run_main(folder, "model", compiler, main_of(model_main, "MODEL_OK")) == 0);
    replace_in(c + "/model.c", "((float_bits(value) & infinity) != infinity)",
               "((float_bits(value) & infinity) <= infinity)");
    CHECK(run_main(folder, "model", compiler, main_of(model_main, "MODEL_ERROR_SELF_TEST")) == 0);
  }
}

TEST_CASE("self-tests of exported C fail where the processor flushes subnormal numbers") {
#if defined(__SSE2__)
  const Folder folder;
  nn::Network<float> network(nn::Shape{2, 3, 3}, "conv 4 3x3; relu; fc 3");
  network.initialise(3);
  nn::write_network(network, folder / "n.safetensors");
  run_ok("export controller --name controller --quiet -o " + folder / "c");
  run_ok("export c " + test::firmware_model + " --name model --quiet -o " + folder / "c");
  run_ok("export c " + folder / "n.safetensors" + " --name alone --quiet -o " + folder / "c");
  for (const auto& [name, memory, error] :
       {std::array{"controller", "state", "CONTROLLER"}, {"model", "arena", "MODEL"}, {"alone", "arena", "ALONE"}}) {
    const std::string exported = name;
    CAPTURE(exported);
    const std::string self_test = format("%s_self_test(&memory) != %s_", name, error);
    // Flushed where they arise, where they are read, and both.
    const std::string main = format("#include <xmmintrin.h>\nstatic %s_%s memory;\nint main(void) {\n", name, memory) +
                             "  const unsigned mode = _mm_getcsr();\n  if (" + self_test + "OK) return 1;\n" +
                             "  _mm_setcsr(mode | 0x8000U);\n  if (" + self_test + "ERROR_SELF_TEST) return 2;\n" +
                             "  _mm_setcsr(mode | 0x0040U);\n  if (" + self_test + "ERROR_SELF_TEST) return 3;\n" +
                             "  _mm_setcsr(mode | 0x8040U);\n  if (" + self_test + "ERROR_SELF_TEST) return 4;\n" +
                             "  _mm_setcsr(mode);\n  return (" + self_test + "OK) ? 5 : 0;\n}\n";
    CHECK(run_main(folder, name, c99, main) == 0);
  }
#endif
}

TEST_CASE("exported C is refused by compilers whose double is not of 64 bits, or whose float is not of 32") {
  const Folder folder;
  const std::string c = folder / "c";
  run_ok("export controller --name controller --quiet -o " + c);
  run_ok("export c " + test::firmware_model + " --name model --quiet -o " + c);
  const std::string other = folder / "other";
  std::filesystem::create_directory(other);
  for (const char* digits : {"", "DBL_MANT_DIG", "FLT_MANT_DIG"}) {
    CAPTURE(digits);
    const std::string name = digits;
    test::write_text(other + "/float.h", "#include_next <float.h>\n" +
                                             (name.empty() ? "" : "#undef " + name + "\n#define " + name + " 11\n"));
    for (const char* file : {"/controller.c", "/model.c"})
      CHECK((quiet_code(std::string(DECID_C_COMPILER) + " -std=c99 -I " + other + " -I " + c + " -c " + c + file +
                        " -o " + folder / "c.o") == 0) == name.empty());
  }
}

TEST_CASE("exported C whose outputs are not finite says so, and writes nothing") {
  const Folder folder;
  run_ok("export c " + test::firmware_model + " --name model --ood-score --incremental --quiet -o " + folder / "c");
  const std::string of_model = R"(
static model_arena arena;
static float image[MODEL_IMAGE_CHANNELS * MODEL_IMAGE_ROWS * MODEL_IMAGE_COLUMNS], sway[MODEL_SAMPLES];
int main(void) {
  float parameters[MODEL_PARAMETERS];
  double distance = 7.0;
  int i, count = (int)(sizeof image / sizeof image[0]);
  for (i = 0; i < MODEL_PARAMETERS; ++i) parameters[i] = 7.0F;
  for (i = 0; i < count; ++i) image[i] = (i % 2 == 0) ? 3e38F : -3e38F;
  if (model_identify_image(image, parameters, &arena) != MODEL_ERROR_NOT_FINITE) return 1;
  if (model_distance(&distance, &arena) != MODEL_ERROR_NOT_FINITE || distance != 7.0) return 2;
  for (i = 0; i < MODEL_PARAMETERS; ++i)
    if (parameters[i] != 7.0F) return 3;
  if (model_identify(sway, parameters, &arena) != MODEL_OK || model_distance(&distance, &arena) != MODEL_OK) return 4;
  return (isfinite(parameters[0]) && isfinite(distance)) ? 0 : 5;
}
)";
  CHECK(run_main(folder, "model", c99, of_model) == 0);

  nn::Network<float> network(nn::Shape{2, 1, 1}, "fc 3");
  network.initialise(3);
  for (nn::Parameter<float>* p : network.parameters()) p->value.assign(p->value.size(), 1.0F);
  nn::write_network(network, folder / "n.safetensors");
  run_ok("export c " + folder / "n.safetensors" + " --name alone --quiet -o " + folder / "c");
  const std::string of_network = R"(
static alone_arena arena;
int main(void) {
  float input[2] = {3e38F, 3e38F}, outputs[3] = {7.0F, 7.0F, 7.0F};
  if (alone_run(input, outputs, &arena) != ALONE_ERROR_NOT_FINITE) return 1;
  if (outputs[0] != 7.0F || outputs[1] != 7.0F || outputs[2] != 7.0F) return 2;
  input[1] = -3e38F;
  return (alone_run(input, outputs, &arena) == ALONE_OK && outputs[2] == 0.0F) ? 0 : 3;
}
)";
  CHECK(run_main(folder, "alone", c99, of_network) == 0);

  const dataset::ImageSettings pixels{.channels = {dataset::Channel::sway}, .block = 600};
  const Model mixture = test::made_up_model(sim::short_protocol(), pixels, "fc 72", mixture_head(2));
  test::write_text(folder / "m.safetensors", to_bytes(mixture));
  run_ok("export c " + folder / "m.safetensors" + " --name model --quiet -o " + folder / "c");
  const std::string of_mixture = R"(
static model_arena arena;
static float image[MODEL_IMAGE_CHANNELS * MODEL_IMAGE_ROWS * MODEL_IMAGE_COLUMNS];
int main(void) {
  float parameters[MODEL_PARAMETERS] = {7.0F}, stddevs[MODEL_PARAMETERS] = {7.0F};
  int i, count = (int)(sizeof image / sizeof image[0]);
  for (i = 0; i < count; ++i) image[i] = 3.4e38F;
  if (model_identify_image(image, parameters, &arena) != MODEL_ERROR_NOT_FINITE) return 1;
  if (model_stddevs(stddevs, &arena) != MODEL_ERROR_NOT_FINITE) return 2;
  return (parameters[0] == 7.0F && stddevs[0] == 7.0F) ? 0 : 3;
}
)";
  CHECK(run_main(folder, "model", c99 + "-fsanitize=undefined -fsanitize-undefined-trap-on-error", of_mixture) == 0);
}

TEST_CASE("a step that interrupts an exported controller's begin is refused") {
  const Folder folder;
  run_ok("export controller --name controller --quiet -o " + folder / "c");
  // A timer steps every 50 microseconds, while the program does nothing but begin.
  const std::string main = R"(
static controller_state state;
static volatile sig_atomic_t refused = 0, others = 0;
static void on_timer(int signal) {
  double torque = 0.0;
  const int result = controller_step(&state, 0.01, 0.0, 0.0, 0.0, &torque);
  (void)signal;
  if (result == CONTROLLER_ERROR_STATE) ++refused;
  else if (result != CONTROLLER_OK) ++others;
}
int main(void) {
  const struct itimerval often = {{0, 50}, {0, 50}};
  const time_t end = time(NULL) + 20;
  if (controller_begin(&state, NULL) != CONTROLLER_OK) return 1;
  signal(SIGALRM, on_timer);
  if (setitimer(ITIMER_REAL, &often, NULL) != 0) return 2;
  while (refused == 0 && time(NULL) < end)
    if (controller_begin(&state, NULL) != CONTROLLER_OK) return 3;
  return (refused > 0 && others == 0) ? 0 : 4;
}
)";
  CHECK(run_main(folder, "controller", c99, "#include <signal.h>\n#include <sys/time.h>\n#include <time.h>\n" + main) ==
        0);
}

TEST_CASE("a NaN that arises within an exported network passes its pools, in any place") {
  struct Case {
    const char* pool;
    int rows, stride;
  };
  for (const auto& [pool, rows, stride] :
       {Case{"maxpool 2x1", 2, 2}, {"maxpool 3x1 stride 2x1", 3, 2}, {"avgpool 2x1", 2, 2}}) {
    const std::string layer = pool;
    CAPTURE(layer);
    const Folder folder;
    const Model model = overflowing_model(layer);
    const int pixels = model.images().shape().size();
    REQUIRE(pixels >= 4);
    test::write_text(folder / "m.safetensors", to_bytes(model));
    run_ok("export c " + folder / "m.safetensors" + " --name model --quiet -o " + folder / "c");
    const std::string main = R"(
static model_arena arena;
int main(void) {
  int place, i;
  for (place = -1; place < PIXELS; ++place) {
    float image[PIXELS] = {0.0F}, parameters[MODEL_PARAMETERS];
    if (place >= 0) image[place] = 2.0F;
    parameters[0] = 7.0F;
    i = model_identify_image(image, parameters, &arena);
    if (i != MODEL_OK && i != MODEL_ERROR_NOT_FINITE) return 1;
    if ((i == MODEL_ERROR_NOT_FINITE) != (place >= 0)) return 2 + place;
    if ((parameters[0] == 7.0F) != (place >= 0)) return 100;
  }
  return 0;
}
)";
    // Samples at the end that fill no window are left out.
    const int seen = (pixels - rows) / stride * stride + rows;
    CHECK(run_main(folder, "model", c99, "#define PIXELS " + std::to_string(pixels) + "\n" + main) ==
          (seen == pixels ? 0 : 2 + seen));
  }
}

}  // namespace decid::tools
