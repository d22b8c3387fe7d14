// Protocols and simulation in C.
#include <limits>

#include "bindings/c/handles.hpp"
#include "recording/protocol_file.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "sim/streams.hpp"

using namespace decid::c;

decid_protocol::decid_protocol(decid::sim::Protocol of)
    : simulator(std::move(of)),
      ranges(protocol().ranges()),
      json(decid::sim::to_json(protocol())),
      tilt_rad(decid::sim::tilt_at_samples(protocol().experiment, simulator.stimulus())) {
  for (const decid::sim::ParameterInfo& info : ranges)
    parameters.push_back({info.name.c_str(), info.unit.c_str(), info.description.c_str(), info.low, info.high,
                          info.scales_with_mgh ? 1 : 0});
}

namespace {

/// Trials of a call as the simulator takes them.
decid::sim::TrialInput trial_input(const double* parameters, std::size_t count, std::size_t trial, std::uint64_t seed) {
  decid::sim::TrialInput input{decid::sim::Parameters(count),
                               decid::Random(seed + trial, decid::sim::streams::vestibular_noise, 0)};
  for (std::size_t p = 0; p < count; ++p) input.parameters[p] = parameters[trial * count + p];
  return input;
}

void simulate(const decid_protocol& given_protocol, const double* parameters, std::size_t trials, std::uint64_t seed,
              double* sway_rad, unsigned char* valid) {
  const decid::sim::Simulator& simulator = given_protocol.simulator;
  const auto samples = static_cast<std::size_t>(simulator.samples());
  const std::size_t count = given_protocol.ranges.size();
  if (trials > std::size_t{1} << 30)
    throw decid::Error(decid::Code::setting_out_of_range, "decid_simulate", "too many trials",
                       "give a thousand at a time");
  std::vector<double> rows(trials * samples);  // so that an error changes nothing
  std::vector<double> end_s(trials, -1.0);     // of those that fall
  simulator.run_all(
      static_cast<int>(trials),
      [&](int index) { return trial_input(parameters, count, static_cast<std::size_t>(index), seed); },
      [&](int index, const decid::sim::Outcome& outcome, std::span<double> sway) {
        const auto trial = static_cast<std::size_t>(index);
        double* const row = rows.data() + trial * samples;
        if (outcome.valid) {
          decid::sim::record(simulator.protocol(), seed + trial, 0, sway);
          std::copy(sway.begin(), sway.end(), row);
          return;
        }
        end_s[trial] = outcome.end_s;
        const std::size_t standing = std::min(samples, outcome.samples(simulator.protocol().experiment.sample_rate_hz));
        std::copy_n(sway.begin(), standing, row);
        std::fill(row + standing, row + samples, std::numeric_limits<double>::quiet_NaN());
      });
  for (std::size_t trial = 0; trial < trials; ++trial) {
    if (valid == nullptr && end_s[trial] >= 0.0)
      throw decid::Error(
          decid::Code::body_falls, "decid_simulate",
          decid::format("the body of trial %zu leans by more than 5 degrees after %.2f s", trial, end_s[trial]),
          "raise Kp or Kd, lower Nv, the delay or the tilt, or take `valid`, which says which trials "
          "stand");
    if (valid != nullptr) valid[trial] = end_s[trial] < 0.0 ? 1 : 0;
  }
  std::ranges::copy(rows, sway_rad);
}

decid_status load(const char* name_or_path, const char* controller, decid_protocol** protocol, const char* where) {
  return made(protocol, where, [&] {
    const std::string name = &given(name_or_path, where, "name_or_path");
    return std::make_unique<decid_protocol>(
        decid::recording::load_protocol(name, nullptr, nullptr, text_or_empty(controller)));
  });
}

}  // namespace

decid_status decid_protocol_load(const char* name_or_path, decid_protocol** protocol) {
  return load(name_or_path, nullptr, protocol, "decid_protocol_load");
}
decid_status decid_protocol_load_controller(const char* name_or_path, const char* controller,
                                            decid_protocol** protocol) {
  return load(name_or_path, controller, protocol, "decid_protocol_load_controller");
}
const char* decid_protocol_controller(const decid_protocol* protocol) {
  return protocol == nullptr ? nullptr : protocol->protocol().experiment.body_model->name.c_str();
}
size_t decid_controllers(void) {
  return decid::sim::body_models().size();
}
const char* decid_controller_name(size_t index) {
  const auto all = decid::sim::body_models();
  return index < all.size() ? all[index]->name.c_str() : nullptr;
}
const char* decid_controller_description(size_t index) {
  const auto all = decid::sim::body_models();
  return index < all.size() ? all[index]->description.c_str() : nullptr;
}
void decid_protocol_free(decid_protocol* protocol) {
  delete protocol;
}
size_t decid_protocol_samples(const decid_protocol* protocol) {
  return protocol == nullptr ? 0 : protocol->tilt_rad.size();
}
double decid_protocol_rate_hz(const decid_protocol* protocol) {
  return protocol == nullptr ? 0.0 : protocol->protocol().experiment.sample_rate_hz;
}
const char* decid_protocol_json(const decid_protocol* protocol) {
  return protocol == nullptr ? nullptr : protocol->json.c_str();
}
const double* decid_protocol_tilt(const decid_protocol* protocol) {
  return protocol == nullptr ? nullptr : protocol->tilt_rad.data();
}
size_t decid_protocol_parameters(const decid_protocol* protocol) {
  return protocol == nullptr ? 0 : protocol->parameters.size();
}
const decid_parameter_info* decid_protocol_parameter(const decid_protocol* protocol, size_t index) {
  return protocol == nullptr ? nullptr : at(protocol->parameters, index);
}

decid_status decid_simulate(const decid_protocol* protocol, const double* parameters, size_t trials, uint64_t seed,
                            double* sway_rad, unsigned char* valid) {
  return guarded([&] {
    constexpr const char* where = "decid_simulate";
    simulate(given(protocol, where, "protocol"), &given(parameters, where, "parameters"), trials, seed,
             &given(sway_rad, where, "sway_rad"), valid);
  });
}
