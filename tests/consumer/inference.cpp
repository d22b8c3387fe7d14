// Uses what an instrument would, the components image and nn alone: a trial is simulated, drawn as an image and put
// through a small network. The program checks what it prints: a network that sums its inputs must give the image's sum.
#include <cmath>
#include <cstdio>
#include <decid/dataset/image/image.hpp>
#include <decid/nn/predictor.hpp>
#include <decid/sim/simulate.hpp>
#include <decid/sim/streams.hpp>
#include <vector>

int main() {
  namespace sim = decid::sim;
  const sim::Simulator simulator(sim::default_protocol());
  std::vector<double> sway_rad(static_cast<std::size_t>(simulator.samples()));
  const decid::Random noise(1, decid::sim::streams::vestibular_noise, 0);
  const sim::Outcome outcome = simulator.run(sim::single_pendulum().parameters.middle(), noise, sway_rad);

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
  std::vector<float> outputs(1);
  decid::nn::Predictor(network, 1).run(image, outputs);

  double sum = 0.0;
  for (const float value : image) sum += value;
  const double output = static_cast<double>(outputs.front());
  std::printf("samples %d, valid %d, largest sway %.4f rad, image sum %.6f, network %.6f\n", simulator.samples(),
              outcome.valid, outcome.max_sway_rad, sum, output);
  // Each of n float additions of positive terms errs by at most half an ulp of the sum.
  const double tolerance = sum * static_cast<double>(image.size()) * 6e-8;
  return outcome.valid && outcome.max_sway_rad > 1e-3 && std::abs(output - sum) <= tolerance ? 0 : 1;
}
