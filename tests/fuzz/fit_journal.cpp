// Journals of fits, behind a first line of the right settings. A line that is appended is read back.
#include "tools/decid/fit_journal.hpp"

#include "tests/fuzz/fuzz.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile input("fit.json.journal");
  const Json settings{{"version", 1}};
  const std::filesystem::path& path = input.write("{\"version\":1}\n" + std::string(fuzz::text_of(data, size)));
  fuzz::accepts([&] { tools::FitJournal(path, settings, true).append("key", {{"value", 0.5}}); });
  fuzz::accepts([&] {
    const tools::FitJournal journal(path, settings, true);
    const Json* found = journal.find("key");
    REQUIRE_THAT(found != nullptr && found->at("value") == 0.5);
  });
  return 0;
}
