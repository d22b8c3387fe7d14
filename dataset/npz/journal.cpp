// The journal: see journal.hpp.
#include "dataset/npz/journal.hpp"

#include <cstring>
#include <vector>

#include "dataset/npz/zip.hpp"

namespace decid::dataset {
namespace {

constexpr std::string_view journal_magic = "decid journal 1\n";
constexpr std::uint32_t entry_mark = 0x79727465;  // "etry"
constexpr std::uint32_t longest_request = 1 << 24;

struct Front {
  std::uint32_t length, crc32;
};

struct EntryFront {
  std::uint32_t mark = entry_mark;
  std::uint32_t trials = 0;
  std::int64_t trials_before = 0, base_attempts = 0, child_attempts = 0;
  std::uint32_t sway_crc32 = 0;
  std::uint32_t crc32 = 0;  // of the entry, this field being 0
};
static_assert(sizeof(EntryFront) == 40);

// A trial: its parameters, peak_to_peak_rad, group as int32 and four zero bytes.

template <class T>
bool read_value(const DiskFile& file, std::uint64_t position, T& value) {
  return file.read(position, std::as_writable_bytes(std::span(&value, 1))) == sizeof value;
}

std::uint32_t checksum(EntryFront front, std::span<const std::byte> trials) {
  front.crc32 = 0;
  return crc32_joined(crc32(std::as_bytes(std::span(&front, 1))), crc32(trials), trials.size());
}

}  // namespace

std::optional<std::string> Journal::request() {
  std::string mark(journal_magic.size(), '\0');
  Front front{};
  if (file_.read(0, std::as_writable_bytes(std::span(mark))) != mark.size() || mark != journal_magic ||
      !read_value(file_, journal_magic.size(), front) || front.length > longest_request) {
    return std::nullopt;
  }
  const std::uint64_t start = journal_magic.size() + sizeof front;
  std::string text(front.length, '\0');
  if (file_.read(start, std::as_writable_bytes(std::span(text))) != text.size() ||
      crc32(std::as_bytes(std::span(text))) != front.crc32) {
    return std::nullopt;
  }
  position_ = start + text.size();
  return text;
}

void Journal::start(const std::string& request) {
  const Front front{static_cast<std::uint32_t>(request.size()), crc32(std::as_bytes(std::span(request)))};
  std::string content(journal_magic);
  content.append(reinterpret_cast<const char*>(&front), sizeof front);
  content += request;
  file_.truncate(0);
  file_.write(0, content);
  file_.sync();
  position_ = content.size();
}

std::uint64_t Journal::bytes_of(std::size_t trials) const {
  return sizeof(EntryFront) + trials * trial_bytes();
}

std::size_t Journal::trial_bytes() const {
  return (parameters_ + 1) * sizeof(double) + 2 * sizeof(std::int32_t);
}

std::optional<JournalEntry> Journal::read(int trials) const {
  EntryFront front;
  if (!read_value(file_, position_, front) || front.mark != entry_mark || front.trials_before != trials ||
      bytes_of(front.trials) > file_.size() - position_) {
    return std::nullopt;
  }
  std::vector<std::byte> stored(front.trials * trial_bytes());
  if (file_.read(position_ + sizeof front, stored) != stored.size() || checksum(front, stored) != front.crc32) {
    return std::nullopt;
  }
  JournalEntry entry;
  entry.sway_crc32 = front.sway_crc32;
  entry.chunk.base_attempts = front.base_attempts;
  entry.chunk.child_attempts = front.child_attempts;
  const std::byte* from = stored.data();
  const auto take = [&from](void* value, std::size_t bytes) {
    std::memcpy(value, from, bytes);
    from += bytes;
  };
  for (std::uint32_t i = 0; i < front.trials; ++i) {
    TrialRecord trial{sim::Parameters(parameters_), 0.0, 0};
    take(trial.parameters.begin(), parameters_ * sizeof(double));
    take(&trial.peak_to_peak_rad, sizeof(double));
    take(&trial.group, sizeof(std::int32_t));
    from += sizeof(std::int32_t);
    entry.chunk.trials.push_back(trial);
  }
  return entry;
}

void Journal::pass(const JournalEntry& entry) {
  position_ += bytes_of(entry.chunk.trials.size());
}

void Journal::append(const JournalEntry& entry, int trials_before) {
  EntryFront front;
  front.trials = static_cast<std::uint32_t>(entry.chunk.trials.size());
  front.trials_before = trials_before;
  front.base_attempts = entry.chunk.base_attempts;
  front.child_attempts = entry.chunk.child_attempts;
  front.sway_crc32 = entry.sway_crc32;
  std::vector<std::byte> stored(entry.chunk.trials.size() * trial_bytes());
  std::byte* to = stored.data();
  const auto put = [&to](const void* value, std::size_t bytes) {
    std::memcpy(to, value, bytes);
    to += bytes;
  };
  for (const TrialRecord& trial : entry.chunk.trials) {
    put(trial.parameters.begin(), parameters_ * sizeof(double));
    put(&trial.peak_to_peak_rad, sizeof(double));
    put(&trial.group, sizeof(std::int32_t));
    to += sizeof(std::int32_t);
  }
  front.crc32 = checksum(front, stored);
  const std::span<const std::byte> pieces[]{std::as_bytes(std::span(&front, 1)), stored};
  if (file_.size() > position_) file_.truncate(position_);
  file_.write(position_, pieces);
  pass(entry);
}

}  // namespace decid::dataset
