// The page of a training, rewritten each epoch: its errors over the epochs, on the trials it learns from and on others.
#pragma once

#include <string>
#include <vector>

#include "identify/network/origin.hpp"
#include "identify/result.hpp"
#include "identify/training/log.hpp"
#include "sim/protocol/protocol.hpp"

namespace decid::tools {

struct TrainingFigures {
  std::string model;    ///< the file
  std::string version;  ///< decid's
  sim::Protocol protocol;
  Origin origin;
  std::vector<EpochLog> log;  ///< of the epochs done, one at least
  /// The network is trained by the density that it gives the truth: other units than the MSE.
  bool distribution = false;
  bool finished = false;
  Call call = {};
};

/// Returns the self-contained page. The same training gives the same page.
std::string training_html(const TrainingFigures& figures);

}  // namespace decid::tools
