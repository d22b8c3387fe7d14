// The constants in an exported model's header: its body, and the parameters' ranges, names and units.
#include "base/text.hpp"
#include "sim/segments.hpp"
#include "tests/tools/firmware/models.hpp"
#include "tools/firmware/c_text.hpp"

namespace decid::tools {
namespace {

using namespace test;

/// Exports the firmware model or another one, and checks that a program in C has these constants.
void check_header(const std::string& model, const std::string& options, const sim::Protocol& protocol) {
  const Folder folder;
  const std::string c = folder / "c";
  run_ok("export c " + model + options + " --name model --quiet -o " + c);
  const std::string header = read_text(c + "/model.h");
  const auto has = [&](const std::string& name, const std::string& value) {
    CAPTURE(name);
    CHECK(contains(header, "#define MODEL_" + name + " " + value + "\n"));
  };
  const sim::Body& body = protocol.experiment.body;
  has("MASS_KG", literal(body.mass_kg));
  has("COM_HEIGHT_M", literal(body.com_height_m));
  has("INERTIA_KGM2", literal(body.inertia_kgm2));
  has("MGH_NM_RAD", literal(body.mgh()));
  const sim::ParameterTable ranges = protocol.ranges();
  has("DELAY_MAX", literal(static_cast<float>(ranges[sim::Delay].high)));
  has("KP_PASS_MIN", literal(static_cast<float>(ranges[sim::Kp_pass].low)));

  test::write_text(folder / "main.c", std::string("#include <stdio.h>\n#include \"model.h\"\n") + R"(
static const float low[MODEL_PARAMETERS] = MODEL_MINIMA;
static const float high[MODEL_PARAMETERS] = MODEL_MAXIMA;
static const char* const name[MODEL_PARAMETERS] = MODEL_NAMES;
static const char* const unit[MODEL_PARAMETERS] = MODEL_UNITS;
int main(void) {
  int i;
  for (i = 0; i < MODEL_PARAMETERS; ++i) printf("%s|%s|%.9g|%.9g\n", name[i], unit[i], (double)low[i], (double)high[i]);
  return (low[MODEL_KP] == MODEL_KP_MIN && high[MODEL_THETA] == MODEL_THETA_MAX) ? 0 : 1;
}
)");
  std::string expected;
  for (const sim::ParameterInfo& info : ranges)
    expected +=
        format("%s|%s|%.9g|%.9g\n", info.name.c_str(), info.unit.c_str(),
               static_cast<double>(static_cast<float>(info.low)), static_cast<double>(static_cast<float>(info.high)));
  for (const std::string& compiler : {std::string(DECID_C_COMPILER) + " -std=c99", std::string("g++ -x c++")}) {
    CAPTURE(compiler);
    if (compiler.starts_with("g++") && !have("g++")) continue;
    REQUIRE(shell(compiler + " -Wall -Wextra -Wpedantic -Werror -I " + c + " " + folder / "main.c" + " -o " +
                  folder / "main") == 0);
    CHECK(shell("(" + folder / "main" + " > " + folder / "said" + ")") == 0);
    CHECK(read_text(folder / "said") == expected);
  }
}

}  // namespace

TEST_CASE("a model's header has the body for which it answers, and the parameters' ranges, names and units") {
  const Model firmware = load_model(test::firmware_model);
  check_header(test::firmware_model, "", firmware.protocol);
  // For another body the stiffnesses' ranges are those of its m g h.
  const ForBody other =
      for_body(firmware, "model", sim::make_body(sim::make_segments({.mass_kg = 60.0, .height_m = 1.8})));
  CHECK(other.ranges[sim::Kp].high < 0.8 * firmware.parameters()[sim::Kp].high);
  check_header(test::firmware_model, " --mass 60 --height 1.8", other.protocol);
  const std::string gains = DECID_SOURCE_DIR "/models/dec2015.safetensors";
  check_header(gains, "", load_model(gains).protocol);
}

TEST_CASE("a model in 8 bits has no distance, and its header says why") {
  const Folder folder;
  for (const std::string form : {"", " --int8", " --ood-score"}) {
    CAPTURE(form);
    run_ok("export c " + test::firmware_model + form + " --name model --quiet -o " + folder / "c");
    const std::string header = read_text(folder / "c/model.h");
    CHECK(contains(header, "#define MODEL_GIVES_DISTANCE 1\n") == (form == " --ood-score"));
    CHECK(contains(header, "int model_distance(") == (form == " --ood-score"));
    CHECK(contains(header, "/* In 8 bits there is no distance") == (form == " --int8"));
  }
}

TEST_CASE("a string literal of C ends where it should") {
  CHECK(quoted("N m/rad") == "\"N m/rad\"");
  CHECK(quoted("a\"b\\c\n??") == "\"a\\\"b\\\\c\\?\\?\\?\"");
}

}  // namespace decid::tools
