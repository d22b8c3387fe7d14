// Data sets of simulated trials: sampling of the parameters, validity, enrichment with larger sways, split in halves.
// Source: section 2.3 of the paper. It describes its enrichment only as "a relatively small modification (about 10% of
// the range)". Here a child's parameters are its parent's plus a uniform change of up to 10% of each range, clamped.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "dataset/sets/distribution.hpp"
#include "sim/parameters.hpp"
#include "sim/simulate.hpp"

namespace decid::dataset {

/// Trials with peak-to-peak sway above this are parents of the enrichment.
inline constexpr double parent_peak_to_peak_rad = 0.05;
/// A child's largest change of a parameter, as a fraction of its range.
inline constexpr double child_change = 0.1;

struct Dataset {
  sim::Protocol protocol;
  std::uint64_t seed = 0;
  int samples = 0;                          ///< of each trial
  std::vector<float> sway;                  ///< trials x samples, rad
  std::vector<sim::Parameters> parameters;  ///< one set per trial, SI units, in the order of protocol.parameters()
  std::vector<std::int32_t> group;          ///< index of the trial's parent; a base trial's own index
  std::vector<std::uint8_t> split;          ///< 0 training, 1 validation; a group is never divided

  int trials() const { return static_cast<int>(parameters.size()); }
  std::span<const float> trial(int index) const {
    return std::span(sway).subspan(static_cast<std::size_t>(index) * static_cast<std::size_t>(samples),
                                   static_cast<std::size_t>(samples));
  }
};

struct DatasetRequest {
  sim::Protocol protocol;
  int count = 0;  ///< valid trials in total
  int base = 0;   ///< number of trials from the uniform distributions; the rest are children. 0: all
  std::uint64_t seed = 0;
};

/// The number of valid attempts, and the distributions of their trials.
struct DatasetReport {
  long long base_attempts = 0, child_attempts = 0;
  int parents = 0;
  TrialDistributions base, all;  ///< before and after enrichment
};

/// Receives the number of finished trials at times, from one thread; returns false to stop (generate throws Error).
using Progress = std::function<bool(int done, int total)>;

/// Returns the input of attempt `attempt` of the base trials. Each parameter is uniform over its range, and so is the
/// body's height.
sim::TrialInput base_trial(const sim::ParameterTable& ranges, std::uint64_t seed, std::uint64_t attempt,
                           const sim::Heights& heights = {});

/// Generates the data set in memory (npz.hpp: generate_npz, directly into a file); the bits depend only on the request.
/// Trials are recorded (sim::record) as their attempt, children's with bit 63 set. Throws Error if base > count, count
/// < 1, or the protocol has body_heights. Throws Error if children are requested without a possible parent, if memory
/// is insufficient, or if fewer than 1 in 1000 of 10,000 attempts are valid.
Dataset generate(const DatasetRequest& request, DatasetReport* report = nullptr, const Progress& progress = {});

/// Splits groups into halves. group[i] is the index of a trial (0 .. trials - 1), otherwise Error; trials of equal
/// group belong together. Sizes differ by at most one if the groups allow. Groups of several trials come first, in
/// order of their index, each to the smaller half (the training half if they are equal), then single trials.
std::vector<std::uint8_t> split_by_group(const std::vector<std::int32_t>& group);

/// Mean and standard deviation (over N) of each parameter over some trials; z-scored targets have mean 0 and standard
/// deviation 1. The standard deviation is 1 where all values are equal.
struct TargetScaling {
  sim::Parameters mean, stddev;

  std::vector<float> scale(const sim::Parameters& parameters) const;
  sim::Parameters unscale(std::span<const float> target) const;
};
/// Computes the scaling. `parameters`: those of the training half. Throws Error if there are none.
TargetScaling target_scaling(const sim::ParameterTable& table, std::span<const sim::Parameters> parameters);

}  // namespace decid::dataset
