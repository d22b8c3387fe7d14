// Exported models on the host: every kind of layer and image, several compilers, C and C++, the bits of identify.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/text.hpp"
#include "identify/identify.hpp"
#include "identify/network/prediction.hpp"
#include "identify/training/presets.hpp"
#include "identify/training/training.hpp"
#include "nn/operation.hpp"
#include "sim/segments.hpp"
#include "tests/tools/firmware/models.hpp"
#include "tools/firmware/c_text.hpp"
#include "tools/firmware/quantise.hpp"
#include "tools/firmware/text.hpp"

namespace decid::tools {
namespace {

using dataset::Channel;
using namespace test;

const std::string harness = DECID_SOURCE_DIR "/tests/tools/firmware/harness.c";

bool can_fuse() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("fma") != 0;
#else
  return false;
#endif
}

struct Compiler {
  std::string program, compile, link;
};

/// Compilers and their ways, those that differ most first; the first one is always there.
std::vector<Compiler> compilers() {
  std::vector<Compiler> all{{DECID_C_COMPILER, "-std=c99 -O2", ""}};
  const auto add = [&](const std::string& program, const std::string& compile, const std::string& link = {}) {
    if (test::have(program)) all.push_back({program, compile, link});
  };
  const std::string sanitizers = "-fsanitize=address,undefined -fno-sanitize-recover=all";
  add("gcc", "-std=c99 -O1 " + sanitizers, sanitizers);
  add("g++", "-x c++ -std=c++17 -O2");
  if (can_fuse()) add("gcc", "-std=gnu99 -O3 -mfma");  // gnu99 would fuse by itself
  add("gcc", "-std=c99 -O0");
  add("clang-14", "-std=c99 -O2");
  if (can_fuse()) add("clang++-14", "-x c++ -std=c++17 -O2 -mfma");
  return all;
}

/// The same with the distance behind each trial's values, as identify finds it.
std::string with_distances(const Model& model, const ForBody& body, const dataset::Dataset& data,
                           const std::string& values) {
  Identifier identifier(model, body);
  const std::size_t width = values.size() / static_cast<std::size_t>(data.trials());
  std::string all;
  for (int i = 0; i < data.trials(); ++i) {
    const std::span<const float> sway = data.trial(i);
    const Estimate found = identifier.estimate({recording::make_trial({sway.begin(), sway.end()})}).front();
    const double distance = found.distance / model.ood_detector.usual;
    all += values.substr(static_cast<std::size_t>(i) * width, width);
    all.append(reinterpret_cast<const char*>(&distance), sizeof distance);
  }
  return all;
}

/// Exports `model` and runs the harness on its trials: their parameters. subject: whose trials they are, the model's
/// own body if empty.
void check_bits(Model model, int trials, const std::string& options, std::size_t max_compilers,
                const std::optional<sim::Participant>& participant = {}) {
  const Folder folder;
  std::optional<sim::Body> told;
  std::string body_options;
  if (participant) {
    told = sim::make_body(sim::make_segments(*participant));
    body_options = format(" --mass %.17g --height %.17g ", participant->mass_kg, participant->height_m);
  }
  const ForBody body = for_body(model, "model", told);
  const dataset::Dataset data = test::noisy_trials(model, trials, 31);
  std::string images;
  std::vector<float> image(static_cast<std::size_t>(model.images().shape().size()));
  for (int i = 0; i < trials; ++i) {
    model.make_input({data.trial(i), body.height}, image);
    images += as_bytes(image);
  }
  test::write_text(folder / "sway.bin", as_bytes(data.sway));
  test::write_text(folder / "images.bin", images);
  test::write_text(folder / "m.safetensors", to_bytes(model));
  run_ok("export c " + folder / "m.safetensors" + " --name model " + options + body_options + " --quiet -o " +
         folder / "c");
  std::string expected;
  if (options.find("--int8") == std::string::npos) {
    expected = test::identified_bytes(model, body, data);
  } else {
    FirmwarePlan plan = plan_firmware(model, {.int8 = true});
    quantise(plan, model);
    const auto sways = sways_in_memory([&](int i) { return data.trial(i); }, body.height);
    const std::vector<float> outputs = predict_planned(plan, model, trials, sways);
    const std::size_t width = outputs.size() / static_cast<std::size_t>(trials);
    for (std::size_t i = 0; i < outputs.size(); i += width)
      expected += test::said_bytes(model, body, std::span(outputs).subspan(i, width));
  }
  std::string defines;
  if (options.find("--ood-score") != std::string::npos) {
    defines += " -DFAMILIARITY";
    expected = with_distances(model, body, data, expected);
  }
  if (options.find("--incremental") != std::string::npos) defines += " -DINCREMENTAL";
  if (model.gives_distribution()) defines += " -DDEVIATIONS";
  std::vector<Compiler> ways = compilers();
  ways.resize(std::min(ways.size(), max_compilers));
  for (const Compiler& way : ways) {
    const std::string compiler = way.program + " " + way.compile;
    CAPTURE(compiler);
    const std::string c = folder / "c";
    compile(compiler + " -I " + c + " -c " + c + "/model.c -o " + folder / "model.o");
    REQUIRE(shell(compiler + defines + " -I " + c + " -c " + harness + " -o " + folder / "harness.o") == 0);
    REQUIRE(shell(way.program + " " + way.link + " " + folder / "harness.o" + " " + folder / "model.o" + " -o " +
                  folder / "harness") == 0);
    REQUIRE(shell(folder / "harness" + " " + folder / "sway.bin" + " " + folder / "images.bin" + " " +
                  folder / "results.bin") == 0);
    CHECK(test::read_text(folder / "results.bin") == expected);
  }
}

const std::vector<Channel> every_series_channel{Channel::sway,         Channel::sway_change, Channel::sway_bend,
                                                Channel::torque,       Channel::height,      Channel::tilt,
                                                Channel::tilt_velocity};
const dataset::ImageSettings every_channel{
    .window = 105,  // odd: a transform of the full length, factors 3, 5 and 7
    .channels = {Channel::modulus, Channel::log_modulus, Channel::phase, Channel::cos_phase, Channel::sin_phase,
                 Channel::real, Channel::imaginary, Channel::asinh_real, Channel::asinh_imaginary,
                 Channel::log_residual},
    .standardize_rows = true,
    .first_sample = 37};

/// A layer that a program registered.
class Square final : public nn::OperationOf<Square> {
 public:
  explicit Square(nn::Shape shape) : OperationOf(shape, shape) {}
  std::string text() const override { return "square"; }
  template <class T>
  void forward_pass(const nn::ForwardPass<T>& pass) const {
    nn::map<T>(pass.src, pass.dst, [](T x) { return x * x; });
  }
  template <class T>
  void backward_pass(const nn::BackwardPass<T>&) const {}
};

}  // namespace

