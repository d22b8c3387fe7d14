// A recording as a lab would hand it over: a CSV file of time, sway and tilt of one trial of the default protocol.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/text.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"
#include "tools/decid/commands/trial_csv.hpp"

namespace decid::bench {

/// A folder of its own that goes with all that is in it.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "decid-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr)
      throw Error(Code::file_unwritable, name, "cannot be made", "let TMPDIR name a writable folder");
    path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

class RecordedFile {
 public:
  RecordedFile() {
    const sim::Simulator simulator(sim::default_protocol());
    std::vector<double> sway(static_cast<std::size_t>(simulator.samples()));
    simulator.run(sim::single_pendulum().parameters.middle(), Random(7, sim::streams::vestibular_noise, 0), sway);
    for (double& s : sway) s /= sim::rad_per_deg;
    auto columns = tools::time_and_tilt(simulator.protocol(), simulator.stimulus());
    columns.insert(columns.begin() + 1, std::move(sway));
    write_file(path(), csv({"time", "com_sway_deg", "tilt_deg"}, columns, tools::csv_digits));
  }
  std::filesystem::path path() const { return folder_.path() / "recording.csv"; }

 private:
  ScratchFolder folder_;
};

}  // namespace decid::bench
