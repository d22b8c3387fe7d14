// Shared fixtures for tests of the C interface: owning handles, a recording, checks of errors.
#pragma once

#include <doctest/doctest.h>

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "bindings/c/decid.h"
#include "tests/helpers.hpp"

namespace decid::test {

template <auto Free>
struct Freed {
  template <class T>
  void operator()(T* handle) const {
    Free(handle);
  }
};
using OwnedModel = std::unique_ptr<decid_model, Freed<decid_model_free>>;
using OwnedProtocol = std::unique_ptr<decid_protocol, Freed<decid_protocol_free>>;
using OwnedRecording = std::unique_ptr<decid_recording, Freed<decid_recording_free>>;
using OwnedResult = std::unique_ptr<decid_result, Freed<decid_result_free>>;
using OwnedDataset = std::unique_ptr<decid_dataset, Freed<decid_dataset_free>>;

/// make(place) must succeed; what it has made.
template <class Owned, class Make>
Owned make(const Make& make) {
  typename Owned::pointer handle = nullptr;
  const decid_status status = make(&handle);
  INFO(std::string(decid_error_text()));
  REQUIRE(status == DECID_OK);
  REQUIRE(handle != nullptr);
  return Owned(handle);
}

inline const decid_model* built_in() {
  static const OwnedModel model =
      make<OwnedModel>([](decid_model** place) { return decid_model_load(nullptr, place); });
  return model.get();
}

inline OwnedProtocol protocol(const char* name) {
  return make<OwnedProtocol>([&](decid_protocol** place) { return decid_protocol_load(name, place); });
}

/// A trial of the default protocol with the middle of every range.
inline std::vector<double> simulated(std::uint64_t seed) {
  const decid_protocol* played = decid_model_protocol(built_in());
  std::vector<double> parameters, sway_rad(decid_protocol_samples(played));
  for (std::size_t p = 0; p < decid_protocol_parameters(played); ++p) {
    const decid_parameter_info* info = decid_protocol_parameter(played, p);
    parameters.push_back(0.5 * (info->low + info->high));
  }
  const OwnedProtocol ideal = protocol("default");
  REQUIRE(decid_simulate(ideal.get(), parameters.data(), 1, seed, sway_rad.data(), nullptr) == DECID_OK);
  return sway_rad;
}

inline OwnedRecording make_recording(const std::vector<double>& sway_rad) {
  return make<OwnedRecording>([&](decid_recording** place) {
    return decid_recording_of(sway_rad.data(), sway_rad.size(), 100.0, DECID_RADIANS, place);
  });
}

/// Checks that a call failed, and that this thread's error has the code, a remedy, and the fact if one is given.
inline void refused(decid_status status, Code code, std::string_view fact = {}, const char* file = __builtin_FILE(),
                    int line = __builtin_LINE()) {
  const std::string text = decid_error_text();
  INFO("called in " << file << ", line " << line);
  CAPTURE(text);
  CHECK(status == (code == Code::stopped         ? DECID_STOPPED
                   : code == Code::out_of_memory ? DECID_NO_MEMORY
                   : code == Code::internal      ? DECID_FAILED
                                                 : DECID_BAD_INPUT));
  CHECK(std::string(decid_error_code()) == name(code));
  CHECK(text == decid_error_where() + std::string(": ") + decid_error_problem() + "; " + decid_error_remedy());
  CHECK_FALSE(std::string(decid_error_remedy()).empty());
  CHECK(contains(text, fact));
}

}  // namespace decid::test
