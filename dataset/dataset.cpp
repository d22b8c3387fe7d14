// Generation of data sets. Attempts are simulated in parallel, a chunk at a time, and accepted in their order: which
// trials there are depends neither on threads nor on the size of the chunks.
// Source: section 2.3 of the paper, see dataset.hpp for what it leaves open.
#include "dataset/dataset.hpp"

#include <algorithm>
#include <cmath>
#include <new>
#include <stdexcept>
#include <string>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random.hpp"

namespace decid::dataset {

namespace {

constexpr const char* where = "data set";
/// Attempts simulated at once: enough to keep threads busy, 25 MB of sway at 121 s and 100 Hz.
constexpr int largest_chunk = 256;
/// So many attempts are made before a lack of valid trials is called an error.
constexpr long long patience = 10'000;
constexpr long long attempts_per_valid_trial = 1000;

double peak_to_peak(std::span<const double> sway) {
  const auto [least, most] = std::minmax_element(sway.begin(), sway.end());
  return *most - *least;
}

/// Generates one data set, base trials first.
class Generator {
 public:
  Generator(const DatasetRequest& request, const Progress& progress)
      : request_(request), progress_(progress), simulator_(request.protocol) {
    data_.protocol = request.protocol;
    data_.seed = request.seed;
    data_.samples = simulator_.samples();
    const std::size_t values = static_cast<std::size_t>(request.count) * static_cast<std::size_t>(data_.samples);
    try {
      data_.sway.reserve(values);
    } catch (const std::exception&) {  // bad_alloc or length_error
      throw Error(where,
                  std::to_string(request.count) + " trials need " + std::to_string(values * sizeof(float) / 1'000'000) +
                      " MB of memory",
                  "ask for fewer trials");
    }
  }

  Dataset run(DatasetReport& report) {
    const int base = request_.base == 0 ? request_.count : request_.base;
    report.base_attempts = accept_until(base, [&](long long attempt, std::span<double> sway) {
      const auto item = static_cast<std::uint64_t>(attempt);
      const BaseTrial trial = simulate_base_trial(simulator_, request_.seed, item, sway);
      return Attempt{trial.parameters, trial.outcome.valid, -1};
    });
    report.parents = static_cast<int>(parents_.size());
    if (base < request_.count) {
      if (parents_.empty()) {
        throw Error(where,
                    "none of the " + std::to_string(base) +
                        " base trials sways more than 0.05 rad, so none can "
                        "be the parent of more",
                    "ask for more base trials, or only for base trials");
      }
      const std::vector<std::int32_t> parents = parents_;
      report.child_attempts = accept_until(request_.count, [&](long long attempt, std::span<double> sway) {
        return simulate_child(parents, static_cast<std::uint64_t>(attempt), sway);
      });
    }
    data_.split = split_by_group(data_.group);
    return std::move(data_);
  }

 private:
  struct Attempt {
    sim::Parameters parameters;
    bool valid;
    std::int32_t parent;  ///< -1: none
  };

  Attempt simulate_child(const std::vector<std::int32_t>& parents, std::uint64_t attempt,
                         std::span<double> sway) const {
    const std::int32_t parent = parents[attempt % parents.size()];
    const Random random(request_.seed, Stream::child_parameters, attempt);
    sim::Parameters parameters = data_.parameters[static_cast<std::size_t>(parent)];
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const sim::ParameterInfo& info = sim::parameter_info[i];
      const double change = random.uniform(i, -child_change, child_change) * (info.high - info.low);
      parameters[i] = std::clamp(parameters[i] + change, info.low, info.high);
    }
    const Random noise(request_.seed, Stream::child_noise, attempt);
    return {parameters, simulator_.run(parameters, noise, sway).valid, parent};
  }

  /// Runs simulate(attempt, sway) for attempts 0, 1, ... until there are `target` trials; returns how many it took.
  template <class Simulate>
  long long accept_until(int target, const Simulate& simulate) {
    const auto samples = static_cast<std::size_t>(data_.samples);
    const int before = data_.trials();
    std::vector<Attempt> attempts;
    std::vector<double> sways;
    long long first = 0;
    for (;;) {
      const int missing = target - data_.trials();
      const int chunk = std::min(largest_chunk, missing + missing / 2 + 1);
      attempts.resize(static_cast<std::size_t>(chunk));
      sways.resize(static_cast<std::size_t>(chunk) * samples);
      const auto sway_of = [&](int i) {
        return std::span(sways).subspan(static_cast<std::size_t>(i) * samples, samples);
      };
      parallel_for(chunk, [&](int i) { attempts[static_cast<std::size_t>(i)] = simulate(first + i, sway_of(i)); });

      std::vector<int> accepted;
      for (int i = 0; i < chunk && static_cast<int>(accepted.size()) < missing; ++i) {
        ++first;
        if (attempts[static_cast<std::size_t>(i)].valid) accepted.push_back(i);
        const long long valid = data_.trials() - before + static_cast<long long>(accepted.size());
        if (first >= patience && valid * attempts_per_valid_trial < first) give_up(first, valid);
      }
      append(attempts, accepted, sway_of);
      if (progress_ && !progress_(data_.trials(), request_.count)) {
        throw Error(
            where,
            "stopped after " + std::to_string(data_.trials()) + " of " + std::to_string(request_.count) + " trials",
            "run it again to make it whole");
      }
      if (data_.trials() == target) return first;
    }
  }

