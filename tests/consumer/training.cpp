// Trains a small network on new trials as they are made, with the installed libraries; training must help. Includes
// are written as decid's own are.
#include <cstdio>
#include <vector>

#include "dataset/feed.hpp"
#include "nn/training/loss.hpp"
#include "nn/training/optimiser.hpp"
#include "nn/training/trainer.hpp"

namespace {

/// A small network trained on trials that are simulated as it goes: the mean squared error of each epoch.
std::vector<double> train_on_stream(int trials, int batch, int epochs) {
  namespace dataset = decid::dataset;
  const auto source = dataset::stream_source(decid::sim::short_protocol(), 1, trials, 1);
  const dataset::ImageMaker images({.window = 110, .half_spectrum = true, .rows = 16}, source->protocol().samples());
  const dataset::Scaling scaling = dataset::measure_scaling(*source, images, trials);
  dataset::Feed feed(*source, {images, scaling.rows}, scaling.targets, batch, 1, 0, epochs);

  const dataset::ImageShape shape = images.shape();
  const auto values = static_cast<std::size_t>(shape.size());
  decid::nn::Network<float> network({shape.channels, shape.rows, shape.columns},
                                    "conv 8 3x3 pad 1; batchnorm; relu; globalavgpool; fc 7");
  network.initialise(1);
  decid::nn::Trainer<float> trainer(network, batch);
  const auto loss = decid::nn::squared_error();
  const auto optimiser = decid::nn::sgd();
  decid::nn::OptimiserState state = decid::nn::begin(*optimiser, network);
  std::vector<double> errors;
  for (int epoch = 0; epoch < epochs; ++epoch) {
    double sum = 0.0;
    for (int done = 0; done < trials; done += batch) {
      const dataset::Feed::Batch next = feed.next();
      trainer.set_batch(next.trials);
      for (int i = 0; i < next.trials; ++i)
        trainer.input().load(i, next.images.subspan(static_cast<std::size_t>(i) * values, values));
      trainer.forward();
      sum += decid::nn::total_loss(*loss, trainer.output(), next.targets, trainer.output_diff());
      trainer.backward();
      decid::nn::update(*optimiser, network, trainer.gradients(), 0.02, state);
    }
    errors.push_back(sum / trials);
  }
  return errors;
}

}  // namespace

int main() {
  const std::vector<double> errors = train_on_stream(100, 25, 3);
  std::printf("mean squared error of three epochs on new trials: %.3f %.3f %.3f\n", errors[0], errors[1], errors[2]);
  return errors[2] < errors[0] ? 0 : 1;
}
