// decid export onnx: ONNX Runtime gives the outputs that decid gives, for every kind of layer and the model of the
// program.
#include "tools/onnx/onnx.hpp"

#include "base/text.hpp"
#include "nn/fit.hpp"
#include "nn/network_file.hpp"
#include "tests/tools/onnx/networks.hpp"
#include "tools/onnx/protobuf.hpp"

namespace decid::tools {
namespace {

using namespace decid::test;

const std::string modules = DECID_SOURCE_DIR "/build/npm/node_modules";

/// Returns the outputs of ONNX Runtime for these network inputs.
std::vector<float> run_onnx(const std::string& onnx, const std::vector<float>& images, const Folder& folder) {
  REQUIRE_MESSAGE(std::filesystem::exists(modules + "/onnxruntime-node"),
                  "this test needs ONNX Runtime of npm: tools/setup --check fetches it");
  write_text(folder / "images", as_bytes(images));
  write_text(folder / "model.onnx", onnx);
  REQUIRE(std::system(("node " DECID_SOURCE_DIR "/tests/tools/onnx/run.mjs " + modules + " " + folder / "model.onnx" +
                       " " + folder / "images" + " " + folder / "outputs" + " > " + folder / "names")
                          .c_str()) == 0);
  const std::string bytes = read_text(folder / "outputs");
  std::vector<float> found(bytes.size() / sizeof(float));
  std::memcpy(found.data(), bytes.data(), bytes.size());
  return found;
}

/// Runs the file on the trials' images.
void check_runtime(const Model& model, const std::string& onnx, int trials) {
  const Folder folder;
  const dataset::Dataset data = noisy_trials(model, trials, 31);
  const std::vector<float> found = run_onnx(onnx, images_of(model, data), folder);
  const std::vector<float> expected = outputs_of_all(model, data);
  REQUIRE(found.size() == expected.size());
  const double tolerance = rounding_of(model, expected);
  for (std::size_t i = 0; i < found.size(); ++i) {
    CAPTURE(i);
    CHECK(within(static_cast<double>(found[i]), static_cast<double>(expected[i]), tolerance));
  }
  const nn::Shape in = model.network.input_shape();
  CHECK(read_text(folder / "names") == format("images float32 trials %d %d %d\noutputs float32 trials %d\n",
                                              in.channels, in.rows, in.columns, model.network.output_shape().channels));
}

}  // namespace

TEST_CASE("onnx: ONNX Runtime gives decid's outputs, for every kind of layer") {
  for (const Model& model : models_of_every_layer()) {
    CAPTURE(model.network.architecture());
    check_runtime(model, onnx_bytes(model), 5);
  }
}

TEST_CASE("onnx: a network alone, with the layers that are one file, residual and concat") {
  for (const char* text :
       {"conv 6 3x3 pad 1 groups 2; leakyrelu 0.2; conv 8 3x2 pad 2x1 dilation 2x3; tanh; maxpool 3 stride 2 pad 1; fc "
        "5",
        "conv 6 3x3 pad 1; layernorm; gelu; dropout 0.5; avgpool 3 stride 2 pad 1; sigmoid; globalavgpool",
        "conv 4 1x1; residual { conv 4 3x3 pad 1; batchnorm; relu; concat { conv 2 1x1 }; conv 4 1x1 }; relu; fc 6; "
        "layernorm; residual { tanh }; concat { fc 3 }; fc 4"}) {
    CAPTURE(text);
    nn::Network network({4, 9, 8}, text);
    network.initialise(3);
    const Folder folder;
    nn::write_network(network, folder / "n.safetensors");
    run_ok("export onnx " + folder / "n.safetensors" + " -o " + folder / "n.onnx");
    const std::string onnx = read_text(folder / "n.onnx");
    CHECK(onnx == onnx_bytes(network));
    std::vector<float> images;
    for (int i = 0; i < 3 * 4 * 9 * 8; ++i) images.push_back(static_cast<float>((i * 7919) % 1000) / 500.0F - 1.0F);
    const std::vector<float> found = run_onnx(onnx, images, folder), expected = nn::predict(network, images);
    REQUIRE(found.size() == expected.size());
    double largest = 0.0;
    for (const float value : expected) largest = std::max(largest, std::abs(static_cast<double>(value)));
    // Sums of at most 216 products, seven layers deep.
    for (std::size_t i = 0; i < found.size(); ++i)
      CHECK(within(static_cast<double>(found[i]), static_cast<double>(expected[i]),
                   4 * 0x1p-24 * std::sqrt(7 * 216.0) * largest));
  }
}

TEST_CASE("onnx: the built-in model, as the program writes it") {
  const Folder folder;
  const auto made = run_ok("export onnx -o " + folder / "m.onnx");
  CHECK(contains(made.err, "to 72 outputs (mixture 2)"));
  const std::string onnx = read_text(folder / "m.onnx");
  const Model model = built_in_model();
  CHECK(onnx == onnx_bytes(model));
  check_runtime(model, onnx, 4);
  // The file has everything needed to interpret the outputs.
  for (const char* text : {"decid.head", "mixture 2", "decid.targets", "decid.protocol", "decid.image"}) {
    CAPTURE(text);
    CHECK(contains(onnx, text));
  }
}

TEST_CASE("protobuf: the examples of its specification") {
  // https://protobuf.dev/programming-guides/encoding: a = 150; b = "testing"; c = {a = 150}; -2 as int64.
  CHECK(Message().add(1, 150LL).bytes() == "\x08\x96\x01");
  CHECK(Message().add(2, std::string_view("testing")).bytes() == "\x12\x07testing");
  CHECK(Message().add(3, Message().add(1, 150LL)).bytes() == "\x1a\x03\x08\x96\x01");
  CHECK(Message().add(1, -2LL).bytes() == "\x08\xfe\xff\xff\xff\xff\xff\xff\xff\xff\x01");
  CHECK(Message().add(2, 1.0F).bytes() == std::string("\x15\x00\x00\x80\x3f", 5));
}

}  // namespace decid::tools
