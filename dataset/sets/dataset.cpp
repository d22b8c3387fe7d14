// Data sets in memory, their halves, and the scaling of their targets. generator.cpp makes the trials.
#include "dataset/sets/dataset.hpp"

#include <cmath>
#include <string>

#include "base/error.hpp"
#include "base/math/random.hpp"
#include "dataset/sets/generator.hpp"
#include "sim/streams.hpp"

namespace decid::dataset {

namespace {

constexpr const char* where = "data set";

}  // namespace

sim::TrialInput base_trial(const sim::ParameterTable& ranges, std::uint64_t seed, std::uint64_t attempt,
                           const sim::Heights& heights) {
  const Random random(seed, sim::streams::base_parameters, attempt);
  sim::Parameters parameters(ranges.size());
  for (std::size_t i = 0; i < ranges.size(); ++i) parameters[i] = random.uniform(i, ranges[i].low, ranges[i].high);
  const double height =
      heights.vary() ? Random(seed, sim::streams::body, attempt).uniform(0, heights.low, heights.high) : 1.0;
  return {parameters, Random(seed, sim::streams::vestibular_noise, attempt), height};
}

Dataset generate(const DatasetRequest& request, DatasetReport* report, const Progress& progress) {
  Generator generator(request);
  Dataset data;
  data.protocol = request.protocol;
  data.seed = request.seed;
  data.samples = generator.samples();
  const std::size_t values = static_cast<std::size_t>(request.count) * static_cast<std::size_t>(data.samples);
  try {
    data.sway.reserve(values);
  } catch (const std::exception&) {  // bad_alloc or length_error
    throw Error(Code::out_of_memory, where,
                std::to_string(request.count) + " trials need " + std::to_string(values * sizeof(float) / 1'000'000) +
                    " MB of memory",
                "request fewer trials");
  }
  while (!generator.done()) {
    const Chunk& chunk = generator.next();
    for (const TrialRecord& trial : chunk.trials) data.parameters.push_back(trial.parameters);
    for (const std::span<const float> sway : chunk.sway) data.sway.insert(data.sway.end(), sway.begin(), sway.end());
    if (progress && !progress(data.trials(), request.count)) {
      throw Error(Code::stopped, where,
                  "stopped after " + std::to_string(data.trials()) + " of " + std::to_string(request.count) + " trials",
                  "run it again to complete it");
    }
  }
  data.group = generator.group();
  data.split = split_by_group(data.group);
  if (report) *report = generator.report();
  return data;
}

std::vector<std::uint8_t> split_by_group(const std::vector<std::int32_t>& group) {
  std::vector<int> size(group.size(), 0);
  for (const std::int32_t index : group) {
    if (index < 0 || static_cast<std::size_t>(index) >= group.size()) {
      throw Error(Code::file_damaged, where,
                  "group " + std::to_string(index) + " is not one of the " + std::to_string(group.size()) + " trials",
                  "give the index of one of the group's trials");
    }
    ++size[static_cast<std::size_t>(index)];
  }
  long long filled[2] = {0, 0};
  std::vector<std::uint8_t> half(group.size(), 0);  // per group
  const auto place = [&](std::size_t index) {
    half[index] = filled[1] < filled[0] ? 1 : 0;
    filled[half[index]] += size[index];
  };
  // Large groups first: single trials then balance the remainder.
  for (std::size_t index = 0; index < size.size(); ++index) {
    if (size[index] > 1) place(index);
  }
  for (std::size_t index = 0; index < size.size(); ++index) {
    if (size[index] == 1) place(index);
  }
  std::vector<std::uint8_t> split;
  for (const std::int32_t index : group) split.push_back(half[static_cast<std::size_t>(index)]);
  return split;
}

std::vector<float> TargetScaling::scale(const sim::Parameters& parameters) const {
  std::vector<float> target(mean.size());
  for (std::size_t i = 0; i < target.size(); ++i) {
    target[i] = static_cast<float>((parameters[i] - mean[i]) / stddev[i]);
  }
  return target;
}

sim::Parameters TargetScaling::unscale(std::span<const float> target) const {
  if (target.size() != mean.size()) {
    throw Error(Code::size_mismatch, "targets",
                "got " + std::to_string(target.size()) + " values for " + std::to_string(mean.size()) + " parameters",
                "give one value per parameter");
  }
  sim::Parameters parameters(mean.size());
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    parameters[i] = mean[i] + static_cast<double>(target[i]) * stddev[i];
  }
  return parameters;
}

TargetScaling target_scaling(const sim::ParameterTable& table, std::span<const sim::Parameters> parameters) {
  if (parameters.empty())
    throw Error(Code::trials_missing, "targets", "has no trials for scaling", "give the training half");
  const auto count = static_cast<double>(parameters.size());
  TargetScaling scaling{sim::Parameters(table.size()), sim::Parameters(table.size())};
  for (std::size_t i = 0; i < table.size(); ++i) {
    double sum = 0.0, squares = 0.0;
    for (const sim::Parameters& p : parameters) sum += p[i];
    scaling.mean[i] = sum / count;
    for (const sim::Parameters& p : parameters) {
      const double difference = p[i] - scaling.mean[i];
      squares += difference * difference;
    }
    const double stddev = std::sqrt(squares / count);
    // A single trial, or equal values, has no spread to divide by.
    scaling.stddev[i] = stddev > 1e-12 * table[i].range() ? stddev : 1.0;
  }
  return scaling;
}

}  // namespace decid::dataset
