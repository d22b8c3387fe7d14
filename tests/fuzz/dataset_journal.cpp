// The journal of a data set that is being made, as it is and as one entry with its hash set right.
#include "dataset/npz/detail/journal.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace decid;

namespace {

void read(std::string_view bytes) {
  static const fuzz::InputFile input("data.npz.journal");
  const std::filesystem::path& path = input.write(bytes);
  fuzz::accepts([&] {
    dataset::ChunkJournal journal(path);
    if (!journal.request()) return;
    int trials = 0;
    while (const auto found = journal.next(trials)) {
      trials += static_cast<int>(found->chunk.trials.size());
      if (found->chunk.trials.empty()) break;
    }
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(fuzz::to_text(data, size));
  read(text);
  read("decid journal 2\n" + fuzz::journal_entry("{}") + fuzz::journal_entry(text));
  return 0;
}
