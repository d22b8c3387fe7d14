// The journal: see journal.hpp.
#include "dataset/npz/journal.hpp"

#include <cstring>
#include <vector>

#include "dataset/npz/zip.hpp"

namespace decid::dataset {
namespace {

constexpr std::string_view magic = "decid journal 1\n";
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

struct StoredTrial {
  sim::Parameters parameters;
  double peak_to_peak_rad;
  std::int32_t group, unused;
};
static_assert(sizeof(StoredTrial) == 72);

std::uint64_t bytes_of(std::size_t trials) {
  return sizeof(EntryFront) + trials * sizeof(StoredTrial);
}

template <class T>
bool read_value(const DiskFile& file, std::uint64_t position, T& value) {
  return file.read(position, std::as_writable_bytes(std::span(&value, 1))) == sizeof value;
}

std::uint32_t checksum(EntryFront front, std::span<const StoredTrial> trials) {
  front.crc32 = 0;
  const auto rest = std::as_bytes(trials);
  return crc32_joined(crc32(std::as_bytes(std::span(&front, 1))), crc32(rest), rest.size());
}

}  // namespace

std::optional<std::string> Journal::request() {
  std::string mark(magic.size(), '\0');
  Front front{};
  if (file_.read(0, std::as_writable_bytes(std::span(mark))) != mark.size() || mark != magic ||
      !read_value(file_, magic.size(), front) || front.length > longest_request) {
    return std::nullopt;
  }
  const std::uint64_t start = magic.size() + sizeof front;
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
  std::string content(magic);
  content.append(reinterpret_cast<const char*>(&front), sizeof front);
  content += request;
  file_.truncate(0);
  file_.write(0, content);
  file_.sync();
  position_ = content.size();
}

std::optional<JournalEntry> Journal::read(int trials) const {
  EntryFront front;
  if (!read_value(file_, position_, front) || front.mark != entry_mark || front.trials_before != trials ||
      bytes_of(front.trials) > file_.size() - position_) {
    return std::nullopt;
  }
  std::vector<StoredTrial> stored(front.trials);
  const auto rest = std::as_writable_bytes(std::span(stored));
  if (file_.read(position_ + sizeof front, rest) != rest.size() || checksum(front, stored) != front.crc32) {
    return std::nullopt;
  }
  JournalEntry entry;
  entry.sway_crc32 = front.sway_crc32;
  entry.chunk.base_attempts = front.base_attempts;
  entry.chunk.child_attempts = front.child_attempts;
  for (const StoredTrial& trial : stored) {
    entry.chunk.trials.push_back({trial.parameters, trial.peak_to_peak_rad, trial.group});
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
  std::vector<StoredTrial> stored;
  for (const TrialRecord& trial : entry.chunk.trials) {
    stored.push_back({trial.parameters, trial.peak_to_peak_rad, trial.group, 0});
  }
  front.crc32 = checksum(front, stored);
  const std::span<const std::byte> pieces[]{std::as_bytes(std::span(&front, 1)), std::as_bytes(std::span(stored))};
  if (file_.size() > position_) file_.truncate(position_);
  file_.write(position_, pieces);
  pass(entry);
}

}  // namespace decid::dataset
