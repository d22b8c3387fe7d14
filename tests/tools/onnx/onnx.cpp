// decid export onnx: ONNX Runtime gives the outputs that decid gives, for every kind of layer and the model of the
// program.
#include "tools/onnx/onnx.hpp"

#include "base/text.hpp"
#include "tests/tools/onnx/networks.hpp"
#include "tools/onnx/protobuf.hpp"

namespace decid::tools {
namespace {

using namespace decid::test;

const std::string modules = DECID_SOURCE_DIR "/build/npm/node_modules";

/// Runs the file on the trials' images.
void check_runtime(const Model& model, const std::string& onnx, int trials) {
  REQUIRE_MESSAGE(std::filesystem::exists(modules + "/onnxruntime-node"),
                  "this test needs ONNX Runtime of npm: tools/setup --check fetches it");
  const Folder folder;
  const dataset::Dataset data = noisy_trials(model, trials, 31);
  write_text(folder / "images", as_bytes(images_of(model, data)));
  write_text(folder / "model.onnx", onnx);
  REQUIRE(std::system(("node " DECID_SOURCE_DIR "/tests/tools/onnx/run.mjs " + modules + " " + folder / "model.onnx" +
                       " " + folder / "images" + " " + folder / "outputs" + " > " + folder / "names")
                          .c_str()) == 0);
  const std::vector<float> expected = outputs_of_all(model, data);
  const std::string bytes = read_text(folder / "outputs");
  REQUIRE(bytes.size() == expected.size() * sizeof(float));
  std::vector<float> found(expected.size());
  std::memcpy(found.data(), bytes.data(), bytes.size());
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

TEST_CASE("onnx: the built-in model, as the program writes it") {
  const Folder folder;
  const auto made = run_decid("export onnx -o " + folder / "m.onnx");
  CHECK(made.code == 0);
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
  check_refused("export onnx " + folder / "m.onnx" + " -o " + folder / "n.onnx", {"m.onnx"});
  check_refused("export onnx " + folder / "m.onnx" + " -o " + folder / "m.onnx", {"read or written already"});
  check_refused("export onnx -o /nowhere/m.onnx", {"/nowhere"});
  CHECK(folder.files() == 1);
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
