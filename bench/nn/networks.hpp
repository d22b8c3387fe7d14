// The networks that are timed, one training step of each, and the multiplications and additions in it. NetA is small,
// NetB is the paper's preset, Best the default preset, Series that of time series (identify/training/presets.cpp),
// Digits that of examples/classifier.cpp; peers/training.py has A and B too.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "nn/training/loss.hpp"
#include "nn/training/optimiser.hpp"
#include "nn/training/trainer.hpp"

namespace decid::bench {

struct NamedNetwork {
  const char* name;
  nn::Shape input;
  const char* architecture;
};

inline constexpr NamedNetwork best_network{
    "Best",
    {4, 256, 1},
    "conv 48 7x1 stride 2x1 pad 3x0; batchnorm; relu; conv 64 5x1 stride 2x1 pad 2x0; batchnorm; relu; conv 96 3x1 "
    "stride 2x1 pad 1x0; batchnorm; relu; fc 256; batchnorm; relu; fc 7"};

inline constexpr NamedNetwork series_network{
    "Series",
    {9, 605, 1},
    "conv 48 15x1 stride 2x1 pad 7x0; batchnorm; relu; conv 64 9x1 stride 2x1 pad 4x0; batchnorm; relu; conv 96 7x1 "
    "stride 2x1 pad 3x0; batchnorm; relu; conv 128 7x1 stride 2x1 pad 3x0; batchnorm; relu; conv 128 5x1 stride 2x1 "
    "pad "
    "2x0; batchnorm; relu; statspool; fc 256; batchnorm; relu; fc 72"};

inline constexpr NamedNetwork named_networks[] = {
    {"NetA",
     {2, 110, 110},
     "conv 8 3x3 pad 1; batchnorm; relu; avgpool 2; conv 16 3x3 pad 1; batchnorm; relu; avgpool 2; conv 32 3x3 pad 1; "
     "batchnorm; relu; conv 32 3x3 pad 1; batchnorm; relu; fc 7"},
    {"NetB",
     {2, 110, 110},
     "conv 64 3x3 pad 1; batchnorm; relu; maxpool 2; conv 64 3x3 pad 1; batchnorm; relu; maxpool 2; conv 128 3x3 pad "
     "1; batchnorm; relu; maxpool 2; conv 128 3x3 pad 1; batchnorm; relu; globalavgpool; fc 7"},
    best_network,
    series_network,
    {"Digits",
     {1, 28, 28},
     "conv 16 3x3 pad 1; batchnorm; relu; maxpool 2; conv 32 3x3 pad 1; batchnorm; relu; maxpool 2; conv 64 3x3 pad 1; "
     "batchnorm; relu; maxpool 2; fc 10"},
};

/// A layer of multiply-adds: the others' work is not counted, as it is bound by memory.
inline bool multiplies(const nn::Layer<float>& layer) {
  for (const nn::Parameter<float>& p : layer.parameters())
    if (p.name == "weight") return true;
  return false;
}

/// Returns the operations of the forward pass of one sample.
inline double forward_flops(const nn::Network<float>& network) {
  double sum = 0;
  for (const nn::Layer<float>& layer : network.layers())
    if (multiplies(layer)) sum += static_cast<double>(layer.flops());
  return sum;
}

/// Forward and both gradients, without that by the network's input, which is not computed.
inline double training_flops(const nn::Network<float>& network) {
  return 3 * forward_flops(network) - static_cast<double>(network.layers().front().flops());
}

/// Some numbers away from zero and from subnormals.
inline std::vector<float> some_values(std::size_t count) {
  std::vector<float> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<float>(i * 7919 % 1000) * 0.002F - 0.9F;
  return values;
}

inline void load_some(const nn::TensorView<float>& tensor) {
  const std::vector<float> values = some_values(static_cast<std::size_t>(tensor.shape().size()));
  for (int n = 0; n < tensor.batch(); ++n) tensor.load(n, values);
}

inline nn::Network<float> initialised(const NamedNetwork& named) {
  nn::Network<float> network(named.input, named.architecture);
  network.initialise(1);
  return network;
}

/// A network in training, with a batch to train on.
class Training {
 public:
  Training(const NamedNetwork& named, int batch) : network(initialised(named)), trainer(network, batch) {
    const auto outputs = static_cast<std::size_t>(network.output_shape().size());
    targets_ = some_values(static_cast<std::size_t>(batch) * outputs);
    parts_.resize(nn::TensorView<float>::count_blocks(batch) * outputs);
    load_some(trainer.input());
  }
  /// As nn::run() calls a step (nn/training/loop.hpp).
  void step() {
    with_team([this] {
      trainer.forward();
      nn::squared_errors(trainer.output(), targets_, trainer.output().batch(), parts_, trainer.output_diff());
      trainer.backward();
      nn::update(*optimiser_, network, trainer.gradients(), 1e-3, state_);
    });
  }

  nn::Network<float> network;
  nn::Trainer<float> trainer;

 private:
  std::vector<float> targets_;
  std::vector<double> parts_;
  std::shared_ptr<const nn::Optimiser> optimiser_ = nn::sgd();
  nn::OptimiserState state_ = nn::begin(*optimiser_, network);
};

}  // namespace decid::bench