  /// Parents are found on the exact sway; what is stored is that plus the sensor's noise.
  template <class SwayOf>
  void append(const std::vector<Attempt>& attempts, const std::vector<int>& accepted, const SwayOf& sway_of) {
    const auto samples = static_cast<std::size_t>(data_.samples);
    const int position = data_.trials();
    for (const int i : accepted) {
      const Attempt& attempt = attempts[static_cast<std::size_t>(i)];
      const std::int32_t own = data_.trials();
      const bool is_base = attempt.parent < 0;
      data_.parameters.push_back(attempt.parameters);
      data_.group.push_back(is_base ? own : attempt.parent);
      if (is_base && peak_to_peak(sway_of(i)) > parent_peak_to_peak_rad) parents_.push_back(own);
    }
    data_.sway.resize(data_.parameters.size() * samples);
    parallel_for(static_cast<int>(accepted.size()), [&](int k) {
      const std::span<double> sway = sway_of(accepted[static_cast<std::size_t>(k)]);
      const auto item = static_cast<std::size_t>(position + k);
      sim::add_sensor_noise(request_.protocol.sensor_noise, request_.seed, item, sway);
      std::transform(sway.begin(), sway.end(), data_.sway.begin() + static_cast<std::ptrdiff_t>(item * samples),
                     [](double value) { return static_cast<float>(value); });
    });
  }

  [[noreturn]] static void give_up(long long attempts, long long valid) {
    throw Error(
        where,
        "only " + std::to_string(valid) + " of " + std::to_string(attempts) + " simulated trials stay within 5 degrees",
        "check body, amplitude and noise of the protocol");
  }

  const DatasetRequest& request_;
  const Progress& progress_;
  sim::Simulator simulator_;
  Dataset data_;
  std::vector<std::int32_t> parents_;
};

}  // namespace

BaseTrial simulate_base_trial(const sim::Simulator& simulator, std::uint64_t seed, std::uint64_t attempt,
                              std::span<double> sway_rad) {
  const Random random(seed, Stream::base_parameters, attempt);
  sim::Parameters parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    parameters[i] = random.uniform(i, sim::parameter_info[i].low, sim::parameter_info[i].high);
  }
  return {parameters, simulator.run(parameters, Random(seed, Stream::vestibular_noise, attempt), sway_rad)};
}

Dataset generate(const DatasetRequest& request, DatasetReport* report, const Progress& progress) {
  if (request.count < 1) {
    throw Error(where, std::to_string(request.count) + " trials are asked for", "ask for at least 1");
  }
  if (request.base < 0 || request.base > request.count) {
    throw Error(where,
                std::to_string(request.base) + " base trials of " + std::to_string(request.count) + " trials in all",
                "choose the number of base trials between 1 and that of all trials, or 0 for all");
  }
  DatasetReport unused;
  return Generator(request, progress).run(report ? *report : unused);
}

std::vector<std::uint8_t> split_by_group(const std::vector<std::int32_t>& group) {
  std::vector<int> size(group.size(), 0);
  for (const std::int32_t index : group) {
    if (index < 0 || static_cast<std::size_t>(index) >= group.size()) {
      throw Error(where, "group " + std::to_string(index) + " of " + std::to_string(group.size()) + " trials",
                  "a group is named by the index of one of its trials");
    }
    ++size[static_cast<std::size_t>(index)];
  }
  long long filled[2] = {0, 0};
  std::vector<std::uint8_t> half(group.size(), 0);  // of each group
  const auto place = [&](std::size_t index) {
    half[index] = filled[1] < filled[0] ? 1 : 0;
    filled[half[index]] += size[index];
  };
  // The large pieces first: single trials then level what those left uneven.
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

std::array<float, sim::parameter_count> TargetScaling::scale(const sim::Parameters& parameters) const {
  std::array<float, sim::parameter_count> target{};
  for (std::size_t i = 0; i < target.size(); ++i) {
    target[i] = static_cast<float>((parameters[i] - mean[i]) / deviation[i]);
  }
  return target;
}

sim::Parameters TargetScaling::unscale(std::span<const float> target) const {
  if (target.size() != sim::parameter_count) {
    throw Error("targets", std::to_string(target.size()) + " values for 7 parameters", "give one value a parameter");
  }
  sim::Parameters parameters{};
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    parameters[i] = mean[i] + static_cast<double>(target[i]) * deviation[i];
  }
  return parameters;
}

TargetScaling target_scaling(std::span<const sim::Parameters> parameters) {
  if (parameters.empty()) throw Error("targets", "no trials to scale by", "choose the training half");
  const auto count = static_cast<double>(parameters.size());
  TargetScaling scaling;
  for (std::size_t i = 0; i < sim::parameter_count; ++i) {
    double sum = 0.0, squares = 0.0;
    for (const sim::Parameters& p : parameters) sum += p[i];
    scaling.mean[i] = sum / count;
    for (const sim::Parameters& p : parameters) {
      const double difference = p[i] - scaling.mean[i];
      squares += difference * difference;
    }
    const double deviation = std::sqrt(squares / count);
    // One trial, or the same value in all, has no spread to divide by.
    const sim::ParameterInfo& info = sim::parameter_info[i];
    scaling.deviation[i] = deviation > 1e-12 * (info.high - info.low) ? deviation : 1.0;
  }
  return scaling;
}

}  // namespace decid::dataset
