// Trials for training: see source.hpp.
#include "dataset/source.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/files/sha256.hpp"
#include "base/per_thread.hpp"

namespace decid::dataset {
namespace {

void check_indices(std::span<const int> indices, int trials) {
  for (const int index : indices) {
    if (index < 0 || index >= trials)
      throw Error(Code::setting_out_of_range, "trials", "trial " + std::to_string(index) + " does not exist",
                  "request 0 to " + std::to_string(trials - 1));
  }
}

class StoredSource final : public TrialSource {
 public:
  explicit StoredSource(StoredDataset stored) : stored_(std::move(stored)) {
    for (int i = 0; i < stored_.trials(); ++i)
      (about().split[static_cast<std::size_t>(i)] == 0 ? training_ : validation_).push_back(i);
    if (training_.empty() || validation_.empty())
      throw Error(Code::trials_missing, "data set", "has no trial in its training or its validation half",
                  "make a data set with at least 2 trials");
  }

  const sim::Protocol& protocol() const override { return about().protocol; }
  TrialIdentity identity() const override { return trial_identity(stored_); }
  int trials(Part part) const override { return static_cast<int>(half(part).size()); }
  int trials_at_once() const override { return 64; }
  void take(Part part, int, std::span<const int> indices, const Take& take) const override {
    check_indices(indices, trials(part));
    std::vector<int> trials;
    for (const int index : indices) trials.push_back(half(part)[static_cast<std::size_t>(index)]);
    stored_.take(trials, [&](std::size_t place, std::span<const float> sway) {
      take(place, about().parameters[static_cast<std::size_t>(trials[place])], sway);
    });
  }

 private:
  const Dataset& about() const { return stored_.about(); }
  const std::vector<int>& half(Part part) const { return part == Part::training ? training_ : validation_; }

  StoredDataset stored_;
  std::vector<int> training_, validation_;
};

class StreamSource final : public TrialSource {
 public:
  StreamSource(sim::Protocol protocol, std::uint64_t seed, int trials_per_epoch, int validation)
      : simulator_(std::move(protocol)), seed_(seed), training_(trials_per_epoch), validation_(validation) {
    if (training_ < 1 || validation_ < 1)
      throw Error(Code::setting_out_of_range, "stream",
                  std::to_string(training_) + " training and " + std::to_string(validation_) +
                      " validation trials are requested",
                  "request 1 or more of each");
  }

  const sim::Protocol& protocol() const override { return simulator_.protocol(); }
  TrialIdentity identity() const override { return {TrialIdentity::Kind::stream, seed_, {}}; }
  int trials(Part part) const override { return part == Part::validation ? validation_ : training_; }
  int trials_at_once() const override { return 512; }
  void take(Part part, int epoch, std::span<const int> indices, const Take& take) const override {
    check_indices(indices, trials(part));
    std::uint64_t first = 0;
    if (part != Part::validation)
      first = static_cast<std::uint64_t>(validation_) +
              static_cast<std::uint64_t>(epoch) * static_cast<std::uint64_t>(training_);
    std::vector<std::uint64_t> numbers;
    for (const int index : indices) numbers.push_back(first + static_cast<std::uint64_t>(index));
    simulate_stream(
        simulator_, seed_, numbers, [&](std::size_t place, const sim::TrialInput& trial, std::span<double> sway) {
          struct Scratch {
            std::vector<float> sway;
          };
          std::vector<float>& stored = per_thread<Scratch>().sway;
          sim::record(protocol(), seed_, numbers[place], sway);
          stored.resize(sway.size());
          std::ranges::transform(sway, stored.begin(), [](double value) { return static_cast<float>(value); });
          take(place, trial.parameters, {stored, trial.height});
        });
  }

 private:
  sim::Simulator simulator_;
  std::uint64_t seed_;
  int training_, validation_;
};

}  // namespace

TrialIdentity trial_identity(const StoredDataset& data) {
  const Dataset& about = data.about();
  Sha256 hash;
  for (const sim::Parameters& parameters : about.parameters)
    hash.update(parameters.begin(), parameters.size() * sizeof(double));
  hash.update(about.split.data(), about.split.size());
  std::vector<float> sway(static_cast<std::size_t>(about.samples));
  std::size_t left = std::size_t{1} << 20;  // a sample of the sway values suffices
  for (int i = 0; i < data.trials() && left > 0; ++i) {
    data.read(i, sway);
    const std::size_t taken = std::min(left, sway.size());
    hash.update(sway.data(), taken * sizeof(float));
    left -= taken;
  }
  return {TrialIdentity::Kind::stored, about.seed, hash.hex()};
}

void simulate_stream(const sim::Simulator& simulator, std::uint64_t seed, std::span<const std::uint64_t> numbers,
                     const TakeExact& take) {
  constexpr int attempts = 1024;
  const sim::ParameterTable ranges = simulator.protocol().ranges();
  simulator.run_until_valid(
      static_cast<int>(numbers.size()), attempts,
      [&](int i, int attempt) {
        return base_trial(ranges, seed,
                          numbers[static_cast<std::size_t>(i)] * attempts + static_cast<std::uint64_t>(attempt),
                          simulator.protocol().heights);
      },
      [&](int i, const sim::TrialInput& trial, std::span<double> sway) {
        take(static_cast<std::size_t>(i), trial, sway);
      });
}

std::unique_ptr<TrialSource> stored_source(StoredDataset data) {
  return std::make_unique<StoredSource>(std::move(data));
}

std::unique_ptr<TrialSource> stream_source(sim::Protocol protocol, std::uint64_t seed, int trials_per_epoch,
                                           int validation_trials) {
  return std::make_unique<StreamSource>(std::move(protocol), seed, trials_per_epoch, validation_trials);
}

}  // namespace decid::dataset
