// decid export: a model, or a controller, as C files for a firmware.
#include <cctype>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/file.hpp"
#include "nn/single.hpp"
#include "tools/command.hpp"
#include "tools/firmware_quantise.hpp"
#include "tools/firmware_text.hpp"
#include "tools/text.hpp"
#include "tools/version.hpp"

namespace decid::tools {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct Options {
  CommonOptions common;
  std::string model, output, name;
  FirmwareOptions firmware;
};

/// The files' folder, made if it is missing; its parent must be there.
void write_files(const std::string& folder, const std::string& name, const FirmwareFiles& files) {
  std::error_code failed;
  fs::create_directory(folder, failed);
  if (!fs::is_directory(folder))
    throw Error(folder, "is no folder, and none can be made there", "give a folder that can be written");
  const fs::path stem = fs::path(folder) / name;
  PendingFile header(stem.string() + ".h"), source(stem.string() + ".c");
  write_file(header.path(), files.header);
  write_file(source.path(), files.source);
  header.commit();
  source.commit();
}

/// The model file's name as an identifier.
std::string name_of(const std::string& model) {
  std::string name = model.empty() ? "decid_model" : fs::path(model).stem().string();
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  if (name.empty() || std::isalpha(static_cast<unsigned char>(name.front())) == 0) name = "model_" + name;
  return name;
}

/// What the program itself makes of the self-test's sway, with the network that identify has.
TestVector test_vector(const Model& model, const FirmwarePlan& plan) {
  TestVector test;
  std::vector<float> image(static_cast<std::size_t>(model.images().shape().size()));
  model.make_input(test_sway(model.protocol.samples()), image);
  test.outputs.resize(sim::parameter_count);
  if (plan.options.int8)
    test.outputs = run_plan(plan, image);
  else
    nn::SingleNetwork(model.network).run(image, test.outputs);
  for (const double value : model.targets.unscale(test.outputs)) test.parameters.push_back(static_cast<float>(value));
  return test;
}

void export_model(const Options& options) {
  const std::string name = options.name.empty() ? name_of(options.model) : options.name;
  check_firmware_name(name);
  Model model = model_or_built_in(options.model);
  FirmwarePlan plan = plan_firmware(model, options.firmware);
  if (options.firmware.int8) quantise(plan, model);
  const TestVector test = test_vector(model, plan);
  const std::string hash = nn::weights_sha256(model.network);
  const std::string origin =
      format("Made by decid %s from %s, weights SHA-256\n   %s%s.", version,
             options.model.empty() ? "its built-in model" : fs::path(options.model).filename().string().c_str(),
             hash.c_str(), options.firmware.int8 ? ", in 8-bit integers" : "");
  write_files(options.output, name, firmware_files(model, plan, test, name, origin));
  if (options.common.json) {
    std::cout << Json{{"files", {name + ".h", name + ".c"}},
                      {"weight_bytes", plan.weight_bytes()},
                      {"arena_bytes", plan.arena.bytes},
                      {"whole_map_bytes", plan.whole_map_bytes()},
                      {"lines", plan.stream_rows ? "rows" : "columns"},
                      {"weights_sha256", hash}}
                     .dump(2)
              << '\n';
  } else if (!options.common.quiet) {
    std::cout << format(
        "%s.h and %s.c written to %s\n%lld bytes of weights, %lld of arena; all feature maps whole: %lld\n",
        name.c_str(), name.c_str(), options.output.c_str(), plan.weight_bytes(), plan.arena.bytes,
        plan.whole_map_bytes());
  }
}

void add_export_c(CLI::App& parent) {
  auto options = std::make_shared<Options>();
  CLI::App* command = parent.add_subcommand("c", "A model as one C file and its header");
  command->add_option("model", options->model, "Model file; default: the built-in model");
  command->add_option("-o,--output", options->output, "Folder to write NAME.c and NAME.h to; made if it is missing")
      ->required();
  command->add_option("--name", options->name,
                      "What the files and functions are called; default: the model file's name");
  command->add_flag("--incremental", options->firmware.incremental,
                    "With functions that take samples as they arrive and spread the work");
  command->add_flag("--int8", options->firmware.int8, "Weights and activations as 8-bit integers");
  add_common_options(*command, options->common, true);
  command->footer("Example: decid export c tools/model/firmware.safetensors --incremental -o firmware/");
  command->callback([options] {
    apply(options->common);
    export_model(*options);
  });
}

}  // namespace

void add_export(CLI::App& program) {
  CLI::App* command = program.add_subcommand("export", "Write a model or a controller as C files for a firmware");
  command->require_subcommand(1);
  command->footer("Example: decid export c model.safetensors -o firmware/");
  add_export_c(*command);
}

}  // namespace decid::tools
