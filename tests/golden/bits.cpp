// Compares the log and the weights of a two-epoch training on streamed trials with their SHA-256. Every instruction
// set, number of threads, compiler and processor gives the same bits.

#include <string>

#include "base/files/sha256.hpp"
#include "base/isa.hpp"
#include "tests/tools/decid/run.hpp"

using namespace decid::test;

namespace {

/// SHA-256 of the log and of the weights.
std::string train(const std::string& environment, const std::string& options) {
  const Folder folder;
  const auto trained = run_ok(
      "train --stream --preset small --stream-trials 128 --validation-trials 32 --epochs 2 --seed 5 --quiet --json "
      "-o " +
          folder / "m.safetensors" + options,
      environment);
  const std::string key = "\"weights_sha256\": \"";
  const std::size_t place = trained.out.find(key);
  REQUIRE(place != std::string::npos);
  return decid::sha256(read_text(folder / "m.safetensors.log.csv")) + " " + trained.out.substr(place + key.size(), 64);
}

constexpr const char* golden =
    "844458f238b6bb5d09e76500fbefa32d5138d49018d3b3b7c88db127a6c4d654 "
    "ad2a40550c932b3b6e97e1655532ca8ce4b27199ec0da89dd23d9eeafd5d0ec0";

}  // namespace

TEST_CASE("golden: two epochs on new trials, with every instruction set" * doctest::test_suite("golden")) {
  const auto instruction_sets = decid::available_isas();
  CHECK(instruction_sets.size() >= 2);  // the reference, and the processor's
  for (const decid::Isa isa : instruction_sets) {
    CAPTURE(decid::name(isa));
    CHECK(train(std::string("DECID_ISA=") + decid::name(isa) + " ", "") == golden);
  }
}

TEST_CASE("golden: two epochs on new trials, with any number of threads" * doctest::test_suite("golden")) {
  for (const char* threads : {"1", "2", "3", "8"}) {
    CAPTURE(threads);
    CHECK(train("", std::string(" --threads ") + threads) == golden);
  }
}

TEST_CASE("golden: decid selftest" * doctest::test_suite("golden")) {
  const auto said = run_decid("selftest");
  CAPTURE(said.out);
  CHECK(said.code == 0);
  CHECK(said.out.starts_with("ok "));
  CHECK_FALSE(contains(said.out, "WRONG"));
  CHECK(contains(said.out, " have the expected bits, in "));
  const auto tested = run_decid("selftest --json");
  CAPTURE(tested.out);
  CHECK(tested.code == 0);
  CHECK(contains(tested.out, "\"ok\": true"));
  CHECK(contains(tested.out, golden + 65));
}
