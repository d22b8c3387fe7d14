// How much a recording looks like what a model was trained on: the Mahalanobis distance of the network's last features
// (what its last layer reads) from those of simulated trials. A recording of another stimulus, start, sign or rate
// still gives seven numbers; this shows that they mean nothing. Method: Lee et al., "A simple unified framework for
// detecting out-of-distribution samples", NeurIPS 2018, for one class.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/communicator.hpp"
#include "dataset/source.hpp"
#include "nn/network.hpp"

namespace decid {

struct Model;

/// What is kept of the features of simulated trials. Empty if a model has none.
struct Familiarity {
  std::vector<float> mean;       ///< of each feature
  std::vector<float> whitening;  ///< lower triangle, row by row: times (features - mean) has variance 1 in each value
  double usual = 0.0;            ///< 97 of 100 simulated trials that were not used for it are nearer than this

  bool known() const noexcept { return !mean.empty(); }
  /// Root mean square of the whitened features of a trial: 1 is usual. features: mean.size() values. Throws
  /// Error for another number, or a whitening of another size.
  double distance(std::span<const float> features) const;
};

/// The most features that are kept: the whitening grows with their square.
inline constexpr int max_features = 512;

/// How many features of a network are kept; 0 if its last layer is not fully connected or reads too many.
int feature_count(const nn::Network<float>& network);

/// Why learn_familiarity would learn nothing: the last layer is not fully connected, reads more than max_features or
/// is the only one, or there are too few trials, eight for each feature. Empty if it would.
std::string why_no_familiarity(const Model& model, const dataset::TrialSource& source);

/// Learned from trials that the network was not trained on: the next epoch's of a stream, the validation half of a
/// data set. Empty if why_no_familiarity says why.
Familiarity learn_familiarity(const Model& model, const dataset::TrialSource& source, int next_epoch,
                              Communicator* ranks = nullptr);

}  // namespace decid
