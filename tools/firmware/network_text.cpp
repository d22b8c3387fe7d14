// A network alone as C: see text.hpp.
#include "embedded/firmware_arithmetic.hpp"
#include "embedded/firmware_elementary.hpp"
#include "embedded/firmware_network.hpp"
#include "embedded/firmware_network_alone.hpp"
#include "embedded/firmware_network_alone_header.hpp"
#include "embedded/firmware_types.hpp"
#include "nn/predictor.hpp"
#include "tools/firmware/c_text.hpp"
#include "tools/firmware/layer_text.hpp"
#include "tools/firmware/text.hpp"

namespace decid::tools {
namespace {

std::string settings(const nn::Network<float>& network, const FirmwarePlan& plan) {
  using Kind = FirmwareLayer::Kind;
  const bool statistics = has_kind(plan, Kind::statistics), gelu = has_kind(plan, Kind::gelu);
  std::string text = define("QUANTISED", 0) + define("STREAM_ROWS", 1) + layer_settings(plan) +
                     define("MAPS", static_cast<long long>(plan.maps.size())) +
                     define("LAYERS", static_cast<long long>(plan.layers.size())) +
                     define("INPUTS", network.input_shape().size()) + define("OUTPUTS", network.output_shape().size());
  text += define("USES_LOG", 0) + define("USES_ASINH", 0) + define("USES_EXPONENTIAL", uses_exponential(plan)) +
          define("USES_NORMAL", gelu) + define("USES_DENSITY", 0) +
          define("USES_SQUARE_ROOT", statistics || has_kind(plan, Kind::layer_norm)) + define("USES_FMA_FLOAT", 1) +
          define("USES_FMA_DOUBLE", gelu) + define("USES_IS_FINITE", 0) + define("USES_FLOAT_BITS", 1);
  if (statistics)
    text += "#define STATISTICS_EPSILON " + literal(static_cast<float>(nn::StatisticsPool::epsilon)) + "\n";
  return text + "/* Where things are in the arena, bytes. */\n" + define("MAPS_OFFSET", plan.arena.maps) +
         define("PATCH_OFFSET", plan.arena.patch) + define("OUTPUTS_OFFSET", plan.arena.outputs);
}

}  // namespace

FirmwareFiles network_files(const nn::Network<float>& network, const FirmwarePlan& plan, const std::string& name,
                            const std::string& origin) {
  const std::vector<float> input = test_sway(network.input_shape().size());
  std::vector<float> outputs(static_cast<std::size_t>(network.output_shape().size()));
  nn::Predictor(network, 1).run(input, outputs);

  const nn::Shape& in = network.input_shape();
  const std::string constants =
      define("DECID_FW_INPUT_CHANNELS", in.channels) + define("DECID_FW_INPUT_ROWS", in.rows) +
      define("DECID_FW_INPUT_COLUMNS", in.columns) + define("DECID_FW_OUTPUTS", network.output_shape().size()) +
      define("DECID_FW_ARENA_BYTES", plan.arena.bytes) + define("DECID_FW_WEIGHT_BYTES", plan.weight_bytes());
  const std::string header = "/* " + origin + "\n   How to use it: docs/guide/engine.md of decid. */\n" +
                             replaced(std::string(embedded::firmware_network_alone_header()), "@CONSTANTS@", constants);
  std::string source = "/* " + origin + R"(
   Plain C99, or C++, without a library, memory or state of its own. gcc outside of -std=c99 needs -ffp-contract=off, no
   compiler may have -ffast-math or -ffinite-math-only. The self-test shows whether the bits are right. */
)" + "#include \"" + name +
                       ".h\"\n\n#include <float.h>\n#include <stddef.h>\n#include <stdint.h>\n\n" +
                       settings(network, plan) + "\n";
  source += embedded::firmware_arithmetic();
  source += "\n";
  if (uses_exponential(plan)) source += std::string(embedded::firmware_elementary()) + "\n";
  source += embedded::firmware_types();
  source += "\n/* ---- Tables */\n\n" + layer_tables(plan) +
            table("static const uint32_t test_outputs[OUTPUTS]", to_bits(outputs)) + "\n";
  source += embedded::firmware_network();
  source += "\n";
  source += embedded::firmware_network_alone();
  return {with_name(header, name), with_name(source, name)};
}

}  // namespace decid::tools
