// Models, trials and shell commands that the tests of exported firmware share.
#pragma once

#include <doctest/doctest.h>

#include <bit>
#include <cstring>

#include "base/files/file.hpp"
#include "identify/network/for_body.hpp"
#include "identify/network/model.hpp"
#include "identify/network/prediction.hpp"
#include "tests/tools/decid/run.hpp"

namespace decid::test {

inline const std::string warnings = " -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror ";
inline const std::string c99 = std::string(DECID_C_COMPILER) + " -std=c99 -O2 ";

inline const std::string firmware_model = DECID_SOURCE_DIR "/models/firmware.safetensors";

/// A model with weights and scalings as they may come, not trained: bits do not care.
inline Model made_up_model(const sim::Protocol& protocol, const dataset::ImageSettings& image,
                           const std::string& architecture, const Head& head = point_head()) {
  Model model(protocol, image, architecture, head);
  model.network.initialise(11);
  const dataset::ImageShape shape = model.images().shape();
  const auto vary = [](std::size_t i) { return 0.25F * static_cast<float>(i % 7) - 0.5F; };
  for (nn::Parameter<float>* p : model.network.parameters())
    if (p->name == "bias" || p->name == "beta")
      for (std::size_t i = 0; i < p->value.size(); ++i) p->value[i] = vary(i);
  for (nn::Layer<float>& layer : model.network.layers())
    for (nn::RunningStatistics<float>& s : layer.statistics())
      for (std::size_t i = 0; i < s.value.size(); ++i)
        s.value[i] = s.never_negative ? 0.3F + vary(i + 2) + 0.5F : vary(i);
  for (int i = 0; image.standardize_rows && i < shape.channels * shape.rows; ++i) {
    model.rows.mean.push_back(vary(static_cast<std::size_t>(i)));
    model.rows.stddev.push_back(1.0F + vary(static_cast<std::size_t>(i)));
  }
  for (std::size_t i = 0; i < sim::single_pendulum().parameters.size(); ++i) {
    model.targets.mean[i] = sim::single_pendulum().parameters[i].middle();
    model.targets.stddev[i] = 0.3 * sim::single_pendulum().parameters[i].high;
  }
  return model;
}

/// Valid trials of the model's experiment with 0.02 degrees of sensor noise.
inline dataset::Dataset noisy_trials(const Model& model, int count, std::uint64_t seed) {
  sim::Protocol protocol = model.protocol.ideal();
  protocol.noise.sensor = {.low_deg = 0.02, .high_deg = 0.02};
  return dataset::generate({.protocol = protocol, .count = count, .seed = seed});
}

inline std::string as_bytes(std::span<const float> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

/// Returns the estimates of these outputs as bytes: seven floats, and their sd if the model predicts it.
inline std::string said_bytes(const Model& model, const ForBody& body, std::span<const float> outputs) {
  std::vector<float> all;
  for (const double value : body.from_model(model, model.decode(outputs))) all.push_back(static_cast<float>(value));
  if (const auto found = model.distribution(outputs, body.ranges))
    for (int p = 0; p < static_cast<int>(found->parameters()); ++p) all.push_back(static_cast<float>(found->stddev(p)));
  return as_bytes(all);
}

/// Returns identify's estimates of the trials for this body, as bytes.
inline std::string identified_bytes(const Model& model, const ForBody& body, const dataset::Dataset& data) {
  std::string all;
  for (int i = 0; i < data.trials(); ++i) {  // one by one, as decid identify does
    const auto sways = sways_in_memory([&](int) { return data.trial(i); }, body.height);
    all += said_bytes(model, body, predict(model, 1, 1, sways));
  }
  return all;
}

/// A command of the shell: its exit code; if that is not 0, prints what it printed.
inline int shell(const std::string& command) {
  const Folder folder;
  const int status = std::system((command + " >" + folder / "out" + " 2>&1 </dev/null").c_str());
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (code != 0) MESSAGE(command << "\n" << read_text(folder / "out"));
  return code;
}

/// Compiles with all warnings as errors.
inline void compile(const std::string& command) {
  REQUIRE(shell(command + warnings) == 0);
}

inline bool have(const std::string& program) {
  return std::system(("command -v " + program + " >/dev/null 2>&1").c_str()) == 0;
}

}  // namespace decid::test
