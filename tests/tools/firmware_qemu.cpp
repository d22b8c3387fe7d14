// An exported model on emulated processors: examples/firmware built for Cortex-M4F and M7, run under QEMU on trials,
// bits compared with identify's. What it costs is printed; the README has it as a table.
#include <sstream>

#include "tests/tools/firmware_models.hpp"
#include "tools/firmware_quantise.hpp"

namespace decid::tools {
namespace {

using test::Folder;
using test::shell;

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

void check_costs(const std::string& costs, int trials) {
  MESSAGE(costs);
  CHECK(cost(costs, "counter_check") == 200000);
  CHECK(cost(costs, "self_test_error") == 0);
  CHECK(cost(costs, "error") == 0);
  CHECK(cost(costs, "trials") == trials);
  CHECK(cost(costs, "arena_bytes") < 128 * 1024);
  CHECK(cost(costs, "stack_bytes") < 2048);
  CHECK(cost(costs, "instructions_largest_part") * 20 < cost(costs, "instructions_whole"));
}

void check_cpu(const std::string& cpu) {
  Model model = load_model(test::firmware_model);
  {
    const Folder folder;
    const dataset::Dataset data = test::noisy_trials(model, 20, 77);
    check_costs(run_example(folder, "--cpu " + cpu, data), 20);
    CHECK(test::read_text(folder / "out/results.bin") == test::identified_bytes(model, data));
  }
  const Folder folder;
  const dataset::Dataset data = test::noisy_trials(model, 2, 78);
  check_costs(run_example(folder, "--int8 --cpu " + cpu, data), 2);
  FirmwarePlan plan = plan_firmware(model, {.int8 = true});
  quantise(plan, model);
  std::vector<float> expected;
  const std::vector<float> outputs =
      predict_planned(plan, model, data.trials(), sways_in_memory([&](int i) { return data.trial(i); }));
  for (std::size_t i = 0; i < outputs.size(); i += sim::parameter_count)
    for (const double value : model.targets.unscale(std::span(outputs).subspan(i, sim::parameter_count)))
      expected.push_back(static_cast<float>(value));
  CHECK(test::read_text(folder / "out/results.bin") == test::as_bytes(expected));
}

}  // namespace

TEST_CASE("Cortex-M4F under QEMU: the bits of identify") {
  check_cpu("m4");
}
TEST_CASE("Cortex-M7 under QEMU: the bits of identify") {
  check_cpu("m7");
}

}  // namespace decid::tools
