// Out-of-distribution (OOD) detection by the distance of a recording from a model's training: the Mahalanobis distance
// of the network's last features (the inputs of its last layer) from the features of simulated trials. A recording of
// another stimulus, start, sign or rate still gives seven numbers; the distance shows that they mean nothing. Method:
// Lee et al., "A simple unified framework for detecting out-of-distribution samples", NeurIPS 2018, for one class.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "base/communicator.hpp"
#include "dataset/source.hpp"
#include "nn/network.hpp"

namespace decid {

struct Model;

/// Mean and whitening of the features of simulated trials. Empty if a model has none. Model files call it familiarity.
struct OodDetector {
  std::vector<float> mean;       ///< of each feature
  std::vector<float> whitening;  ///< lower triangle, row by row: times (features - mean) has variance 1 in each value
  double usual = 0.0;            ///< 97 of 100 simulated trials that were not used for it are nearer than this

  bool known() const noexcept { return !mean.empty(); }
  /// Returns the root mean square of the whitened features of a trial: 1 is usual. features: mean.size() values. Throws
  /// Error for another number, or a whitening of another size.
  double distance(std::span<const float> features) const;
};

/// Maximum number of features: the whitening grows with their square.
inline constexpr int max_features = 512;

/// Returns the number of features of a network; 0 if its last layer is not fully connected or reads too many.
int feature_count(const nn::Network<float>& network);

/// Returns the reason why learn_ood_detector would return nothing, or an empty text. Reasons: the last layer is not
/// fully connected, reads more than max_features or is the only one, or there are fewer than eight trials for each
/// feature.
std::string why_no_ood_detector(const Model& model, const dataset::TrialSource& source);

/// Learns mean, whitening and usual distance from trials that the network was not trained on: the next epoch of a
/// stream, or the validation half of a data set. Empty if why_no_ood_detector says why.
OodDetector learn_ood_detector(const Model& model, const dataset::TrialSource& source, int next_epoch,
                               Communicator* ranks = nullptr);

}  // namespace decid
