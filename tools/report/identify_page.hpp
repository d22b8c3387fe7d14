// The report of `decid identify --report`: one self-contained HTML page that opens offline.
#pragma once

#include <string>
#include <vector>

#include "base/files/json_object.hpp"
#include "identify/recordings.hpp"

namespace decid::tools {

struct ReportModel {
  std::string name;                       ///< "built-in" or the model file
  std::string sha256;                     ///< of its weights
  std::string version;                    ///< decid's
  std::vector<std::string> options = {};  ///< that were given
  bool recalibrated = false;
};

/// The page; groups: as groups_json() has them, or null. Every string from outside (file names, warnings) is escaped.
/// Deterministic: no dates, no random ids.
std::string report_html(const ReportModel& model, const Identifications& all, const Json& groups = nullptr);

/// In parts, for recordings that several processes have identified: what the page shows of one, and the page of them.
/// all: what they have in common; failed: the errors of those that could not be used.
Json report_recording(const Identification& recording, const Identifications& all);
std::string report_html(const ReportModel& model, const Identifications& all, std::vector<Json> recordings,
                        const std::vector<std::string>& failed, const Json& groups);

}  // namespace decid::tools
