// The journal of an unfinished data set.
#include "dataset/npz/detail/journal.hpp"

#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

namespace fs = std::filesystem;

TEST_CASE("a journal holds as many parameters as a trial has") {
  const TemporaryFolder folder;
  for (const std::size_t parameters : {std::size_t{7}, std::size_t{14}, sim::Parameters::max_parameters}) {
    const fs::path path = folder / std::to_string(parameters).c_str();
    JournalEntry entry;
    entry.sway_crc32 = 0x12345678;
    entry.chunk.base_attempts = 9;
    entry.chunk.child_attempts = 4;
    for (std::int32_t i = 0; i < 3; ++i) {
      TrialRecord trial{sim::Parameters(parameters), 0.01 * i, i % 2};
      for (std::size_t p = 0; p < parameters; ++p) trial.parameters[p] = 1.0 / (1.0 + static_cast<double>(p) + i);
      entry.chunk.trials.push_back(trial);
    }
    {
      ChunkJournal journal(path);
      journal.start("request");
      journal.append(entry, 0);
      journal.append(entry, 3);
    }
    ChunkJournal journal(path);
    REQUIRE(journal.request() == "request");
    // The name, the text, and two entries of three trials; 72 bytes in front of each.
    CHECK(fs::file_size(path) == 16 + 72 + 7 + 2 * (72 + 36 + 3 * (8 * parameters + 20)));
    for (const int before : {0, 3}) {
      const std::optional<JournalEntry> read = journal.next(before);
      REQUIRE(read);
      CHECK(read->sway_crc32 == entry.sway_crc32);
      CHECK(read->chunk.base_attempts == 9);
      CHECK(read->chunk.child_attempts == 4);
      REQUIRE(read->chunk.trials.size() == 3);
      for (std::size_t i = 0; i < 3; ++i) {
        CHECK(read->chunk.trials[i].parameters == entry.chunk.trials[i].parameters);
        CHECK(read->chunk.trials[i].peak_to_peak_rad == entry.chunk.trials[i].peak_to_peak_rad);
        CHECK(read->chunk.trials[i].group == entry.chunk.trials[i].group);
      }
    }
    CHECK_FALSE(journal.next(6));
    journal.back();
    CHECK_FALSE(journal.next(0));
    CHECK(journal.next(3));
  }
}
