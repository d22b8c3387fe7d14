// The journal of a fit: see fit_journal.hpp.
#include "tools/decid/fit_journal.hpp"

#include <filesystem>
#include <string_view>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/files/sha256.hpp"

namespace decid::tools {
namespace {

std::string text_of(const Json& line) {
  return line.dump(-1, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace

FitJournal::FitJournal(const std::filesystem::path& path, const Json& settings, bool resume)
    : file_(path, DiskFile::Access::write) {
  if (!file_.try_lock()) throw Error(path.string(), "is being written by another process", "wait until that has ended");
  if (resume) read(settings);
  file_.truncate(end_);
  if (end_ == 0) write_line(settings);
}

void FitJournal::read(const Json& settings) {
  const std::string content = read_file(file_.path());
  for (std::size_t begin = 0; begin < content.size();) {
    const std::size_t end = content.find('\n', begin);
    if (end == std::string::npos) return;
    Json line;
    try {
      line = parse_json(content.substr(begin, end - begin), file_.path().string());
    } catch (const Error&) {
      return;
    }
    if (begin == 0 && content.substr(0, end + 1) != text_of(settings))
      throw Error(file_.path().string(), "is of other settings",
                  "give the options of the call that wrote it, or leave out --resume to begin anew");
    if (begin > 0 && (!line.contains("recording") || !line["recording"].is_string() || !line.contains("result")))
      return;
    if (begin > 0) results_.insert_or_assign(line["recording"].get<std::string>(), line["result"]);
    begin = end + 1;
    end_ = begin;
  }
}

std::string FitJournal::key(const RecordingSource& recording) {
  try {
    return sha256(recording.name() + '\n' + sha256(read_file(recording.file)));
  } catch (const Error&) {
    return {};  // whoever reads the recording reports it
  }
}

const Json* FitJournal::find(const std::string& key) const {
  if (key.empty()) return nullptr;  // standard input, which another call has none of
  const auto found = results_.find(key);
  return found == results_.end() ? nullptr : &found->second;
}

void FitJournal::append(const std::string& key, const Json& result) {
  write_line({{"recording", key}, {"result", result}});
}

void FitJournal::remove() {
  std::error_code ignored;
  std::filesystem::remove(file_.path(), ignored);
}

void FitJournal::write_line(const Json& line) {
  const std::string text = text_of(line);
  file_.write(end_, text);
  file_.sync();
  end_ += text.size();
}

}  // namespace decid::tools
