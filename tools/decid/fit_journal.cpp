// The journal of a fit: see fit_journal.hpp.
#include "tools/decid/fit_journal.hpp"

#include <cstring>
#include <filesystem>
#include <string_view>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/sha256.hpp"
#include "identify/result_archive.hpp"

namespace decid::tools {
namespace {

constexpr std::string_view magic = "decid fit journal 3\n";
constexpr std::size_t hash_size = 64;
constexpr std::size_t front_size = sizeof(std::uint64_t) + hash_size;

/// Returns the text of the entry at the beginning of `content`, if the entry is complete.
std::optional<std::string_view> entry_of(std::string_view content) {
  std::uint64_t size = 0;
  if (content.size() < front_size) return std::nullopt;
  std::memcpy(&size, content.data(), sizeof size);
  if (size > content.size() - front_size) return std::nullopt;
  const std::string_view text = content.substr(front_size, static_cast<std::size_t>(size));
  if (sha256(text) != content.substr(sizeof size, hash_size)) return std::nullopt;
  return text;
}

/// A recording's entry.
struct Entry {
  std::string key, result;
  template <class Archive>
  void archive(Archive& a) {
    a(key, result);
  }
};

}  // namespace

FitJournal::FitJournal(const std::filesystem::path& path, const std::string& settings, bool resume)
    : file_(path, DiskFile::Access::write) {
  if (!file_.try_lock()) throw Error(path.string(), "is being written by another process", "wait until that has ended");
  if (resume) read(settings);
  file_.truncate(end_);
  if (end_ > 0) return;
  file_.write(0, std::string(magic));
  end_ = magic.size();
  write_entry(settings);
}

void FitJournal::read(const std::string& settings) {
  const std::string content = read_file(file_.path());
  std::string_view rest = content;
  if (!rest.starts_with(magic)) return;
  rest.remove_prefix(magic.size());
  bool is_first = true;
  while (const std::optional<std::string_view> text = entry_of(rest)) {
    if (is_first && *text != settings)
      throw Error(file_.path().string(), "is of other settings",
                  "give the options of the call that wrote it, or leave out --resume to start again");
    try {
      if (!is_first) {
        Entry entry = from_bytes<Entry>(*text);
        results_.insert_or_assign(std::move(entry.key), std::move(entry.result));
      }
    } catch (const Error&) {
      return;
    }
    is_first = false;
    rest.remove_prefix(front_size + text->size());
    end_ = content.size() - rest.size();
  }
}

std::string FitJournal::key(const RecordingSource& recording, const std::string& settings) {
  try {
    return sha256(recording.name() + '\n' + sha256(read_file(recording.file)) + settings);
  } catch (const Error&) {
    return {};  // whoever reads the recording reports it
  }
}

std::optional<RecordingResult> FitJournal::find(const std::string& key) const {
  const auto found = results_.find(key);
  if (key.empty() || found == results_.end()) return std::nullopt;  // no other call has the standard input of this one
  try {
    return from_bytes<RecordingResult>(found->second);
  } catch (const Error&) {
    return std::nullopt;
  }
}

void FitJournal::append(const std::string& key, const RecordingResult& result) {
  write_entry(to_bytes(Entry{key, to_bytes(result)}));
}

void FitJournal::remove() {
  std::error_code ignored;
  std::filesystem::remove(file_.path(), ignored);
}

void FitJournal::write_entry(const std::string& text) {
  const std::uint64_t size = text.size();
  std::string bytes(sizeof size, '\0');
  std::memcpy(bytes.data(), &size, sizeof size);
  bytes += sha256(text) + text;
  file_.write(end_, bytes);
  file_.sync();
  end_ += bytes.size();
}

}  // namespace decid::tools