TEST_CASE("the firmware model on the host: the bits of identify in every compiler, whole and as samples arrive" *
          doctest::test_suite("slow")) {
  check_bits(load_model(test::firmware_model), 4, "--incremental --ood-score", 99);
  check_bits(load_model(test::firmware_model), 4, "--incremental --int8", 4);
}

// Over 20 s: guards the exported C of every layer and image. Each of them is compiled and run; gcc takes the time.
TEST_CASE("exported networks have the bits of identify for every kind of layer and image" *
          doctest::test_suite("slow")) {
  SUBCASE("all channels, padding, overlapping pools, layers in odd places") {
    const std::string odd =
        "batchnorm; conv 5 3x4 stride 2x3 pad 2x3; relu; relu; maxpool 3x2 stride 2x1; conv 6 4x2 stride 3x1 pad 1x0; "
        "avgpool 2x3; batchnorm; maxpool 2x2; relu; fc 9; batchnorm; relu; conv 8 1x1; batchnorm; fc 7; relu";
    check_bits(test::made_up_model(sim::default_protocol(), every_channel, odd), 1, "--incremental", 1);
    check_bits(test::made_up_model(sim::default_protocol(), every_channel, odd), 1, "--int8", 1);
  }
  SUBCASE("blocks, functions, groups, dilation and padded pools, row by row and column by column") {
    const std::string newer =
        "conv 6 3x4 stride 4x3 pad 2x3; tanh; residual { conv 6 3x2 pad 2x1 groups 2 dilation 2; sigmoid }; relu; "
        "maxpool 3x2 stride 2 pad 1; layernorm; concat { gelu; maxpool 3 stride 1 pad 1 }; leakyrelu; "
        "avgpool 3 stride 2 pad 1; globalavgpool; fc 7";
    for (const char* options : {"", "--incremental"})
      check_bits(test::made_up_model(sim::short_protocol(), {.window = 100, .half_spectrum = true}, newer), 2, options,
                 1);
    const Model model = test::made_up_model(sim::short_protocol(), {.window = 100}, newer);
    check_error([&] { plan_firmware(model, {.int8 = true}); }, Code::not_supported);
  }
  SUBCASE("the paper's with an eighth of its filters, column by column") {
    const std::string paper =
        "conv 8 3x3 pad 1x1; batchnorm; relu; maxpool 2x2; conv 8 3x3 pad 1x1; batchnorm; relu; maxpool 2x2; "
        "conv 16 3x3 pad 1x1; batchnorm; relu; maxpool 2x2; conv 16 3x3 pad 1x1; batchnorm; relu; globalavgpool; fc 7";
    check_bits(test::made_up_model(sim::default_protocol(), preset_named("paper").image, paper), 1, "--incremental", 1);
  }
  SUBCASE("windows folded over cycles, a window of 2^7") {
    dataset::ImageSettings image = preset_named("small").image;
    image.channels.push_back(Channel::log_residual);
    image.fold = 2;
    const std::string architecture = "conv 4 3x3 pad 1x1; relu; globalavgpool; batchnorm; fc 7";
    for (const char* options : {"", "--incremental"})
      check_bits(test::made_up_model(sim::default_protocol(), image, architecture), 2, options, 1);
    check_bits(test::made_up_model(sim::default_protocol(), {.window = 128}, "fc 7"), 2, "", 1);
  }
  SUBCASE("the short protocol, the smallest windows, a large prime") {
    const Preset& preset = preset_named("short");
    check_bits(test::made_up_model(sim::short_protocol(), preset.image, preset.architecture), 2, "--incremental", 1);
    check_bits(test::made_up_model(sim::short_protocol(), {.window = 2}, "avgpool 2x7; fc 7"), 1, "--incremental", 1);
    check_bits(test::made_up_model(sim::short_protocol(), {.window = 2 * 1009, .half_spectrum = true, .rows = 40},
                                   "conv 3 3x2; fc 7"),
               1, "", 1);
  }
  SUBCASE("time series of folded cycles, statistics, a mixture") {
    const dataset::ImageSettings series{.window = 6050, .channels = every_series_channel, .fold = 2, .block = 10};
    const std::string architecture =
        "conv 6 9x1 stride 3x1 pad 4x0; batchnorm; relu; conv 5 4x1 stride 2x1; statspool; fc 9; relu; fc 72";
    sim::Protocol protocol = sim::default_protocol();
    protocol.heights = {.low = 0.9, .high = 1.1};
    Model model = test::made_up_model(protocol, series, architecture, mixture_head(2));
    for (std::size_t p = 0; p < model.parameters().size(); ++p) {
      Recalibration::Levels levels;
      for (std::size_t i = 0; i < levels.size(); ++i) levels[i] = 0.05 * static_cast<double>(i + 1);
      model.recalibration.levels.push_back(levels);
      model.recalibration.stddev_factor.push_back(1.0 + 0.1 * static_cast<double>(p));
    }
    check_bits(model, 2, "--incremental", 4);
    check_bits(model, 2, "", 1);
    check_bits(model, 2, "--incremental --int8", 1);
    for (const char* options : {"--incremental", "--int8"})
      check_bits(model, 2, options, 1, sim::Participant{.mass_kg = 60.0, .height_m = 1.65});
  }
  SUBCASE("time series of three cycles behind a lead-in") {
    const dataset::ImageSettings series{.window = 2000,
                                        .channels = {Channel::sway, Channel::sway_bend, Channel::tilt},
                                        .first_sample = 197,
                                        .fold = 3,
                                        .block = 10};
    const std::string architecture = "conv 5 5x1 stride 2x1; batchnorm; relu; statspool; fc 7";
    for (const char* options : {"", "--incremental"})
      check_bits(test::made_up_model(sim::short_protocol(), series, architecture), 2, options, 1);
  }
  SUBCASE("one time series, ten values, straight into a layer; statistics of the image itself") {
    const dataset::ImageSettings series{
        .channels = {Channel::sway_bend}, .standardize_rows = true, .first_sample = 5, .block = 7};
    check_bits(test::made_up_model(sim::short_protocol(), series, "statspool; fc 36", mixture_head(1)), 2,
               "--incremental", 1);
    check_bits(test::made_up_model(sim::short_protocol(), {.channels = {Channel::sway}, .block = 600}, "fc 7"), 2,
               "--incremental --int8", 1);
  }
  SUBCASE("the built-in model") {
    check_bits(built_in_model(), 2, "--ood-score", 1, sim::Participant{.mass_kg = 60.0, .height_m = 1.65});
  }
}

