// Recordings in files on their way: read and brought to a protocol, identified, explained. One that cannot be
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
  std::string trial;  ///< empty: the file is the recording

  template <class Path>
  requires std::convertible_to<Path, std::filesystem::path> RecordingSource(const Path& whole, std::string part = {})
      : file(whole), trial(std::move(part)) {}
  /// "long.csv", "long.csv#2"
  std::string name() const { return trial.empty() ? file.string() : file.string() + "#" + trial; }
};

/// The recordings of files: each file is one, or as many as options.trial_column tells apart. A file that cannot be
/// read is one, whose error read_recordings() has. Throws Error for standard input, which can be read only once.
std::vector<RecordingSource> sources_of(const std::vector<std::filesystem::path>& files,
                                        const recording::RecordingOptions& options);

/// How recordings are to be read.
struct ReadOptions {
  recording::RecordingOptions recording;
  recording::TrialOptions trial;
  std::optional<sim::Parameters> truth;  ///< known parameters, to be shown beside
  std::optional<sim::Body> body = {};    ///< of the subject; empty: the protocol's is assumed
};

/// Returns a recording as a trial of the protocol, with what was assumed as its warnings. Throws Error for one that
/// cannot be used.
RecordingResult bring(recording::Recording recording, const recording::ProtocolPlan& plan,
                      const recording::TrialOptions& options);

/// Reads each source and brings it to the protocol. A source that cannot be used has an error.
std::vector<RecordingResult> read_recordings(const sim::Protocol& protocol, const std::vector<RecordingSource>& sources,
                                             const ReadOptions& options);

/// Returns what recordings that an identifier identifies have in common, without any.
Report report_of(const Identifier& identifier);

/// Reads, identifies and explains recordings; `name`: what errors call the model. Throws Error for a body that it does
/// not know (for_body.hpp).
Report identify_files(const Model& model, const std::string& name, const std::vector<RecordingSource>& sources,
                      const ReadOptions& options);

}  // namespace decid
