// Trials for training: see trials.hpp.
#include "tools/trials.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/sha256.hpp"

namespace decid::tools {
namespace {

class DatasetSource final : public TrialSource {
 public:
  explicit DatasetSource(dataset::StoredDataset stored) : stored_(std::move(stored)) {
    for (int i = 0; i < stored_.trials(); ++i)
      (about().split[static_cast<std::size_t>(i)] == 0 ? training_ : validation_).push_back(i);
    if (training_.empty() || validation_.empty())
      throw Error("data set", "has no trial in its training or its validation half", "make one with at least 2 trials");
  }

  const sim::Protocol& protocol() const override { return about().protocol; }
  std::string identity() const override {
    Sha256 hash;
    hash.update(about().parameters.data(), about().parameters.size() * sizeof(sim::Parameters));
    hash.update(about().split.data(), about().split.size());
    std::vector<float> sway(static_cast<std::size_t>(about().samples));
    std::size_t left = std::size_t{1} << 20;  // values of sway: no need to read all
    for (int i = 0; i < stored_.trials() && left > 0; ++i) {
      stored_.read(i, sway);
      const std::size_t taken = std::min(left, sway.size());
      hash.update(sway.data(), taken * sizeof(float));
      left -= taken;
    }
    return "data set " + hash.hex();
  }
  int training_trials() const override { return static_cast<int>(training_.size()); }
  int validation_trials() const override { return static_cast<int>(validation_.size()); }
  sim::Parameters training_trial(int, int index, std::span<float> sway_rad) const override {
    return read(training_[static_cast<std::size_t>(index)], sway_rad);
  }
  sim::Parameters validation_trial(int index, std::span<float> sway_rad) const override {
    return read(validation_[static_cast<std::size_t>(index)], sway_rad);
  }

 private:
  const dataset::Dataset& about() const { return stored_.about(); }
  sim::Parameters read(int trial, std::span<float> sway_rad) const {
    stored_.read(trial, sway_rad);
    return about().parameters[static_cast<std::size_t>(trial)];
  }

  dataset::StoredDataset stored_;
  std::vector<int> training_, validation_;
};

class StreamSource final : public TrialSource {
 public:
  StreamSource(sim::Protocol protocol, std::uint64_t seed, int trials_per_epoch, int validation)
      : simulator_(std::move(protocol)), seed_(seed), training_(trials_per_epoch), validation_(validation) {}

  const sim::Protocol& protocol() const override { return simulator_.protocol(); }
  std::string identity() const override { return "simulated for each epoch from seed " + std::to_string(seed_); }
  int training_trials() const override { return training_; }
  int validation_trials() const override { return validation_; }
  sim::Parameters training_trial(int epoch, int index, std::span<float> sway_rad) const override {
    return simulate(static_cast<std::uint64_t>(validation_) +
                        static_cast<std::uint64_t>(epoch) * static_cast<std::uint64_t>(training_) +
                        static_cast<std::uint64_t>(index),
                    sway_rad);
  }
  sim::Parameters validation_trial(int index, std::span<float> sway_rad) const override {
    return simulate(static_cast<std::uint64_t>(index), sway_rad);
  }

 private:
  static constexpr std::uint64_t attempts = 1024;

  sim::Parameters simulate(std::uint64_t number, std::span<float> sway_rad) const {
    thread_local std::vector<double> sway;
    sway.resize(sway_rad.size());
    for (std::uint64_t attempt = number * attempts; attempt < (number + 1) * attempts; ++attempt) {
      const dataset::BaseTrial trial = dataset::simulate_base_trial(simulator_, seed_, attempt, sway);
      if (!trial.outcome.valid) continue;
      sim::add_sensor_noise(protocol().sensor_noise, seed_, number, sway);
      std::ranges::transform(sway, sway_rad.begin(), [](double value) { return static_cast<float>(value); });
      return trial.parameters;
    }
    throw Error("protocol '" + protocol().name + "'", "lets no body stand: 1024 attempts in a row fell over",
                "reduce the tilt's amplitude");
  }

  sim::Simulator simulator_;
  std::uint64_t seed_;
  int training_, validation_;
};

}  // namespace

std::unique_ptr<TrialSource> dataset_source(dataset::StoredDataset data) {
  return std::make_unique<DatasetSource>(std::move(data));
}

std::unique_ptr<TrialSource> stream_source(sim::Protocol protocol, std::uint64_t seed, int trials_per_epoch,
                                           int validation_trials) {
  return std::make_unique<StreamSource>(std::move(protocol), seed, trials_per_epoch, validation_trials);
}

}  // namespace decid::tools
