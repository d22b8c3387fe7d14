// Protocols in files: see protocol_file.hpp.
#include "recording/protocol_file.hpp"

#include <filesystem>
#include <system_error>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/setting.hpp"
#include "recording/detail/tilt/measured_tilt.hpp"
#include "sim/protocol/protocol_json.hpp"

namespace decid::recording {
namespace {

/// The size of a million samples of a measured tilt with blanks; a larger file is not a protocol.
constexpr std::size_t protocol_limit_bytes = std::size_t{1} << 26;

}  // namespace

sim::Protocol load_protocol(const std::string& name_or_path, std::vector<std::string>* files, Warnings* warnings,
                            const std::string& controller) {
  const sim::BodyModel& asked =
      controller.empty() ? sim::single_pendulum() : sim::find_body_model(controller, setting("controller"));
  if (name_or_path == "default" || name_or_path == "short") {
    sim::Protocol protocol = name_or_path == "short" ? sim::short_protocol() : sim::default_protocol();
    protocol.experiment.body_model = &asked;
    return protocol;
  }
  std::error_code ignored;
  if (!std::filesystem::exists(name_or_path, ignored)) {
    throw Error(Code::file_missing, name_or_path, "is neither a built-in protocol nor a file",
                "use default, short, or the path of a JSON file");
  }
  if (files) files->push_back(name_or_path);
  const std::filesystem::path path = name_or_path;
  const auto read_tilt = [&](const sim::TiltFileReference& named, double sample_rate_hz) {
    TiltFile tilt;
    tilt.path = path.parent_path() / named.file;
    tilt.column = named.column;
    if (named.says_unit) tilt.unit = named.in_degrees ? Unit::degree : Unit::radian;
    tilt.rate_hz = named.rate_hz;
    tilt.is_cycle = named.is_cycle;
    if (files) files->push_back(tilt.path.string());
    return read_tilt_deg(tilt, sample_rate_hz, warnings);
  };
  sim::Protocol protocol = sim::protocol_from_text(
      read_file(name_or_path, protocol_limit_bytes),
      {.where = name_or_path, .name = path.stem().string(), .read_tilt = read_tilt, .controller = &asked});
  const std::string& own = protocol.experiment.body_model->name;
  if (!controller.empty() && own != controller)
    throw Error(Code::setting_conflict, name_or_path,
                "has the controller '" + own + "', and " + setting("controller") + " is '" + controller + "'",
                "give the protocol's controller, or none");
  return protocol;
}

}  // namespace decid::recording
