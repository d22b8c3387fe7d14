// Outputs, losses and gradients of samples that are not trained on: see fit.hpp.
#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "nn/detail/samples.hpp"
#include "nn/predictor.hpp"
#include "nn/training/detail/classes.hpp"
#include "nn/training/trainer.hpp"

namespace decid::nn {
namespace {

constexpr int evaluated_at_once = 256;

/// Calls body(outputs, targets) with some of the samples at `places` after the other, in their order. epoch: of a fit,
/// which refuses values that are not finite; 0 outside of one.
template <class Body>
void for_each_part(const Network<float>& network, const Samples& samples, std::span<const int> places,
                   std::size_t width, int epoch, const Body& body) {
  const auto values = static_cast<std::size_t>(network.input_shape().size());
  const auto outputs = static_cast<std::size_t>(network.output_shape().size());
  Predictor predictor(network, evaluated_at_once);
  std::vector<float> all;
  Loaded loaded;
  for (std::size_t first = 0; first < places.size(); first += evaluated_at_once) {
    const std::size_t count = std::min<std::size_t>(evaluated_at_once, places.size() - first);
    load(samples, places.subspan(first, count), values, width, epoch, {}, loaded);
    if (epoch > 0 && samples.inputs().empty()) require_finite(loaded, places.subspan(first, count), values, width);
    all.resize(count * outputs);
    predictor.run(loaded.inputs, all);
    body(std::span<const float>(all), std::span<const float>(loaded.targets));
  }
}

}  // namespace

double mean_loss_of(const Network<float>& network, const Samples& samples, std::span<const int> places, int epoch,
                    const Loss& loss) {
  double sum = 0;
  const auto outputs = static_cast<std::size_t>(network.output_shape().size());
  loss.require(network.output_shape());
  const int width = loss.targets(network.output_shape().size());
  for_each_part(network, samples, places, static_cast<std::size_t>(width), epoch,
                [&](std::span<const float> output, std::span<const float> target) {
                  const std::vector<double> values(output.begin(), output.end()), wanted(target.begin(), target.end());
                  std::vector<double> losses(output.size() / outputs), slopes(output.size());
                  loss.batch(values, wanted, losses, slopes);
                  for (const double one : losses) sum += one;
                });
  return sum / static_cast<double>(places.size());
}

std::vector<float> predict(const Network<float>& network, std::span<const float> inputs) {
  const auto values = static_cast<std::size_t>(network.input_shape().size());
  const std::size_t count = inputs.size() / values;
  std::vector<float> outputs(count * static_cast<std::size_t>(network.output_shape().size()));
  Predictor(network, static_cast<int>(std::clamp<std::size_t>(count, 1, evaluated_at_once))).run(inputs, outputs);
  return outputs;
}

std::vector<float> input_gradient(const Network<float>& network, std::span<const float> inputs,
                                  std::span<const float> by_output) {
  const auto values = static_cast<std::size_t>(network.input_shape().size());
  const auto outputs = static_cast<std::size_t>(network.output_shape().size());
  const std::size_t count = inputs.size() / values;
  if (inputs.size() != count * values || by_output.size() != count * outputs)
    throw Error(Code::size_mismatch, "input gradient",
                format("has %zu inputs and %zu derivatives by outputs where a sample has %zu and %zu", inputs.size(),
                       by_output.size(), values, outputs),
                "give whole samples, and a derivative for each of their outputs");
  Network<float> copy = network;  // a Trainer can change its network, and others may read this one now
  // For 2 samples at least, as the constructor does not know yet that BatchNorm's statistics are frozen.
  Trainer<float> trainer(copy, static_cast<int>(std::clamp<std::size_t>(count, 2, evaluated_at_once)), nullptr, true);
  trainer.freeze_statistics();
  std::vector<float> gradient(inputs.size());
  for (std::size_t first = 0; first < count; first += evaluated_at_once) {
    const auto here = static_cast<int>(std::min<std::size_t>(evaluated_at_once, count - first));
    const auto sample_of = [&](auto all, std::size_t width, int i) {
      return all.subspan((first + static_cast<std::size_t>(i)) * width, width);
    };
    trainer.set_batch(here);
    with_team([&] {
      parallel_for(here, [&](int i) { trainer.input().load(i, sample_of(inputs, values, i)); });
      trainer.forward();
      parallel_for(here, [&](int i) { trainer.output_diff().load(i, sample_of(by_output, outputs, i)); });
      trainer.backward();
      parallel_for(here, [&](int i) { trainer.input_diff().store(i, sample_of(std::span(gradient), values, i)); });
    });
  }
  return gradient;
}

double mean_loss(const Network<float>& network, const Samples& samples, const Loss& loss) {
  return mean_loss_of(network, samples, all_of(samples), 0, loss);
}

double accuracy(const Network<float>& network, const Samples& samples) {
  require_classes(network.output_shape(), "accuracy");
  int right = 0;
  const auto classes = static_cast<std::size_t>(network.output_shape().size());
  const auto is_right = [&](std::span<const float> output, float wanted) {
    require_class(static_cast<double>(wanted), static_cast<int>(classes), [] { return "accuracy"; });
    const auto place = std::ranges::max_element(output) - output.begin();
    return is_finite(output) && static_cast<float>(place) == wanted;
  };
  for_each_part(network, samples, all_of(samples), 1, 0,
                [&](std::span<const float> outputs, std::span<const float> wanted) {
                  for (std::size_t i = 0; i < wanted.size(); ++i)
                    right += is_right(outputs.subspan(i * classes, classes), wanted[i]);
                });
  return right / static_cast<double>(samples.count());
}

}  // namespace decid::nn
