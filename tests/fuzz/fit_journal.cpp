// Journals of fits, behind a front of the right settings, as they are and as one entry with its hash set right. A
// recording that is appended is read back.
#include "tools/decid/commands/fit_journal.hpp"

#include "tests/fuzz/fuzz.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::InputFile input("fit.json.journal");
  const std::string text(fuzz::to_text(data, size)), settings = "{}";
  const std::string front = "decid fit journal 6\n" + fuzz::journal_entry(settings);
  for (const std::string& rest : {text, fuzz::journal_entry(text)}) {
    const std::filesystem::path& path = input.write(front + rest);
    fuzz::accepts([&] {
      tools::FitJournal journal(path, settings, true);
      journal.find("name");
      RecordingResult result;
      result.file = "r.csv";
      journal.append("key", result);
    });
    fuzz::accepts([&] {
      const std::optional<RecordingResult> found = tools::FitJournal(path, settings, true).find("key");
      REQUIRE_THAT(found && found->file == "r.csv");
    });
  }
  return 0;
}
