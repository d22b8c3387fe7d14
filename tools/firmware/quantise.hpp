// A firmware's network in 8-bit integers: weights with a scale for each output, symmetric; activations with a scale and
// a zero for each map, calibrated on simulated trials; sums in 32 bits, exact. Jacob et al., "Quantization and training
// of neural networks for efficient integer-arithmetic-only inference", CVPR 2018; the step from one layer's sums to the
// next one's activations is in float here.
#pragma once

#include <span>

#include "identify/network/prediction.hpp"
#include "tools/firmware/plan.hpp"

namespace decid::tools {

/// Simulated trials that activations are calibrated on: 256, or as many as 10^10 multiply-adds allow, but at least 16.
int calibration_trials(const FirmwarePlan& plan);

/// Adds 8-bit integers to the plan, calibrated on the model's own experiment with a seed that is never trained on.
/// Throws Error for a layer whose sums may leave 32 bits.
void quantise(FirmwarePlan& plan, const Model& model);

/// The plan's network, a layer at a time, in the order of sums that the firmware has: in float, or in integers if the
/// plan has any. Returns the last layer's outputs.
std::vector<float> run_plan(const FirmwarePlan& plan, std::span<const float> image);

/// Predicts as predict() (identify/network/model.hpp) does, with this network instead of the model's.
std::vector<float> predict_planned(const FirmwarePlan& plan, const Model& model, int trials, const Sways& sways);

}  // namespace decid::tools
