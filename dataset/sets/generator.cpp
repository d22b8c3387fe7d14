// Generates data sets. Attempts are simulated in parallel, a chunk at a time, and accepted in order. The accepted
// trials depend neither on threads nor on the size of the chunks. Source: section 2.3 of the paper; dataset.hpp lists
// the choices that it leaves open.
#include "dataset/sets/generator.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/math/random.hpp"
#include "sim/streams.hpp"

namespace decid::dataset {
namespace {

constexpr const char* generation = "data set";
/// Attempts simulated at once: enough to keep lanes and threads busy, 50 MB of sway at 121 s and 100 Hz.
constexpr std::size_t max_attempts = 1024, min_attempts = 16;
constexpr std::size_t max_bytes = std::size_t{1} << 26;
/// The number of attempts before a lack of valid trials is an error.
constexpr long long patience = 10'000;
constexpr long long attempts_per_valid_trial = 1000;
/// Measurement noise of children: base trials and children count their attempts from 0 each.
constexpr std::uint64_t child_sensor_noise = std::uint64_t{1} << 63;

DatasetRequest checked(DatasetRequest request) {
  if (request.count < 1) {
    throw Error(Code::setting_out_of_range, generation, std::to_string(request.count) + " trials are requested",
                "request at least 1");
  }
  if (request.base < 0 || request.base > request.count) {
    throw Error(
        Code::setting_out_of_range, generation,
        std::to_string(request.base) + " base trials of " + std::to_string(request.count) + " trials are requested",
        "request from 1 to all trials as base trials, or 0 for all");
  }
  if (request.protocol.heights.vary())
    throw Error(Code::setting_conflict, generation, "the protocol has body_heights, and a data set has one body",
                "leave out body_heights, or train on a stream, which draws heights");
  return request;
}

/// Eight chains of comparisons: a single chain would wait for its last result at every step.
double peak_to_peak(std::span<const double> sway) {
  std::array<double, 8> low, high;
  low.fill(sway.front());
  high.fill(sway.front());
  std::size_t k = 0;
  for (; k + 8 <= sway.size(); k += 8) {
    for (std::size_t lane = 0; lane < 8; ++lane) {
      low[lane] = sway[k + lane] < low[lane] ? sway[k + lane] : low[lane];
      high[lane] = sway[k + lane] > high[lane] ? sway[k + lane] : high[lane];
    }
  }
  for (; k < sway.size(); ++k) {
    low[0] = std::min(low[0], sway[k]);
    high[0] = std::max(high[0], sway[k]);
  }
  return *std::ranges::max_element(high) - *std::ranges::min_element(low);
}

}  // namespace

Generator::Generator(DatasetRequest request, Communicator* ranks)
    : request_(checked(std::move(request))),
      ranks_(ranks),
      base_(request_.base == 0 ? request_.count : request_.base),
      ranges_(request_.protocol.ranges()),
      simulator_(request_.protocol) {
  report_.base = report_.all = TrialDistributions(ranges_);
  const std::size_t trial_bytes = static_cast<std::size_t>(samples()) * sizeof(float);
  max_chunk_ = static_cast<int>(std::clamp(max_bytes / trial_bytes, min_attempts, max_attempts));
  if (ranks_ != nullptr) max_chunk_ *= ranks_->size();
}

int Generator::attempts_worth_making(int missing) const {
  // Slightly more than the rate so far requires: a second, small chunk would leave lanes empty.
  const double attempts = static_cast<double>(attempts_made());
  const double valid = making_children() ? trials() - base_ : trials();
  const double rate = valid > 0.0 ? valid / attempts : 0.8;
  const double wanted = 1.05 * missing / rate + 8.0;
  return wanted < max_chunk_ ? static_cast<int>(wanted) : max_chunk_;
}

std::int32_t Generator::find_parent(long long attempt) const {
  return parents_[static_cast<std::size_t>(attempt) % parents_.size()];
}

sim::TrialInput Generator::trial_input(long long attempt) const {
  const auto item = static_cast<std::uint64_t>(attempt);
  if (!making_children()) return base_trial(ranges_, request_.seed, item);
  const Random random(request_.seed, sim::streams::child_parameters, item);
  sim::Parameters parameters = parents_parameters_[item % parents_.size()];
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const sim::ParameterInfo& info = ranges_[i];
    const double change = random.uniform(i, -child_change, child_change) * info.range();
    parameters[i] = std::clamp(parameters[i] + change, info.low, info.high);
  }
  return {parameters, Random(request_.seed, sim::streams::child_noise, item)};
}

/// Parents are chosen by the noise-free sway; the recorded sway is stored.
Generator::Result Generator::finish(long long attempt, std::span<double> sway_rad, std::span<float> stored) const {
  const double width = peak_to_peak(sway_rad);
  const std::uint64_t item = static_cast<std::uint64_t>(attempt) | (making_children() ? child_sensor_noise : 0);
  sim::record(request_.protocol, request_.seed, item, sway_rad);
  std::ranges::transform(sway_rad, stored.begin(), [](double value) { return static_cast<float>(value); });
  return {true, width};
}

