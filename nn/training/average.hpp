// An exponential moving average of a network's weights over the steps of a training, which often errs less than the
// weights of the last step. Running statistics of BatchNorm are averaged in the same way, with the same decay: they
// then describe the inputs of a layer over the steps that the averaged weights come from, and validation and inference
// read them like those of any other network.
#pragma once

#include "nn/network.hpp"

namespace decid::nn {

/// Moves `average`, a network of the same architecture, towards `network` after step `step`, from 1:
/// average = decay average + (1 - decay) value, for each weight and running statistic. The decay of the first steps is
/// smaller, (1 + step) / (10 + step), so that the weights of the beginning do not stay. The same bits for any number of
/// threads. Throws Error unless 0 < decay < 1.
void move_average(Network<float>& average, const Network<float>& network, double decay, long long step);

}  // namespace decid::nn