TEST_CASE("exported files for processors with _Float16: gcc's GNU modes make the instructions of C99" *
          doctest::test_suite("long")) {
  // FLT_EVAL_METHOD is 16 there. Few machines could run them; what C99 computes is tested above.
  const Folder folder;
  const std::string c = folder / "c";
  run_ok("export c " + test::firmware_model + " --name model --incremental --quiet -o " + c);
  run_ok("export c --name built_in --quiet -o " + c);
  run_ok("export controller --name controller --quiet -o " + c);
  std::vector<std::string> ways{"arm-none-eabi-gcc -mthumb -mcpu=cortex-m55 -mfloat-abi=hard"};
#if defined(__x86_64__)
  ways.emplace_back("gcc -march=sapphirerapids");
#endif
  for (const std::string& compiler : ways) {
    if (!test::have(compiler.substr(0, compiler.find(' ')))) continue;
    CAPTURE(compiler);
    REQUIRE(shell("(" + compiler + " -std=gnu11 -dM -E -x c /dev/null | grep 'FLT_EVAL_METHOD__ 16')") == 0);
    for (const char* name : {"model", "built_in", "controller"}) {
      const auto assembly = [&](const std::string& mode) {
        REQUIRE(shell(compiler + " -O2 -std=" + mode + warnings + "-S " + c + "/" + name + ".c -o " + folder / "s") ==
                0);
        return test::read_text(folder / "s");
      };
      const std::string expected = assembly("c99");
      for (const char* mode : {"gnu99", "gnu11"}) CHECK(assembly(mode) == expected);
    }
  }
}

