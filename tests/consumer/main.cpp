// Uses the installed libraries together: a trial is simulated, drawn as an image and put through a small network;
// another one is trained on fresh trials as they are made. The program checks what it prints: a network that sums its
// inputs must give the image's sum, and training must help.
#include <cmath>
#include <cstdio>
#include <vector>

#include "base/random.hpp"
#include "dataset/feed.hpp"
#include "nn/loss.hpp"
#include "nn/predictor.hpp"
#include "nn/trainer.hpp"
#include "sim/simulate.hpp"

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
  std::vector<double> errors;
  for (int epoch = 0; epoch < epochs; ++epoch) {
    double sum = 0.0;
    for (int done = 0; done < trials; done += batch) {
      const dataset::Feed::Batch next = feed.next();
      trainer.set_batch(next.trials);
      for (int i = 0; i < next.trials; ++i)
        trainer.input().load(i, next.images.subspan(static_cast<std::size_t>(i) * values, values));
      trainer.forward();
      double squares[7];
      decid::nn::mean_squared_error(trainer.output(), next.targets, squares, trainer.output_diff());
      trainer.backward();
      trainer.step(0.02, {});
      for (const double square : squares) sum += square;
    }
    errors.push_back(sum / (7.0 * trials));
  }
  return errors;
}

}  // namespace

int main() {
  namespace sim = decid::sim;
  const sim::Simulator simulator(sim::default_protocol());
  std::vector<double> sway_rad(static_cast<std::size_t>(simulator.samples()));
  const decid::Random noise(1, decid::Stream::vestibular_noise, 0);
  const sim::Outcome outcome = simulator.run(sim::middle_parameters(), noise, sway_rad);

  decid::dataset::ImageSettings settings;
  settings.channels = {decid::dataset::Channel::modulus};
  const decid::dataset::ImageMaker maker(settings, simulator.samples());
  const decid::dataset::ImageShape shape = maker.shape();
  std::vector<float> image(static_cast<std::size_t>(shape.size()));
  maker.make(std::vector<float>(sway_rad.begin(), sway_rad.end()), image);

  decid::nn::Network<float> network({shape.channels, shape.rows, shape.columns}, "fc 1");
  for (decid::nn::Parameter<float>* parameter : network.parameters()) {
    for (float& value : parameter->value) value = parameter->name == "weight" ? 1.0F : 0.0F;
  }
  std::vector<float> output(1);
  decid::nn::Predictor(network, 1).run(image, output);

  double sum = 0.0;
  for (const float value : image) sum += value;
  std::printf("samples %d, valid %d, largest sway %.4f rad, image sum %.6f, network %.6f\n", simulator.samples(),
              outcome.valid, outcome.largest_sway_rad, sum, static_cast<double>(output[0]));
  // Each of n float additions of positive terms errs by at most half an ulp of the sum.
  const double tolerance = sum * static_cast<double>(image.size()) * 6e-8;
  const std::vector<double> errors = train_on_stream(100, 25, 3);
  std::printf("mean squared error of three epochs on fresh trials: %.3f %.3f %.3f\n", errors[0], errors[1], errors[2]);
  if (!(errors[2] < errors[0])) return 1;
  return outcome.valid && outcome.largest_sway_rad > 1e-3 && std::abs(static_cast<double>(output[0]) - sum) <= tolerance
             ? 0
             : 1;
}
