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

/// One recording, identified.
struct Identification {
  std::string file;
  std::optional<Error> error;            ///< why the recording could not be used; if set, nothing below is
  std::string column, tilt_column;       ///< the columns that were read; tilt_column may be empty
  std::optional<sim::Parameters> truth;  ///< when known (a simulated recording)
  Estimate estimate;
  Explanation explanation;

  double peak_to_peak_deg() const;
  /// The estimate's and the explanation's, the gravest first, else in that order.
  Warnings warnings() const;
  Trust trust() const { return trust_of(warnings()); }
};

/// The recordings of one call, and what they have in common.
struct Identifications {
  sim::Protocol protocol;       ///< with the subject's body, or the one that is assumed
  std::vector<float> tilt_rad;  ///< the platform at the trials' samples
  dataset::ImageSettings image;
  dataset::ImageShape image_shape{};  ///< of Estimate::image, where that is not empty
  std::vector<Identification> recordings;
  bool body_assumed = true;  ///< nobody said whose body it is
};

/// Each source as a trial of the protocol: everything of an Identification that needs no parameters. Estimate::warnings
/// says what was assumed.
std::vector<Identification> read_recordings(const sim::Protocol& protocol, const std::vector<RecordingSource>& sources,
                                            const ReadOptions& options);

/// Reads, identifies and explains recordings; `name`: what errors call the model. Throws Error for a body that it does
/// not know (for_body.hpp). done: told how many recordings are done, every few of them.
Identifications identify_files(const Model& model, const std::string& name, const std::vector<RecordingSource>& sources,
                               const ReadOptions& options, const std::function<void(std::size_t count)>& done = {});

}  // namespace decid
