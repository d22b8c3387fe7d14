// An exported model on emulated processors: examples/firmware built for Cortex-M3, M4F, M7 and M55, run under QEMU on
// trials, bits compared with identify's. It prints memory and instructions; docs/guide/firmware.md has them as a table.
#include <nlohmann/json.hpp>
#include <sstream>

#include "base/text.hpp"
#include "identify/identify.hpp"
#include "tests/tools/firmware/models.hpp"
#include "tools/firmware/quantise.hpp"

namespace decid::tools {
namespace {

using namespace test;

long long cost(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  std::string found;
  long long value = 0;
  while (lines >> found >> value)
    if (found == name) return value;
  FAIL("no " << name << " in " << text);
  return -1;
}

/// Builds and runs the example; its costs.
std::string run_example(const Folder& folder, const std::string& options, const dataset::Dataset& data) {
  test::write_text(folder / "given.bin", test::as_bytes(data.sway));
  REQUIRE(shell(DECID_SOURCE_DIR "/examples/firmware/run --decid " DECID_PROGRAM " --sway " + folder / "given.bin" +
                " --out " + folder / "out" + " " + options) == 0);
  return test::read_text(folder / "out/costs.txt");
}

/// The row of the table, and the controller's.
std::string row(const std::string& what, const std::string& costs) {
  const auto kilo = [&](const std::string& name) {
    return format("%.1f", 1e-3 * static_cast<double>(cost(costs, name)));
  };
  const auto mega = [&](const std::string& name) {
    return format("%.2f", 1e-6 * static_cast<double>(cost(costs, "instructions_" + name)));
  };
  return "| " + what + " | " + kilo("code_bytes") + " | " + kilo("constant_bytes") + " | " + kilo("arena_bytes") +
         " | " + kilo("stack_bytes") + " | " + mega("whole") + " | " + mega("after_last_sample") + " | " +
         mega("largest_part") + " |";
}
std::string controller_row(const std::string& what, const std::string& costs) {
  const auto text = [&](const std::string& name) { return std::to_string(cost(costs, "controller_" + name)); };
  return "| " + what + " | " + text("code_bytes") + " | " + text("constant_bytes") + " | " + text("state_bytes") +
         " | " + text("stack_bytes") + " | " + text("instructions_a_step") + " | " + text("instructions_worst_step") +
         " | " + format("%.1f", 1e-3 * static_cast<double>(cost(costs, "controller_instructions_check"))) + " | " +
         format("%.2f", 1e-6 * static_cast<double>(cost(costs, "controller_instructions_self_test"))) + " |";
}
/// Returns a table row: the cost of the out-of-distribution score in a firmware.
std::string familiarity_row(const std::string& what, const std::string& with, const std::string& without) {
  const auto more = [&](const std::string& name) {
    return format("%.1f", 1e-3 * static_cast<double>(cost(with, name) - cost(without, name)));
  };
  return "| " + what + " | " + more("code_bytes") + " | " + more("constant_bytes") + " | " +
         format("%.2f", 1e-6 * static_cast<double>(cost(with, "instructions_distance"))) + " |";
}
/// Sizes and counts are those of Debian 12's compiler: what is written down is what comes out.
void check_written(const char* file, const std::string& line) {
  CAPTURE(line);
  const std::string text = test::read_text(std::string(DECID_SOURCE_DIR "/") + file);
  CHECK(contains(text, line));
}

void check_costs(const std::string& costs, int trials) {
  MESSAGE(costs);
  CHECK(cost(costs, "counter_check") == 200000);
  CHECK(cost(costs, "self_test_error") == 0);
  CHECK(cost(costs, "error") == 0);
  CHECK(cost(costs, "controller_self_test_error") == 0);
  CHECK(cost(costs, "trials") == trials);
  CHECK(cost(costs, "arena_bytes") < 128 * 1024);
  CHECK(cost(costs, "stack_bytes") < 2048);
  CHECK(cost(costs, "controller_stack_bytes") < 1024);
  CHECK(cost(costs, "controller_instructions_worst_step") >= cost(costs, "controller_instructions_a_step"));
  CHECK(cost(costs, "instructions_largest_part") * 20 < cost(costs, "instructions_whole"));
}

/// The self-test compares the distance's bits too. without: the costs of the firmware that cannot tell it.
void check_familiarity(const std::string& cpu, const std::string& name, const Model& model,
                       const std::string& without) {
  const Folder folder;
  const dataset::Dataset data = test::noisy_trials(model, 1, 79);
  const std::string costs = run_example(folder, "--ood-score --cpu " + cpu, data);
  check_costs(costs, 1);
  check_written("docs/guide/firmware.md", familiarity_row(name, costs, without));
  const std::span<const float> sway = data.trial(0);
  const Estimate found = Identifier(model).estimate({recording::make_trial({sway.begin(), sway.end()})}).front();
  CHECK(cost(costs, "distance_thousandths") ==
        static_cast<long long>(1000.0 * (found.distance / model.ood_detector.usual)));
}

void check_cpu(const std::string& cpu, const std::string& name, int trials) {
  Model model = load_model(test::firmware_model);
  {
    const Folder folder;
    const dataset::Dataset data = test::noisy_trials(model, trials, 77);
    const std::string costs = run_example(folder, "--cpu " + cpu, data);
    check_costs(costs, trials);
    check_written("docs/guide/firmware.md", row(name + ", float", costs));
    check_written("docs/guide/firmware.md", controller_row(name, costs));
    CHECK(test::read_text(folder / "out/results.bin") ==
          test::identified_bytes(model, for_body(model, "model", {}), data));
    check_familiarity(cpu, name, model, costs);
  }
  const Folder folder;
  const dataset::Dataset data = test::noisy_trials(model, 2, 78);
  const std::string costs = run_example(folder, "--int8 --cpu " + cpu, data);
  check_costs(costs, 2);
  check_written("docs/guide/firmware.md", row(name + ", 8 bits", costs));
  FirmwarePlan plan = plan_firmware(model, {.int8 = true});
  quantise(plan, model);
  std::vector<float> expected;
  const std::vector<float> outputs =
      predict_planned(plan, model, data.trials(), sways_in_memory([&](int i) { return data.trial(i); }));
  for (std::size_t i = 0; i < outputs.size(); i += sim::single_pendulum().parameters.size())
    for (const double value :
         model.targets.unscale(std::span(outputs).subspan(i, sim::single_pendulum().parameters.size())))
      expected.push_back(static_cast<float>(value));
  CHECK(test::read_text(folder / "out/results.bin") == test::as_bytes(expected));
}

}  // namespace

TEST_CASE("Cortex-M3 under QEMU, without an FPU: the bits of identify" * doctest::test_suite("slow")) {
  check_cpu("m3", "Cortex-M3", 2);
}
TEST_CASE("Cortex-M4F under QEMU: the bits of identify" * doctest::test_suite("slow")) {
  check_cpu("m4", "Cortex-M4F", 4);
}
TEST_CASE("Cortex-M7 under QEMU: the bits of identify" * doctest::test_suite("long")) {
  check_cpu("m7", "Cortex-M7", 4);
}
TEST_CASE("Cortex-M55 under QEMU, compiled in a GNU mode: the bits of identify" * doctest::test_suite("slow")) {
  check_cpu("m55", "Cortex-M55", 4);
}

TEST_CASE("the example without a whole trial fails") {
  const Folder folder;
  test::write_text(folder / "short.bin", std::string(100, '\0'));
  const std::string run = DECID_SOURCE_DIR "/examples/firmware/run --cpu m7 --decid " DECID_PROGRAM " --sway " +
                          folder / "short.bin" + " --out " + folder / "out";
  CHECK(test::shell(run + " || test $? = 1") == 0);
  CHECK(cost(test::read_text(folder / "out/costs.txt"), "error") == 105);
}

TEST_CASE("the example with a model whose trial is no whole number of batches, and with an unusable Kp") {
  sim::Protocol protocol = sim::short_protocol();
  protocol.experiment.sample_rate_hz = 50.0;
  REQUIRE(protocol.samples() % 110 != 0);
  Model model = test::made_up_model(protocol, {.channels = {dataset::Channel::sway}, .block = 300}, "fc 7");
  for (nn::Parameter<float>* p : model.network.parameters()) p->value.assign(p->value.size(), 0.0F);
  const Folder folder;
  test::write_text(folder / "sway.bin",
                   std::string(sizeof(float) * static_cast<std::size_t>(protocol.samples()), '\0'));
  const std::string run = DECID_SOURCE_DIR "/examples/firmware/run --cpu m7 --decid " DECID_PROGRAM " --sway " +
                          folder / "sway.bin" + " --model " + folder / "m.safetensors" + " --out " + folder / "out";
  test::write_text(folder / "m.safetensors", to_bytes(model));
  CHECK(test::shell(run) == 0);
  CHECK(cost(test::read_text(folder / "out/costs.txt"), "error") == 0);
  CHECK(cost(test::read_text(folder / "out/costs.txt"), "trials") == 1);
  model.targets.mean[sim::Kp] = -1.0;
  test::write_text(folder / "m.safetensors", to_bytes(model));
  CHECK(test::shell(run + " || test $? = 1") == 0);
  CHECK(cost(test::read_text(folder / "out/costs.txt"), "error") == 106);
}

TEST_CASE("the example alone: its estimates are decid identify's") {
  const Folder folder;
  REQUIRE(shell(DECID_SOURCE_DIR "/examples/firmware/run --cpu m7 --decid " DECID_PROGRAM " --out " + folder / "out") ==
          0);
  const test::Result result =
      test::run_decid("identify --json --model " + test::firmware_model + " " + folder / "out/trial.csv");
  REQUIRE(result.code == 0);
  std::vector<float> expected;
  const auto json = nlohmann::json::parse(result.out);
  for (const auto& parameter : json["recordings"][0]["parameters"])
    expected.push_back(static_cast<float>(parameter["value"].get<double>()));
  CHECK(test::read_text(folder / "out/results.bin") == test::as_bytes(expected));
  CHECK(test::shell(DECID_SOURCE_DIR "/examples/firmware/run --cpu z80 2>/dev/null || test $? = 2") == 0);
}

}  // namespace decid::tools
