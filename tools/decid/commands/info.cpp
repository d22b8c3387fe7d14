// decid info: what is in a model file.
#include <iostream>
#include <memory>

#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "dataset/image/image_object.hpp"
#include "identify/network/model.hpp"
#include "identify/network/origin_object.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "sim/protocol/protocol_object.hpp"
#include "tools/decid/command.hpp"
#include "tools/decid/network_alone.hpp"
#include "tools/decid/results/results.hpp"
#include "tools/report/json/recording_json.hpp"

namespace decid::tools {
namespace {

struct InfoOptions {
  CommonOptions common;
  std::string model;
  bool controllers = false;
};

/// The lines of a fused layer, in one line.
std::string layer_text(const nn::Layer<float>& layer) {
  std::string text = layer.text();
  for (std::size_t i = text.find('\n'); i != std::string::npos; i = text.find('\n')) text.replace(i, 1, " + ");
  return text;
}

/// The value in one line, with the number of a measured tilt's samples in their place.
std::string compact(Json json) {
  if (json.contains("measured") && json["measured"].contains("tilt_deg")) {
    Json& tilt = json["measured"]["tilt_deg"];
    tilt = std::to_string(tilt.size()) + " samples";
  }
  return json.dump();
}

std::string shape_text(const nn::Shape& s) {
  return format("%d x %d x %d", s.channels, s.rows, s.columns);
}

std::size_t parameters_of(const nn::Layer<float>& layer) {
  std::size_t count = 0;
  for (const auto& p : layer.parameters()) count += p.value.size();
  return count;
}

Json layers_json(const nn::Network<float>& network) {
  Json layers = Json::array();
  for (const nn::Layer<float>& layer : network.layers()) {
    const nn::Shape s = layer.dst_shape();
    layers.push_back({{"layer", layer_text(layer)},
                      {"output", {s.channels, s.rows, s.columns}},
                      {"parameters", parameters_of(layer)},
                      {"flops", layer.flops()}});
  }
  return layers;
}

void print_layers(const std::string& name, const nn::Network<float>& network) {
  std::cout << name << '\n';
  std::cout << format("  %-48s %-16s %10s %12s\n", "layer", "output", "parameters", "FLOP");
  std::cout << format("  %-48s %-16s\n", "input", shape_text(network.input_shape()).c_str());
  for (const nn::Layer<float>& layer : network.layers())
    std::cout << format("  %-48s %-16s %10zu %12lld\n", layer_text(layer).c_str(),
                        shape_text(layer.dst_shape()).c_str(), parameters_of(layer), layer.flops());
  std::cout << format("  %-48s %-16s %10zu %12lld\n", "total", "", network.parameter_count(), network.flops());
}

void print_with_call(Json json, const InfoOptions& options, const Command& command) {
  add_call(json, record_call(command, {options.model}, {options.model}));
  std::cout << print_json(json) << '\n';
}

/// Returns the figures and layers of a network. kind: the name's key; more: the keys before the hash.
Json network_json(const char* kind, const std::string& name, const nn::Network<float>& network, const Json& more) {
  const nn::Shape in = network.input_shape();
  Json json{{kind, name},
            {"input", {in.channels, in.rows, in.columns}},
            {"layers", layers_json(network)},
            {"parameters", network.parameter_count()},
            {"flops", network.flops()}};
  json.update(more);
  json["weights_sha256"] = nn::weights_sha256(network);
  return json;
}

/// Prints a network without protocol, image and head.
void info_alone(const InfoOptions& options, const Command& command, const NetworkAlone& file) {
  if (options.common.json)
    return print_with_call(
        network_json("network", options.model, file.network, Json::object({{"skipped", file.skipped}})), options,
        command);
  print_layers(options.model, file.network);
  std::cout << "weights   SHA-256 " << nn::weights_sha256(file.network) << '\n';
  for (const std::string& tensor : file.skipped) std::cout << "skipped   " << one_line(tensor) << '\n';
}

Json controllers_json() {
  Json list = Json::array();
  for (const sim::BodyModel* model : sim::body_models()) {
    Json parameters = Json::array();
    for (const sim::ParameterInfo& p : model->parameters)
      parameters.push_back({{"name", p.name},
                            {"option", "--" + p.option},
                            {"description", p.description},
                            {"unit", p.unit},
                            {"low", p.low},
                            {"high", p.high},
                            {"scales_with_mgh", p.scales_with_mgh}});
    list.push_back({{"name", model->name},
                    {"description", model->description},
                    {"source", model->source},
                    {"parameters", std::move(parameters)}});
  }
  return {{"mgh", sim::Body{}.mgh()}, {"controllers", std::move(list)}};
}

/// Prints each controller with its parameters and their ranges for the default body.
void list_controllers() {
  std::cout << format("ranges for a body of m g h %.0f N m/rad (88.9 kg, 1.80 m)\n", sim::Body{}.mgh());
  for (const sim::BodyModel* model : sim::body_models()) {
    std::cout << format("%s: %s\n  source: %s\n", model->name.c_str(), model->description.c_str(),
                        model->source.c_str());
    for (const sim::ParameterInfo& p : model->parameters)
      std::cout << format("  %-8s --%-14s %10.5g to %10.5g %-8s %s\n", p.name.c_str(), p.option.c_str(), p.low, p.high,
                          p.shown_unit().c_str(), p.description.c_str());
  }
}

void info(const InfoOptions& options, const Command& command) {
  if (options.controllers && options.common.json) return print_with_call(controllers_json(), options, command);
  if (options.controllers) return list_controllers();
  if (const std::optional<NetworkAlone> alone = network_alone(options.model))
    return info_alone(options, command, *alone);
  const Model model = model_or_built_in(options.model);
  if (options.common.json)
    return print_with_call(network_json("model", model_name(options.model), model.network,
                                        {{"protocol", sim::to_json_object(model.protocol)},
                                         {"image", dataset::to_json_object(model.image())},
                                         {"origin", to_json_object(model.origin)},
                                         {"head", model.head->name()},
                                         {"recalibrated", model.recalibration.known()}}),
                           options, command);
  const char* const recalibrated = !model.gives_distribution()   ? ""
                                   : model.recalibration.known() ? ", recalibrated"
                                                                 : ", not recalibrated";
  print_layers(model_name(options.model), model.network);
  std::cout << "protocol  " << compact(sim::to_json_object(model.protocol)) << "\nimage     "
            << compact(dataset::to_json_object(model.image())) << "\norigin    " << to_json(model.origin)
            << "\nhead      " << model.head->name() << recalibrated << "\nweights   SHA-256 "
            << nn::weights_sha256(model.network) << '\n';
}

}  // namespace

void add_info(const Command& program) {
  auto options = std::make_shared<InfoOptions>();
  const Command command =
      program.add_subcommand("info", "Describe a model (layers, size, protocol, hashes), or list the controllers");
  command.section("Input");
  Option model = command.add_option("model", options->model,
                                    "Describe this file of a model, or of a network only; default: the built-in model");
  model.unrecorded();
  command
      .add_flag("--controllers", options->controllers,
                "Instead of a model, list the controllers that decid simulates: parameters, options, ranges, sources")
      .excludes(model);
  command.footer(
      "Examples:\n"
      "  decid info\n"
      "  decid info model.safetensors\n"
      "  decid info model.safetensors --json\n"
      "  decid info --controllers");
  run_with(command, options, true, info);
}

}  // namespace decid::tools
