// A network alone as C: its layers by the runtime of exported models, without what makes images.
#pragma once

#include <string>

#include "nn/network.hpp"
#include "tools/firmware/plan.hpp"
#include "tools/firmware/text.hpp"

namespace decid::tools {

/// The files of plan_network()'s plan. NAME_run(input, outputs, arena) has the bits of nn::Predictor.
FirmwareFiles network_files(const nn::Network<float>& network, const FirmwarePlan& plan, const std::string& name,
                            const std::string& origin);

}  // namespace decid::tools
