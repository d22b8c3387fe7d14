// Samples as training and evaluation read them. Not installed.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "nn/detail/finite.hpp"
#include "nn/fit.hpp"

namespace decid::nn {

/// Samples, one after the other.
struct Loaded {
  std::vector<float> inputs, targets;
};

/// Loads the samples at `places` into `loaded`, whose memory stays from call to call: a step's would go back to the
/// system each time. values, width: of an input and of a target; random: the numbers of a sample, or none.
void load(const Samples& samples, std::span<const int> places, std::size_t values, std::size_t width, int epoch,
          const std::function<Random(int)>& random, Loaded& loaded);

/// Throws Error, naming the first one, if a sample in memory is not finite.
void require_finite(const Samples& samples);
/// Throws Error, naming the first one, if a loaded sample is not finite. A relu may hide a NaN from the loss.
void require_finite(const Loaded& loaded, std::span<const int> places, std::size_t values, std::size_t width);

/// Throws Error, naming the first one, if a sample in memory has a target that the loss does not take.
void require_targets(const Samples& samples, const Loss& loss, int outputs);

/// Returns the places of all samples.
std::vector<int> all_of(const Samples& samples);
/// Returns the SHA-256 of samples in memory. Samples of a function have none.
std::string content_of(const Samples& samples);

/// Returns the mean loss of the samples at `places`. epoch: of a fit, which refuses values that are not finite; 0
/// outside of one.
double mean_loss_of(const Network<float>& network, const Samples& samples, std::span<const int> places, int epoch,
                    const Loss& loss);

}  // namespace decid::nn
