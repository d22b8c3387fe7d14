// Sidecars of BIDS' sheets: see sidecar.hpp.
#include "identify/study/sidecar.hpp"

#include <cstdint>
#include <system_error>

#include "base/files/file.hpp"
#include "base/files/json_object.hpp"

namespace decid {
namespace {

constexpr std::uint64_t max_sidecar_bytes = std::uint64_t{1} << 22;

}  // namespace

std::optional<std::filesystem::path> sidecar_of(const std::filesystem::path& sheet) {
  const std::string name = sheet.filename().string();
  if (name != "participants.tsv" && !name.ends_with("_sessions.tsv") && !name.ends_with("_scans.tsv")) return {};
  std::filesystem::path sidecar = sheet;
  sidecar.replace_extension(".json");
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(sidecar, ignored)) return {};
  return sidecar;
}

std::map<std::string, std::string> sidecar_units(const std::filesystem::path& sheet) {
  std::map<std::string, std::string> units;
  const std::optional<std::filesystem::path> sidecar = sidecar_of(sheet);
  if (!sidecar) return units;
  const Json all = parse_json(read_file(*sidecar, max_sidecar_bytes), sidecar->string());
  if (!all.is_object()) return units;
  for (const auto& [column, description] : all.items())
    if (description.is_object() && description.contains("Units") && description["Units"].is_string())
      units.emplace(column, description["Units"].get<std::string>());
  return units;
}

}  // namespace decid
