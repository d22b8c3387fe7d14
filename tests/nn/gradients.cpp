// Tests that a Trainer, which fuses lines, has the bits of its network's lines one by one. operations.cpp compares
// gradients with differences of the loss.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "nn/training/loss.hpp"
#include "nn/training/trainer.hpp"
#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

// A Trainer fuses lines and shares memory among tensors: neither may change a bit.
TEST_CASE_TEMPLATE("gradients: a Trainer's are those of its network's lines one by one", T, float, double) {
  struct Case {
    Shape shape;
    const char* architecture;
  };
  const Shape square{2, 8, 8};
  const Case cases[]{
      {square, "conv 4 3x3 pad 1; batchnorm; relu; maxpool 2; conv 3 3x3 pad 1; batchnorm; relu; avgpool 2; fc 3"},
      {square, "conv 4 3x3 stride 2 pad 1; relu; batchnorm; conv 3 2x2; relu; globalavgpool; fc 3"},
      {square,
       "batchnorm; conv 3 5x5 pad 4; relu; relu; conv 2 3x3 stride 2; maxpool 2; fc 6; relu; conv 5 3x3 pad 2; fc 3"},
      {square,
       "batchnorm; maxpool 3; conv 9 3x3 pad 2; batchnorm; relu; maxpool 2 stride 1; conv 2 1x1; batchnorm; "
       "avgpool 2x1; batchnorm; relu; globalavgpool; batchnorm; batchnorm; relu; fc 3"},
      {square, "conv 4 3x3 stride 2 pad 1; batchnorm; relu; statspool; conv 3 3x3 pad 1; relu; fc 3"},
      {{1, 61, 90},
       "batchnorm; relu; conv 2 3x3 pad 1; batchnorm; relu; maxpool 2; batchnorm; relu; avgpool 7x3; fc 3"},
  };
  const Threads one_thread(1);
  for (const Case& one : cases) {
    for (const int batch : {3, 16, 19}) {
      const Shape shape = one.shape;
      const std::string architecture = one.architecture;
      CAPTURE(architecture);
      CAPTURE(batch);
      Network<T> network(shape, architecture);
      network.initialise(5);
      Trainer<T> trainer(network, batch);
      const auto samples = static_cast<std::size_t>(batch);
      const auto input = hashed_values<T>(1, samples * static_cast<std::size_t>(shape.size()));
      const auto targets = hashed_values<T>(2, samples * 3);
      load_batch(trainer.input(), input);
      trainer.forward();
      std::vector<double> parts(6), chain_parts(6);
      squared_errors<T>(trainer.output(), targets, batch, parts, trainer.output_diff());
      trainer.backward();

      Chain<T> chain(shape, architecture, batch);
      const auto parameters = network.parameters(), chain_parameters = chain.parameters();
      REQUIRE(chain_parameters.size() == parameters.size());
      for (std::size_t k = 0; k < parameters.size(); ++k) chain_parameters[k]->value = parameters[k]->value;
      load_batch(chain.input(), input);
      chain.forward();
      squared_errors<T>(chain.output(), targets, batch, chain_parts, chain.output_diff());
      CHECK(store_batch(chain.output()) == store_batch(trainer.output()));
      CHECK(chain_parts == parts);
      chain.backward();
      for (std::size_t k = 0; k < parameters.size(); ++k) {
        CAPTURE(k);
        CHECK(std::ranges::equal(chain.gradient(k), trainer.gradient(k)));
      }
      std::size_t k = 0;
      for (const Layer<T>& layer : network.layers())
        for (const RunningStatistics<T>& s : layer.statistics()) CHECK(chain.statistics()[k++]->value == s.value);
      CHECK(k == chain.statistics().size());

      const Inference<T> inference(network);
      BatchExecutor<T> executor(inference, batch);
      load_batch(executor.input(), input);
      executor.forward();
      load_batch(chain.input(), input);
      chain.infer();
      // In inference BatchNorm is folded into the convolution's weights: each is rounded once more, and so is each
      // product. Sums of at most 36 terms, two layers deep, of values of order one.
      const auto by_lines = store_batch(chain.output()), folded = store_batch(executor.output());
      const T tolerance = T(2 * 2 * (36 + 3)) * std::numeric_limits<T>::epsilon();
      for (std::size_t i = 0; i < folded.size(); ++i)
        CHECK(std::abs(by_lines[i] - folded[i]) <= tolerance * std::max(T(1), std::abs(by_lines[i])));
    }
  }
}
