// A body model with fourteen parameters that nothing simulates: whatever needs the table alone works with it.
#pragma once

#include "sim/protocol/protocol.hpp"
#include "tests/sim/tiny_protocol.hpp"

namespace decid::test {

inline const sim::BodyModel& made_up_body() {
  static const sim::BodyModel body = [] {
    std::vector<sim::ParameterInfo> all;
    for (int i = 1; i <= 14; ++i) {
      const std::string number = std::to_string(i);
      all.push_back({.name = "gain_" + number,
                     .option = "gain-" + number,
                     .description = "Gain number " + number,
                     .unit = i % 3 == 0 ? "1" : "N m/rad",
                     .low = 10.0 * i,
                     .high = 11.0 * i + 1.0,
                     .scales_with_mgh = i % 2 == 0,
                     .min = 0.0,
                     .max = 200.0});
    }
    return sim::BodyModel{"fourteen gains", sim::ParameterTable(std::move(all))};
  }();
  sim::register_body_model(body);
  return body;
}

inline sim::Protocol made_up_protocol() {
  sim::Protocol protocol = tiny_protocol();
  protocol.experiment.body_model = &made_up_body();
  return protocol;
}

}  // namespace decid::test
