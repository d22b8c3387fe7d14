// Sequences: a network of dilated 1-D convolutions learns to remove noise from signals that are made as they are
// needed, with decid::nn alone. Returns 0 if it removes four fifths of the noise's variance.
#include <cmath>
#include <cstdio>

#include "nn/fit.hpp"

namespace {

namespace nn = decid::nn;
constexpr int length = 128;

/// Sample `number`: a sum of two sines of random period and phase; the target has no noise.
void make(int number, const decid::Random*, std::span<float> input, std::span<float> target) {
  const decid::Random random(1, decid::Stream::user, static_cast<std::uint64_t>(number));
  for (std::size_t k = 0; k < length; ++k) {
    double value = 0;
    for (const std::uint64_t sine : {std::uint64_t{0}, std::uint64_t{2}})
      value += std::sin(6.283 * (static_cast<double>(k) / random.uniform(sine, 16, 64) + random.uniform(sine + 1)));
    target[k] = static_cast<float>(value);
    input[k] = static_cast<float>(value + 0.5 * random.normal(k + 8));
  }
}

}  // namespace

int main() {
  // Channels, then time along the rows: each residual block sees twice as far as the one before it.
  nn::Network net({1, length, 1},
                  "conv 16 5x1 pad 2x0; relu\n"
                  "residual { conv 16 5x1 pad 2x0; batchnorm; relu; conv 16 1x1 }\n"
                  "residual { conv 16 5x1 pad 4x0 dilation 2x1; batchnorm; relu; conv 16 1x1 }\n"
                  "residual { conv 16 5x1 pad 8x0 dilation 4x1; batchnorm; relu; conv 16 1x1 }\n"
                  "residual { conv 16 5x1 pad 16x0 dilation 8x1; batchnorm; relu; conv 16 1x1 }\n"
                  "conv 1 1x1  # as long as the input");
  nn::FitOptions options{.epochs = 8, .batch = 32, .learning_rate = 5e-3, .average = 0.99};
  options.after_epoch = [](const nn::FitEpoch& e) {
    std::printf("epoch %d  training loss %.4f  validation loss %.4f\n", e.epoch, e.training_loss, e.validation_loss);
  };
  nn::fit(net, {2000, make}, options);
  // The next 200 sequences, which it has not seen.
  const nn::Samples fresh(200, [](int number, const decid::Random*, std::span<float> input, std::span<float> target) {
    make(2000 + number, nullptr, input, target);
  });
  const double left = nn::mean_loss(net, fresh, *nn::squared_error()) / 0.25;
  std::printf("%.1f%% of the noise's variance is left\n", 100 * left);
  return left <= 0.2 ? 0 : 1;
}
