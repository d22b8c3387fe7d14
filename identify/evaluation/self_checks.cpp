// Computations whose bits are known: see self_checks.hpp.
#include "identify/evaluation/self_checks.hpp"

#include "base/files/sha256.hpp"
#include "identify/training/training.hpp"
#include "nn/training/loss.hpp"
#include "nn/training/schedule.hpp"
#include "nn/training/trainer.hpp"

namespace decid {
namespace {

/// Returns a number from -1 to 1 that depends only on the arguments: Chris Wellons' lowbias32.
float scattered(std::uint32_t id, std::size_t index) {
  std::uint32_t h = static_cast<std::uint32_t>(index) * 0x9e3779b9U + id * 0x85ebca6bU + 0x1234567U;
  h = (h ^ (h >> 16U)) * 0x7feb352dU;
  h = (h ^ (h >> 15U)) * 0x846ca68bU;
  h ^= h >> 16U;
  return static_cast<float>(static_cast<double>(h >> 8U) * 0x1p-23 - 1.0);
}

/// Trains a small network on three means of its images, and returns the hash of its weights.
std::string steps_hash(int batch, int steps, Communicator* group) {
  constexpr nn::Shape shape{2, 12, 12};
  nn::Network<float> network(
      shape, "conv 6 3x3 pad 1; batchnorm; relu; maxpool 2; conv 8 3x3 pad 1; batchnorm; relu; avgpool 2; fc 3");
  network.initialise(1);
  nn::Trainer<float> trainer(network, batch, group);
  const auto optimiser = nn::sgd();
  nn::OptimiserState state = nn::begin(*optimiser, network);
  const std::vector<int> own = trainer.own_samples(batch);
  const auto size = static_cast<std::size_t>(shape.size());
  std::vector<float> targets, image(size);
  const nn::Schedule schedule("cosine", 0.05, steps, 10, 3);
  std::vector<double> parts(own.size() * 3);
  for (const int sample : own)
    for (std::size_t k = 0; k < 3; ++k) targets.push_back(scattered(1, 3 * static_cast<std::size_t>(sample) + k));
  for (int step = 0; step < steps; ++step) {
    for (std::size_t n = 0; n < own.size(); ++n) {
      const std::size_t first = static_cast<std::size_t>(own[n]) * size;
      for (std::size_t i = 0; i < size; ++i) image[i] = 0.5F * scattered(2, first + i) + targets[3 * n + i % 3];
      trainer.input().load(static_cast<int>(n), image);
    }
    trainer.forward();
    nn::squared_errors<float>(trainer.output(), targets, batch, parts, trainer.output_diff());
    trainer.backward();
    nn::update(*optimiser, network, trainer.gradients(), schedule.rate(step), state);
  }
  return nn::weights_sha256(network);
}

/// Simulated trials, images, scaling, training, validation.
std::string stream_hash(Communicator* group) {
  TrainingSettings settings;
  settings.preset = preset_named("small");
  settings.preset.epochs = 2;
  settings.seed = 5;
  settings.scaling_trials = 2000;
  settings.ranks = group;
  const auto source = dataset::stream_source(sim::default_protocol(), settings.seed, 128, 32);
  settings.preset.image = image_for(settings.preset, source->protocol());
  TrainingState state = start_training(*source, settings);
  run_training(
      *source, settings, state, [](int, int) { return true; }, [] {});
  return nn::weights_sha256(state.model.network);
}

std::string trials_hash() {
  dataset::DatasetRequest request;
  request.protocol = sim::default_protocol();
  request.protocol.noise.sensor = {0.001, 0.1};
  request.count = 32;
  const dataset::Dataset data = dataset::generate(request);
  return sha256(std::string(reinterpret_cast<const char*>(data.sway.data()), data.sway.size() * sizeof(float)));
}

}  // namespace

std::vector<SelfCheck> self_checks() {
  return {{"50 steps of a small network", "531d03fff66e4df54207e485c5495f27f511e7e607a2f00674e6cf666af1f30c",
           [](Communicator* group) { return steps_hash(24, 50, group); }, true},
          {"two epochs on new trials", "ad2a40550c932b3b6e97e1655532ca8ce4b27199ec0da89dd23d9eeafd5d0ec0", stream_hash,
           true},
          {"8 steps of 269 samples", "44ea4cf23c4181316a647f4c9ffdd471b01ee069fdf1402336cc859b417e7f79",
           [](Communicator* group) { return steps_hash(269, 8, group); }, true},
          {"32 trials with measurement noise", "cbf256c0ab11916a12a5e5fbb972b7a0d218cb6b6fcde59944bc1cb319ec641b",
           [](Communicator*) { return trials_hash(); }, false}};
}

}  // namespace decid