TEST_CASE("an exported model is small, and needs nothing") {
  const Folder folder;
  Model model = load_model(test::firmware_model);
  const FirmwarePlan plan = plan_firmware(model, {.incremental = true});
  CHECK(plan.weight_bytes() + 8LL * static_cast<long long>(model.rows.mean.size()) <= 60 * 1024);
  CHECK(plan.arena.bytes < 128 * 1024);
  // Line buffers: of the paper's network, 64 filters on 110 x 110, a twentieth of its maps.
  const Preset& preset = preset_named("paper");
  Model paper = test::made_up_model(sim::default_protocol(), preset.image, preset.architecture);
  const FirmwarePlan paper_plan = plan_firmware(paper, {});
  CHECK(paper_plan.arena.bytes * 18 < paper_plan.whole_map_bytes());
  run_ok("export c " + test::firmware_model + " --name model --incremental --quiet -o " + folder / "c");
  compile(c99 + "-ffreestanding -c " + folder / "c/model.c" + " -o " + folder / "model.o");
  // Nothing undefined but what compilers call by themselves, nothing that can be written.
  CHECK(shell("! nm -u " + folder / "model.o" + " | grep -vE ' (memcpy|memset)$'") == 0);
  CHECK(shell("! nm " + folder / "model.o" + " | grep -E ' [bBdDcC] '") == 0);
}

