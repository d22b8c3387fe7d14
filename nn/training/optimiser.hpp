// Optimisers: how gradients change weights. An optimiser of your own is a class that overrides update(), memory() and
// text(); nn::fit (nn/fit.hpp) takes it as it takes the ones here.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "nn/network.hpp"

namespace decid::nn {

/// The rule of one step, value by value. It has no memory; OptimiserState holds the memory, and checkpoints save it.
class Optimiser {
 public:
  /// Values of one parameter that are updated together.
  struct Values {
    std::size_t count;
    const float* gradient;
    float* value;
    float* const* memory;  ///< memory()[k]: the k-th value that is kept for each of these; 0 before the first step
    bool decays;           ///< weight decay applies: to weights, not to biases or normalisations
    std::span<const int> shape = {};  ///< of the parameter, whose values these are, or some of them
  };

  virtual ~Optimiser() = default;
  /// Changes values and their memory. step: from 1. Several threads call it at once, each for other values, unless
  /// whole_parameters().
  virtual void update(const Values& values, double learning_rate, long long step) const = 0;
  /// Returns true if update() needs all values of a parameter, for their norm say. Then fit() calls it from its own
  /// thread, for one parameter after the other, within its team of threads: use parallel_for() of base/parallel.hpp, as
  /// OpenMP's own loops run in one thread there.
  virtual bool whole_parameters() const { return false; }
  /// Returns how many values are kept for each trained value.
  virtual int memory() const = 0;
  /// Returns the name with its settings, by which a checkpoint is compared.
  virtual std::string text() const = 0;
};

struct SgdOptions {
  double momentum = 0.9;
  double weight_decay = 1e-4;  ///< L2: added to the gradient
  bool nesterov = false;
};
/// Returns g = gradient + weight_decay w, v = momentum v + g, w = w - learning_rate v; with Nesterov's momentum
/// w = w - learning_rate (g + momentum v). As PyTorch's SGD.
std::shared_ptr<const Optimiser> sgd(const SgdOptions& options = {});

struct AdamWOptions {
  double beta1 = 0.9, beta2 = 0.999;
  double epsilon = 1e-8;
  double weight_decay = 0.01;  ///< decoupled: w shrinks by learning_rate weight_decay w
};
/// Returns AdamW. Loshchilov and Hutter, "Decoupled weight decay regularization", ICLR 2019. As PyTorch's AdamW.
std::shared_ptr<const Optimiser> adamw(const AdamWOptions& options = {});
/// Returns the optimiser of a text: "sgd", "nesterov" or "adamw", then settings of SgdOptions or AdamWOptions with
/// their numbers, as "adamw weight_decay 0.05 beta2 0.99". Throws Error for another name or setting.
std::shared_ptr<const Optimiser> optimiser_named(const std::string& text);

struct OptimiserState {
  long long steps = 0;
  std::vector<std::vector<std::vector<float>>> memory = {};  ///< [kept value][parameter][value]
};
/// Returns the state before the first step. Throws Error if memory() is below 0.
OptimiserState begin(const Optimiser& optimiser, const Network<float>& network);

/// Updates each parameter k for which gradients[k] is not empty; an empty gradient freezes a parameter.
/// Throws Error, and changes nothing, unless gradients and the state's memory have the network's sizes; the state is
/// begin()'s, or that of an earlier call.
void update(const Optimiser& optimiser, Network<float>& network, std::span<const std::span<const float>> gradients,
            double learning_rate, OptimiserState& state);

/// Scales gradients so that the norm of all together is at most `largest`, and returns the norm they had. The sum of
/// squares is in double, value after value in pieces of fixed size: the same bits for any number of threads.
double clip(std::span<const std::span<float>> gradients, double largest);

}  // namespace decid::nn
