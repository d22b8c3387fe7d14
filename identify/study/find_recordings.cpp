// Files that may be recordings: see find_recordings.hpp.
#include "identify/study/find_recordings.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/text.hpp"
#include "recording/formats/xlsx.hpp"

namespace decid {
namespace fs = std::filesystem;
namespace {

/// Begins and ends of the lines of names in decid's results.
constexpr auto headers_of_results = std::to_array<std::pair<std::string_view, std::string_view>>(
    {{"file,trust,", ",protocol,controller,model_sha256,decid,error"},
     {"file,participant_id,", ",protocol,controller,model_sha256,decid,error"},
     {".chain,.iteration,.draw,", ""},
     {"file,.chain,.iteration,.draw,", ""},
     {"parameter,unit,participant_id,", ",value,low90,high90,mgh"},
     {"parameter,unit,participant_id,", ",value,mgh"},
     {"participant_id,session,group,condition,file,frequency_hz,gain,phase_deg", ""}});

/// Returns a workbook's first row, with commas between its cells; empty for another file.
std::string first_line_of_workbook(const fs::path& path) {
  try {
    std::string line = recording::read_first_row(read_file(path), path.string());
    std::ranges::replace(line, '\t', ',');
    return line;
  } catch (const Error&) {  // reading it as a recording says why
    return {};
  }
}

}  // namespace

bool is_hidden(const fs::path& path) {
  const std::string name = path.filename().string();
  return name.starts_with('.') || name.starts_with("~$");
}

bool has_ending_of_recordings(const fs::path& path) {
  return std::ranges::find(endings_of_recordings, lower_case(path.extension().string())) != endings_of_recordings.end();
}

bool is_description(const fs::path& path) {
  constexpr std::array<std::string_view, 6> whole{"license",   "licence",      "changes",
                                                  "changelog", "participants", "samples"};
  constexpr std::array<std::string_view, 5> suffixes{"_scans", "_sessions", "_channels", "_electrodes", "_events"};
  const std::string stem = lower_case(path.stem().string());
  return stem.starts_with("readme") || std::ranges::find(whole, stem) != whole.end() ||
         std::ranges::any_of(suffixes, [&](std::string_view suffix) { return stem.ends_with(suffix); });
}

bool is_table_of_results(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string line(std::size_t{1} << 14, '\0');  // tables begin with their names; a sheet's columns are among these
  file.read(line.data(), static_cast<std::streamsize>(line.size()));
  line.resize(static_cast<std::size_t>(file.gcount()));
  if (line.starts_with("PK")) line = first_line_of_workbook(path);
  line.resize(std::min(line.find('\n'), line.size()));
  std::erase_if(line, [](char c) { return c == '"' || c == '\r'; });
  std::ranges::replace(line, ';', ',');  // of --excel comma
  if (const std::string_view mark = "\xEF\xBB\xBF"; line.starts_with(mark)) line.erase(0, mark.size());
  return std::ranges::any_of(headers_of_results, [&](const auto& ends) {
    return line.starts_with(ends.first) && line.ends_with(ends.second);
  });
}

std::vector<fs::path> recordings_below(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder.empty() ? "." : folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code ignored;
    const fs::path& path = entry->path();
    if (entry->is_directory(ignored)) {
      if (is_hidden(path)) entry.disable_recursion_pending();
    } else if (entry->is_regular_file(ignored) && !is_hidden(path) && has_ending_of_recordings(path) &&
               !is_description(path) && !is_table_of_results(path)) {
      names.push_back(path.string());
    }
  }
  std::ranges::sort(names);
  std::vector<fs::path> found;
  for (const std::string& name : names) found.push_back(fs::path(name).lexically_normal());  // no "./"
  return found;
}

}  // namespace decid
