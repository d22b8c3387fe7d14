// A network's layers as C: see layer_text.hpp.
#include "tools/firmware/layer_text.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "tools/firmware/c_text.hpp"

namespace decid::tools {
namespace {

std::string map_table(const FirmwarePlan& plan) {
  std::string text = "static const network_map network_maps[MAPS] = {\n";
  for (const FirmwareMap& map : plan.maps) {
    text += format("    {%d, %d, %d, %d, %d, %d, %d, %d, {%s, %d}},\n", map.offset, map.shape.channels, map.lines,
                   map.positions, map.capacity, map.line_stride, map.channel_stride, map.position_stride,
                   literal(map.steps_per_unit).c_str(), map.zero);
  }
  return text + "};\n\n";
}

/// The name of a layer's table, declared in `text`; NULL if the table is empty.
template <class T>
std::string named(std::string& text, const char* type, const std::string& name, const std::vector<T>& values) {
  if (values.empty()) return "NULL";
  text += table(std::string("static const ") + type + " " + name + "[]", values);
  return name;
}

}  // namespace

bool has_kind(const FirmwarePlan& plan, FirmwareLayer::Kind kind) {
  return std::ranges::count(plan.layers, kind, &FirmwareLayer::kind) > 0;
}

bool uses_exponential(const FirmwarePlan& plan) {
  using Kind = FirmwareLayer::Kind;
  return has_kind(plan, Kind::tanh) || has_kind(plan, Kind::sigmoid) || has_kind(plan, Kind::gelu);
}

std::string layer_settings(const FirmwarePlan& plan) {
  using Kind = FirmwareLayer::Kind;
  const bool leaks = has_kind(plan, Kind::leaky_relu);
  return define("USES_POOLS", std::ranges::any_of(plan.layers, &FirmwareLayer::pools)) +
         define("USES_STATISTICS", has_kind(plan, Kind::statistics)) + define("USES_LEAKY_RELU", leaks) +
         define("USES_TANH", has_kind(plan, Kind::tanh)) + define("USES_SIGMOID", has_kind(plan, Kind::sigmoid)) +
         define("USES_GELU", has_kind(plan, Kind::gelu)) + define("USES_FUNCTIONS", leaks || uses_exponential(plan)) +
         define("USES_LAYER_NORM", has_kind(plan, Kind::layer_norm)) +
         define("USES_BLOCKS", std::ranges::any_of(plan.layers, &FirmwareLayer::joins));
}

std::string layer_tables(const FirmwarePlan& plan) {
  static constexpr const char* kinds[] = {"LAYER_CONVOLUTION",  "LAYER_ALL",        "LAYER_MAX_POOL",
                                          "LAYER_AVERAGE_POOL", "LAYER_STATISTICS", "LAYER_LEAKY_RELU",
                                          "LAYER_TANH",         "LAYER_SIGMOID",    "LAYER_GELU",
                                          "LAYER_NORM",         "LAYER_ADD",        "LAYER_CONCAT"};
  const bool rows = plan.stream_rows;
  const auto along = [&](const Extent& e) { return rows ? e.rows : e.columns; };
  const auto across = [&](const Extent& e) { return rows ? e.columns : e.rows; };
  std::string tables, text = "static const network_layer network_layers[LAYERS] = {\n";
  for (std::size_t i = 0; i < plan.layers.size(); ++i) {
    const FirmwareLayer& layer = plan.layers[i];
    const auto name = [&](const char* what) { return format("layer_%zu_%s", i, what); };
    const std::string weight = plan.options.int8 ? named(tables, "int8_t", name("weight"), layer.steps)
                                                 : named(tables, "float", name("weight"), layer.weight);
    const std::string bias = named(tables, "float", name("bias"), layer.bias);
    const std::string scale = named(tables, "float", name("scale"), layer.scale);
    const std::string affine_scale = named(tables, "float", name("affine_scale"), layer.affine.scale);
    const std::string affine_shift = named(tables, "float", name("affine_shift"), layer.affine.shift);
    text += format(
        "    {%s, %d, %d, %d, %d, %d, %d, %d, %d, %d, %d, %d, %d, %d, %d, %d, %d, %s,\n     %s, %s, %s, %s, %s},\n",
        kinds[static_cast<int>(layer.kind)], layer.src, layer.dst, layer.kept, layer.normalises, layer.rectifies,
        i + 1 == plan.layers.size() && !plan.outputs_in_map, along(layer.kernel), across(layer.kernel),
        along(layer.stride), across(layer.stride), along(layer.pad), across(layer.pad), rows ? layer.dilation : 1,
        rows ? 1 : layer.dilation, layer.groups, layer.taps, literal(layer.factor()).c_str(), weight.c_str(),
        bias.c_str(), scale.c_str(), affine_scale.c_str(), affine_shift.c_str());
  }
  return tables + map_table(plan) + text + "};\n\n";
}

}  // namespace decid::tools