/// Whole groups that share lanes.
RankRange Generator::own_attempts(int attempts, int rank) const {
  const auto count = static_cast<std::size_t>(attempts);
  if (ranks_ == nullptr) return {0, count};
  const RankRange groups = rank_range((count + min_attempts - 1) / min_attempts, rank, ranks_->size());
  return {std::min(groups.first * min_attempts, count), std::min(groups.last * min_attempts, count)};
}

/// Sends each rank's own results to all.
void Generator::gather(std::vector<Result>& results) const {
  const int attempts = static_cast<int>(results.size());
  std::vector<std::size_t> sizes;
  for (int rank = 0; rank < ranks_->size(); ++rank)
    sizes.push_back(own_attempts(attempts, rank).count() * sizeof(Result));
  const RankRange own = own_attempts(attempts, ranks_->rank());
  const std::vector<Result> sent(results.begin() + static_cast<std::ptrdiff_t>(own.first),
                                 results.begin() + static_cast<std::ptrdiff_t>(own.last));
  ranks_->all_gather(std::as_bytes(std::span(sent)), sizes, std::as_writable_bytes(std::span(results)));
}

std::vector<Generator::Result> Generator::simulate(int attempts, const RankRange& own, std::vector<float>& sway) const {
  const long long first = attempts_made();
  const auto width = static_cast<std::size_t>(samples());
  if (sway.size() < own.count() * width) sway.resize(own.count() * width);
  std::vector<Result> results(static_cast<std::size_t>(attempts));
  const auto own_first = static_cast<long long>(own.first);
  simulator_.run_all(
      static_cast<int>(own.count()), [&](int i) { return trial_input(first + own_first + i); },
      [&](int i, const sim::Outcome& outcome, std::span<double> sway_rad) {
        if (!outcome.valid) return;
        const auto place = static_cast<std::size_t>(i);
        results[own.first + place] =
            finish(first + own_first + i, sway_rad, std::span(sway).subspan(place * width, width));
      });
  if (ranks_ != nullptr) gather(results);
  return results;
}

const Chunk& Generator::next() {
  const bool children = making_children();
  if (children && parents_.empty()) {
    throw Error(
        Code::trials_missing, generation,
        "none of the " + std::to_string(base_) + " base trials sways more than 0.05 rad, so none can be a parent",
        "request more base trials, or only base trials");
  }
  const int missing = (children ? request_.count : base_) - trials();
  const int attempts = attempts_worth_making(missing);
  const long long first = attempts_made();
  auto& [sway, chunk] = buffers_[second_];
  second_ = !second_;
  const RankRange own = own_attempts(attempts, ranks_ != nullptr ? ranks_->rank() : 0);
  const std::vector<Result> results = simulate(attempts, own, sway);

  const auto width = static_cast<std::size_t>(samples());
  chunk.trials.clear();
  chunk.sway.clear();
  chunk.trials_by_rank.assign(ranks_ != nullptr ? static_cast<std::size_t>(ranks_->size()) : 0, 0);
  int rank = 0;  // of the attempt
  const int before = trials();
  const long long valid_before = before - (children ? base_ : 0);
  long long made = first;
  for (int i = 0; i < attempts && static_cast<int>(chunk.trials.size()) < missing; ++i) {
    ++made;
    const auto attempt = static_cast<std::size_t>(i);
    while (ranks_ != nullptr && attempt >= own_attempts(attempts, rank).last) ++rank;
    if (const Result& result = results[attempt]; result.valid) {
      const std::int32_t number = before + static_cast<std::int32_t>(chunk.trials.size());
      chunk.trials.push_back(
          {trial_input(first + i).parameters, result.peak_to_peak_rad, children ? find_parent(first + i) : number});
      if (attempt >= own.first && attempt < own.last)
        chunk.sway.emplace_back(std::span(sway).subspan((attempt - own.first) * width, width));
      if (ranks_ != nullptr) ++chunk.trials_by_rank[static_cast<std::size_t>(rank)];
    }
    const long long valid = valid_before + static_cast<long long>(chunk.trials.size());
    if (made >= patience && valid * attempts_per_valid_trial < made) {
      throw Error(
          Code::body_falls, generation,
          "only " + std::to_string(valid) + " of " + std::to_string(made) + " simulated trials stay within 5 degrees",
          "check body, amplitude and noise of the protocol");
    }
  }
  (children ? report_.child_attempts : report_.base_attempts) = made;
  chunk.base_attempts = report_.base_attempts;
  chunk.child_attempts = report_.child_attempts;
  for (const TrialRecord& trial : chunk.trials) accept(trial);
  return chunk;
}

void Generator::restore(const Chunk& chunk) {
  report_.base_attempts = chunk.base_attempts;
  report_.child_attempts = chunk.child_attempts;
  for (const TrialRecord& trial : chunk.trials) accept(trial);
}

void Generator::accept(const TrialRecord& trial) {
  if (!making_children()) {
    report_.base.add(trial.parameters, trial.peak_to_peak_rad);
    if (trial.peak_to_peak_rad > parent_peak_to_peak_rad) {
      parents_.push_back(trials());
      parents_parameters_.push_back(trial.parameters);
      ++report_.parents;
    }
  }
  report_.all.add(trial.parameters, trial.peak_to_peak_rad);
  group_.push_back(trial.group);
}

}  // namespace decid::dataset
