// Tests of nn/training/optimiser.hpp: figures of PyTorch and by hand, sizes, texts with settings, clipping.
#include "nn/training/optimiser.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

// Figures of PyTorch 1.13 in double, SGD(nesterov=True) and AdamW, for gradients 0.5, -1.25 and 2,
// learning rate 0.1, weight decay 0.01: three steps in float err by a few epsilon.
TEST_CASE("optimisers: figures of PyTorch") {
  const auto run = [](const Optimiser& optimiser) {
    Network<float> network({1, 1, 1}, "fc 1");
    for (Parameter<float>* p : network.parameters()) p->value = {1};
    OptimiserState state = begin(optimiser, network);
    for (const float gradient : {0.5F, -1.25F, 2.0F}) {
      const std::vector<std::span<const float>> gradients(2, std::span<const float>(&gradient, 1));
      update(optimiser, network, gradients, 0.1, state);
    }
    return std::pair(network.parameters()[0]->value[0], network.parameters()[1]->value[0]);  // decays, does not
  };
  const auto near = [](float value, double expected) { return std::abs(static_cast<double>(value) - expected) < 5e-7; };
  const auto [decayed, free] = run(*sgd({.weight_decay = 0.01, .nesterov = true}));
  CHECK(near(decayed, 0.7788282081910001));
  CHECK(near(free, 0.7868));
  const auto [adam_decayed, adam] = run(*adamw());
  CHECK(near(adam_decayed, 0.9074583425891263));
  CHECK(near(adam, 0.9102996651190383));
}

TEST_CASE("update: a state and gradients of other sizes than the network's are refused, and change nothing") {
  Network<float> network({1, 1, 1}, "fc 2");
  const std::vector<float> two{1, 1}, three{1, 1, 1};
  using Gradients = std::vector<std::span<const float>>;
  using Memory = std::vector<std::vector<float>>;
  for (const Memory& other : {Memory{}, {{1, 2}}, {{1, 2}, {3}}, {{1, 2}, {3, 4}, {5}}}) {
    OptimiserState state{3, {other}};
    check_error([&] { update(*sgd(), network, Gradients{two, two}, 0.5, state); }, decid::Code::size_mismatch);
    CHECK(state.steps == 3);
  }
  OptimiserState none, of_sgd = begin(*sgd(), network);
  check_error([&] { update(*sgd(), network, Gradients{two, two}, 0.5, none); }, decid::Code::size_mismatch);
  check_error([&] { update(*adamw(), network, Gradients{two, two}, 0.5, of_sgd); }, decid::Code::size_mismatch);
  for (const Gradients& other : {Gradients{}, {two}, {two, three}, {two, two, two}})
    check_error([&] { update(*sgd(), network, other, 0.5, of_sgd); }, decid::Code::size_mismatch);
  update(*sgd(), network, Gradients{two, {}}, 0.5, of_sgd);  // the second is frozen
  CHECK(of_sgd.steps == 1);
}

TEST_CASE("optimisers: by a text with settings") {
  CHECK(optimiser_named("adamw")->text() == adamw()->text());
  CHECK(optimiser_named("adamw weight_decay 0.5 beta2 0.75 beta1 0.25 epsilon 1e-3")->text() ==
        adamw({.beta1 = 0.25, .beta2 = 0.75, .epsilon = 1e-3, .weight_decay = 0.5})->text());
  CHECK(optimiser_named("nesterov momentum 0.5")->text() == sgd({.momentum = 0.5, .nesterov = true})->text());
  CHECK(optimiser_named("sgd weight_decay 0.125")->text() == sgd({.weight_decay = 0.125})->text());
  for (const char* wrong : {"sgd beta1 0.5", "adamw momentum 0.9", "sgd momentum", "sgd momentum x", "adamw 0.9",
                            "sgd momentum 0.8 momentum 0.1"})
    check_error([&] { optimiser_named(wrong); }, decid::Code::setting_malformed);
  for (const char* wrong : {"sgd momentum 2", "adamw epsilon 0"})
    check_error([&] { optimiser_named(wrong); }, decid::Code::setting_out_of_range);
  for (const char* wrong : {"lion", ""}) check_error([&] { optimiser_named(wrong); }, decid::Code::setting_unknown);
}

TEST_CASE("clip: scales to the norm, and only down") {
  std::vector<float> a(9000, 3.0F), b{4};
  const std::vector<std::span<float>> gradients{a, {}, b};
  const double norm = clip(gradients, 1e6);
  CHECK(norm == std::sqrt(81016.0));
  CHECK(a[8999] == 3.0F);
  CHECK(clip(gradients, 1.0) == norm);
  CHECK(std::abs(clip(gradients, 2.0) - 1.0) < 1e-6);
}
