// Recordings of BIDS' motion extension: see motion_bids.hpp.
#include "recording/formats/motion_bids.hpp"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "recording/formats/encoding.hpp"
#include "recording/table/cells.hpp"

namespace decid::recording {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view motion_end = "_motion.tsv", channels_end = "_channels.tsv", json_end = "_motion.json";
constexpr int folders_above = 4;  // of a data set: recording, session, subject, data set
constexpr std::uint64_t max_description_bytes = std::uint64_t{1} << 22;

std::vector<std::string> entities_of(const std::string& name) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('_', begin), name.size());
    parts.push_back(name.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

/// Returns the file beside the recording with this end of its name ("_channels.tsv"), from the nearest folder.
std::optional<fs::path> file_beside(const fs::path& recording, std::string_view end) {
  const std::string name = recording.filename().string();
  const std::vector<std::string> own = entities_of(name.substr(0, name.size() - motion_end.size()));
  std::error_code error;
  fs::path folder = fs::absolute(recording, error).parent_path();
  for (int above = 0; above <= folders_above; ++above, folder = folder.parent_path()) {
    std::optional<fs::path> found;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
      const std::string other = entry.path().filename().string();
      const bool at_start = other == end.substr(1);  // "channels.tsv" of all recordings
      if (!at_start && !other.ends_with(end)) continue;
      const std::vector<std::string> theirs =
          at_start ? std::vector<std::string>{} : entities_of(other.substr(0, other.size() - end.size()));
      const bool is_ours = std::ranges::all_of(
          theirs, [&](const std::string& entity) { return std::ranges::find(own, entity) != own.end(); });
      if (is_ours && (!found || other.size() > found->filename().string().size())) found = entry.path();
    }
    if (found) return found;
    if (folder == folder.parent_path()) break;
  }
  return {};
}

/// Returns the channels' names, with units: "com_sway (deg)".
std::vector<std::string> names_in(const fs::path& path) {
  const std::string where = path.string(), text = to_utf8(read_file(path, max_description_bytes), where);
  std::vector<std::string> names;
  std::vector<std::string_view> cells, header;
  std::optional<std::size_t> name, type, units;
  for_each_line(text, [&](std::string_view line, std::size_t number) {
    split(line, '\t', cells);
    if (header.empty()) {
      header = cells;
      const auto column = [&](std::string_view wanted) -> std::optional<std::size_t> {
        const auto found = std::ranges::find(header, wanted);
        if (found == header.end()) return {};
        return static_cast<std::size_t>(found - header.begin());
      };
      name = column("name");
      type = column("type");
      units = column("units");
      if (!name)
        throw Error(Code::column_missing, where, "has no column 'name'", "write one line per channel, as BIDS has it");
      return true;
    }
    if (cells.size() < header.size())
      throw Error(Code::file_damaged, where, "line " + std::to_string(number) + " is too short",
                  "separate its cells by tabs");
    const bool is_time = type && cells[*type] == "LATENCY";
    const std::string_view unit = units ? cells[*units] : std::string_view();
    names.push_back(
        with_unit(is_time ? "time" : std::string(cells[*name]), is_missing(unit) ? std::string_view() : unit));
    return true;
  });
  return names;
}

std::vector<StatedRate> rates_of(const fs::path& path) {
  const Json all = parse_json(read_file(path, max_description_bytes), path.string());
  for (const char* key : {"SamplingFrequency", "SamplingFrequencyEffective"}) {
    if (!all.is_object() || !all.contains(key) || all[key] == "n/a") continue;
    if (!all[key].is_number())
      throw Error(Code::value_invalid, path.string(), std::string(key) + " is not a number", "give it in Hz");
    return {{all[key].get<double>(), key, true}};
  }
  return {};
}

}  // namespace

bool is_motion_bids(const fs::path& path) {
  return path.filename().string().ends_with(motion_end);
}

void read_motion_bids(const fs::path& path, CsvTable& table) {
  const std::optional<fs::path> channels = file_beside(path, channels_end);
  if (table.has_header() || !channels) return;
  std::vector<std::string> names = names_in(*channels);
  if (std::ssize(names) != table.columns())
    throw Error(
        Code::file_damaged, path.string(),
        format("has %d columns, and %s has %zu channels", table.columns(), channels->string().c_str(), names.size()),
        "correct one of the files");
  const std::optional<fs::path> json = file_beside(path, json_end);
  table.describe(std::move(names), json ? rates_of(*json) : std::vector<StatedRate>());
}

std::vector<fs::path> files_beside(const fs::path& path) {
  std::vector<fs::path> files;
  if (!is_motion_bids(path)) return files;
  for (const std::string_view end : {channels_end, json_end})
    if (const std::optional<fs::path> found = file_beside(path, end))
      files.push_back(path.is_relative() ? found->lexically_proximate(fs::current_path()) : *found);
  return files;
}

}  // namespace decid::recording