TEST_CASE("the firmware model: the documented hash, its error, and the cost of 8-bit integers") {
  Model model = load_model(test::firmware_model);
  const std::string hash = nn::weights_sha256(model.network);
  CAPTURE(hash);
  CHECK(contains(test::read_text(DECID_SOURCE_DIR "/docs/guide/firmware.md"), hash));
  sim::Protocol protocol = model.protocol;
  CHECK(protocol.noise.sensor.high_deg == 0.1);
  const dataset::Dataset data = dataset::generate({.protocol = protocol, .count = 200, .seed = 4242});
  const auto sways = sways_in_memory([&](int i) { return data.trial(i); });
  Model best = built_in_model();
  const double best_mse =
      evaluate(best.targets, to_scores(best, predict(best, data.trials(), 64, sways)), data.parameters).mse();
  const double mse =
      evaluate(model.targets, to_scores(model, predict(model, data.trials(), 64, sways)), data.parameters).mse();
  FirmwarePlan plan = plan_firmware(model, {.int8 = true});
  quantise(plan, model);
  const double int8_mse =
      evaluate(model.targets, to_scores(model, predict_planned(plan, model, data.trials(), sways)), data.parameters)
          .mse();
  // On 2,000 other trials the differences are 0.016 and 0.0015. Means of 200 differences have standard errors of 0.011
  // and 0.0011: the limits are 3 and 7 of them away.
  CHECK(mse < best_mse + 0.05);
  CHECK(int8_mse < mse + 0.01);
  CHECK(int8_mse != mse);
}

TEST_CASE("the plan's own network in float has the bits of the engine") {
  Model model = load_model(test::firmware_model);
  const dataset::Dataset data = test::noisy_trials(model, 3, 5);
  const auto sways = sways_in_memory([&](int i) { return data.trial(i); });
  const std::vector<float> outputs = predict(model, data.trials(), 64, sways);
  CHECK(as_bytes(predict_planned(plan_firmware(model, {}), model, data.trials(), sways)) == as_bytes(outputs));
}

TEST_CASE("a layer that a program registered is not exported") {
  nn::register_layer("square",
                     [](nn::Shape src, nn::Words&) -> nn::OperationPointer { return std::make_shared<Square>(src); });
  check_error([&] { plan_network(nn::Network<float>({3, 1, 1}, "fc 2; square")); }, Code::not_supported, "'square'");
}

TEST_CASE("outputs that are not parameters are not exported") {
  class OtherHead final : public Head {
    std::string name() const override { return "other"; }
    std::size_t outputs(std::size_t parameters) const override { return parameters; }
    std::size_t loss_parts(std::size_t) const override { return 1; }
    void loss(const nn::TensorView<const float>&, std::span<const float>, int, std::size_t, std::span<double>,
              const nn::TensorView<float>&) const override {}
    double total_loss(std::span<const double>, std::size_t) const override { return 0.0; }
    void scores(std::span<const float>, std::span<float>) const override {}
  };
  const OtherHead other;
  Model model = load_model(test::firmware_model);
  model.head = &other;
  check_error([&] { plan_firmware(model, {}); }, Code::not_supported, "'other'");
}

TEST_CASE("literals have the very bits, and comments end where they should") {
  CHECK(literal(0.1F) == "0.100000001F");
  CHECK(literal(-3.0F) == "-3.0F");
  CHECK(literal(1e-45F) == "1.40129846e-45F");
  CHECK(literal(0.1) == "0.10000000000000001");
  CHECK_THROWS_AS(literal(std::numeric_limits<float>::infinity()), Error);
  CHECK_THROWS_AS(literal(std::nan("")), Error);
  CHECK(comment("a*/b\n") == "a?/b?");
}

}  // namespace decid::tools
