// The report of `decid dataset` on its set: the paper's table and its histogram of amplitudes, as JSON and as a page
// like the page of `decid identify`.
#pragma once

#include <cstdint>
#include <string>

#include "base/files/json.hpp"
#include "dataset/sets/dataset.hpp"
#include "identify/result.hpp"

namespace decid::tools {

struct DatasetFigures {
  std::string file;
  std::string version;  ///< decid's
  dataset::DatasetRequest request;
  dataset::DatasetReport report;
  std::uint64_t bytes = 0;  ///< of the file
  std::string sha256;       ///< of the file
  Call call = {};
};

/// Keys: add_call()'s, then file, bytes, sha256, trials, base_trials, children, samples, seed, protocol, base_attempts,
/// acceptance_rate, parents, parent_threshold_rad, child_attempts, child_acceptance_rate (null without children), and
/// distributions: for Kp, .., delay and peak_to_peak (rad) unit, low and high of the histogram, and for base and
/// enriched the mean, sd (over N), min, max and the counts of the equal bins from low to high. Without children both
/// are the same.
Json dataset_json(const DatasetFigures& figures);

/// Returns the self-contained page. The same data set gives the same page.
std::string dataset_html(const DatasetFigures& figures);

}  // namespace decid::tools
