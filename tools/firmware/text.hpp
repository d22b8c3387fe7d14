// A firmware's files: tools/firmware/runtime/ with the tables that a plan fills in.
#pragma once

#include <string>
#include <vector>

#include "identify/network/for_body.hpp"
#include "tools/firmware/plan.hpp"

namespace decid::tools {

struct FirmwareFiles {
  std::string header, source;
};

/// Input and expected results of the self-test, computed by this program.
struct TestVector {
  std::vector<float> outputs;     ///< of the network
  std::vector<float> parameters;  ///< in their units
  std::vector<float> stddevs;     ///< theirs, if the model gives a distribution
  double distance = 0.0;          ///< of the features over what is usual, if it was asked for
};

/// The sway that the self-test identifies: test_sample in tools/firmware/runtime/state.c.
std::vector<float> test_sway(int samples);

/// Returns the size of the out-of-distribution score's tables; 0 if the model is exported without it.
long long ood_score_bytes(const Model& model, const FirmwarePlan& plan);
/// Returns the files for recordings of `body`. `name` begins every public name. `origin`: text about the model, for
/// people.
FirmwareFiles firmware_files(const Model& model, const ForBody& body, const FirmwarePlan& plan, const TestVector& test,
                             const std::string& name, const std::string& origin);
/// Returns the files of plan_network()'s plan: a network alone, without what makes images. NAME_run(input, outputs,
/// arena) has the bits of nn::Predictor.
FirmwareFiles network_files(const nn::Network<float>& network, const FirmwarePlan& plan, const std::string& name,
                            const std::string& origin);

}  // namespace decid::tools
