// The journal of an unfinished data set: see journal.hpp.
#include "dataset/npz/detail/journal.hpp"

namespace decid::dataset {
namespace {

struct Stored {
  std::int64_t trials_before = 0;
  JournalEntry entry;
  template <class Archive>
  void archive(Archive& a) {
    a(trials_before, entry.sway_crc32, entry.chunk.base_attempts, entry.chunk.child_attempts);
    entry.chunk.trials.resize(a.count(entry.chunk.trials.size()));
    for (TrialRecord& trial : entry.chunk.trials) a(trial.parameters, trial.peak_to_peak_rad, trial.group);
  }
};

}  // namespace

std::optional<JournalEntry> ChunkJournal::next(int trials) {
  const std::optional<std::string> bytes = journal_.next();
  if (!bytes) return std::nullopt;
  last_size_ = bytes->size();
  try {
    Stored stored = from_bytes<Stored>(*bytes);
    if (stored.trials_before == trials) return std::move(stored.entry);
  } catch (const Error&) {
  }
  back();
  return std::nullopt;
}

void ChunkJournal::append(const JournalEntry& entry, int trials_before) {
  journal_.append(to_bytes(Stored{trials_before, entry}));
}

}  // namespace decid::dataset
