// A firmware's files: tools/firmware/runtime/ with the tables that a plan fills in.
#pragma once

#include <cstdint>
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

/// Throws Error unless `name` is an identifier of C, at most 40 characters long.
void check_firmware_name(const std::string& name);
/// Returns the size of the out-of-distribution score's tables; 0 if the model is exported without it.
long long familiarity_bytes(const Model& model, const FirmwarePlan& plan);
/// Returns the files for recordings of `body`. `name` begins every public name. `origin`: text about the model, for
/// people.
FirmwareFiles firmware_files(const Model& model, const ForBody& body, const FirmwarePlan& plan, const TestVector& test,
                             const std::string& name, const std::string& origin);

/// Replaces DECID_FW in `text`: by `name` before names in lower case, by NAME elsewhere.
std::string with_name(std::string text, const std::string& name);
/// Replaces the first `what` in `text`, which must contain it.
std::string replaced(std::string text, const std::string& what, const std::string& by);
std::string define(const std::string& name, long long value);
std::string define_double(const std::string& name, double value);
/// Returns a C literal with exactly these bits. Throws Error for a value that is not finite.
std::string literal(float value);
std::string literal(double value, int digits = 17);
bool has_kind(const FirmwarePlan& plan, FirmwareLayer::Kind kind);
/// Returns true if a layer of the plan needs the exponential function.
bool uses_exponential(const FirmwarePlan& plan);
/// Returns the preprocessor's settings for the kinds of layers that the plan has.
std::string layer_settings(const FirmwarePlan& plan);
/// Returns the tables of weights, maps and layers.
std::string layer_tables(const FirmwarePlan& plan);
std::vector<std::uint32_t> to_bits(const std::vector<float>& values);
/// Escapes `text` for a C comment.
std::string comment(const std::string& text);
/// Returns a C table, several values per line.
template <class T>
std::string table(const std::string& declaration, const std::vector<T>& values);

}  // namespace decid::tools
