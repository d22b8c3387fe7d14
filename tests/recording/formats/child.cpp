// Tests of recording/formats/detail/child.hpp.
#include "recording/formats/detail/child.hpp"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::recording;
using decid::test::TemporaryFolder;

namespace {

constexpr ChildLimits plenty{std::size_t{256} << 20, 20};

}  // namespace

TEST_CASE("a child's answer comes back, of any length and any bytes") {
  for (const std::size_t length : {0U, 1U, 65536U, 1000000U}) {
    std::string wanted(length, '\0');
    for (std::size_t i = 0; i < length; ++i) wanted[i] = static_cast<char>(i * 31 % 256);
    const auto answer = in_child([&] { return wanted; }, plenty);
    REQUIRE(answer.has_value());
    CHECK((*answer == wanted));
  }
}

TEST_CASE("a child that throws, crashes or exits has no answer, and the caller goes on") {
  CHECK(!in_child([]() -> std::string { throw std::runtime_error("no"); }, plenty));
  CHECK(!in_child([]() -> std::string { std::abort(); }, plenty));
  CHECK(!in_child([]() -> std::string { std::_Exit(0); }, plenty));
  CHECK(in_child([] { return std::string("on"); }, plenty) == "on");
}

TEST_CASE("a child has a time limit") {
  volatile unsigned count = 0;
  CHECK(!in_child(
      [&]() -> std::string {
        for (;;) count = count + 1;
      },
      {plenty.memory_bytes, 1}));
}

#if !defined(DECID_SANITIZED) && !defined(DECID_EMULATED)
TEST_CASE("a child has a memory limit above the parent's use") {
  const auto use = [](std::size_t bytes) {
    return [bytes] {
      const std::vector<char> memory(bytes, 1);
      return std::to_string(memory.size());
    };
  };
  CHECK(in_child(use(std::size_t{64} << 20), plenty) == std::to_string(64 << 20));
  CHECK(!in_child(use(std::size_t{512} << 20), plenty));
}
#endif

TEST_CASE("a child can read files and write none") {
  const TemporaryFolder scratch;
  const std::filesystem::path here = scratch / "here", made = scratch / "made";
  std::ofstream(here) << "text";
  CHECK(in_child(
            [&] {
              std::string text;
              std::ifstream(here) >> text;
              return text;
            },
            plenty) == "text");
  const auto answer = in_child(
      [&] {
        std::ofstream file(made);
        file << "text" << std::flush;
        return std::string("written");
      },
      plenty);
  CHECK(!answer.has_value());
  CHECK((!std::filesystem::exists(made) || std::filesystem::file_size(made) == 0));
}
