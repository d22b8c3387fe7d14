// The posterior's part of "the same bits everywhere": also with clang, and on AArch64.
#include <string>

#include "base/files/sha256.hpp"
#include "posterior/posterior.hpp"
#include "tests/helpers.hpp"
#include "tests/posterior/sampling/quick.hpp"
#include "tests/posterior/trial.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

TEST_CASE("sample: golden draws" * doctest::test_suite("golden")) {
  const sim::Protocol protocol = sines_protocol();
  const Density density(protocol, {});
  Settings settings = quick();
  settings.max_draws = 4;
  settings.block = 4;
  settings.max_leapfrog_steps = 8;
  const Posterior found = sample(density, density.observe(recorded(protocol, some_parameters(), 0.02, 0)), settings);
  std::string bytes;
  for (const State& state : found.states()) {
    for (std::size_t place = 0; place < static_cast<std::size_t>(density.globals()); ++place) {
      const double value = Posterior::value(state, density.quantity(place));
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
    }
  }
  CHECK(sha256(bytes) == "0f07f8049242e1619702afe802220d0392ed7e6db01861f338953483d4611d77");
}
