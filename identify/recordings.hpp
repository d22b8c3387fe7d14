// Recordings in files: reads them, brings them to a protocol, identifies and explains them. A recording that cannot be
// used does not stop the others.
#pragma once

#include <concepts>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "identify/identify.hpp"

namespace decid {

/// A recording's file and, where a file holds several (RecordingOptions::trial_column), which of them.
struct RecordingSource {
  std::filesystem::path file;
  std::string trial;       ///< empty: the file is the recording
  std::string label = {};  ///< of a file with several recordings by a study's sheet: the section, column or begin

  template <class Path>
  requires std::convertible_to<Path, std::filesystem::path> RecordingSource(const Path& whole, std::string part = {})
      : file(whole), trial(std::move(part)) {}
  /// "long.csv", "long.csv#2", "book.xlsx#Trial 1"
  std::string name() const {
    return file.string() + (trial.empty() ? "" : "#" + trial) + (label.empty() ? "" : "#" + label);
  }
};

/// Returns the recordings of files: each file is one, or as many as options.trial_column separates. A file that cannot
/// be read counts as one, and read_recordings() gives its error. Throws Error for standard input, which can be read
/// only once.
std::vector<RecordingSource> make_sources(const std::vector<std::filesystem::path>& files,
                                          const recording::RecordingOptions& options);

/// Settings for reading recordings.
struct ReadOptions {
  recording::RecordingOptions recording;
  recording::TrialOptions trial;
  std::optional<sim::Parameters> truth;  ///< known parameters, shown for comparison
  std::optional<sim::Body> body = {};    ///< of the subject; empty: the protocol's is assumed
};

/// Returns a recording as a trial of the protocol, with warnings for all assumptions, and of an implausible body. body:
/// the subject's, if it is known. Throws Error if the recording cannot be used.
RecordingResult bring(recording::Recording recording, const recording::ProtocolPlan& plan,
                      const recording::TrialOptions& options, const std::optional<sim::Body>& body = {});

/// Reads a source and brings it to the plan's protocol. A source that cannot be used has an error.
RecordingResult read_source(const recording::ProtocolPlan& plan, const RecordingSource& source,
                            const ReadOptions& options);

/// Reads each source and brings it to the protocol. A source that cannot be used has an error.
std::vector<RecordingResult> read_recordings(const sim::Protocol& protocol, const std::vector<RecordingSource>& sources,
                                             const ReadOptions& options);

/// Returns a report without recordings, with the common values of an identifier's recordings.
Report make_report(const Identifier& identifier);

}  // namespace decid
