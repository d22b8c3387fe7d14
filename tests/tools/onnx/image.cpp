// decid image with other software: NumPy computes a model's estimates from its file, and decid reads models that NumPy
// wrote.
#include <nlohmann/json.hpp>

#include "dataset/npz/detail/npy.hpp"
#include "identify/training/training.hpp"
#include "nn/safetensors.hpp"
#include "tests/tools/onnx/networks.hpp"

namespace decid::tools {
namespace {

using namespace decid::test;
using Json = nlohmann::json;

const std::string examples = DECID_SOURCE_DIR "/examples";
const std::string python = "PYTHONPATH=" + examples + " /usr/bin/python3 -B ";

/// A stored member of an .npz file.
template <class Value>
std::vector<Value> array_in(const std::string& path, const std::string& name, const std::vector<std::size_t>& shape) {
  const std::string content = read_text(path);
  const std::size_t member = content.find(name + ".npy");
  REQUIRE(member != std::string::npos);
  const std::size_t at = content.find("\x93NUMPY", member);
  const dataset::NpyHeader header = dataset::parse_npy_header(std::string_view(content).substr(at), name);
  CHECK(header.shape == shape);
  std::vector<Value> values(dataset::value_count(shape));
  REQUIRE(at + header.bytes + values.size() * sizeof(Value) <= content.size());
  std::memcpy(values.data(), content.data() + at + header.bytes, values.size() * sizeof(Value));
  return values;
}

/// The rows of numbers that examples/forward.py prints below its header.
std::vector<std::vector<double>> forward(const Folder& folder, const std::string& model, const std::string& images) {
  REQUIRE(std::system(
              (python + examples + "/forward.py " + model + " " + images + " > " + folder / "estimates").c_str()) == 0);
  std::string header;
  const auto rows = read_csv(folder / "estimates", header);
  CHECK(header == "Kp,Kd,Kp_pass,Kd_pass,Nv,theta,delay");
  return rows;
}

/// NumPy's estimates of the trials are decid's own.
void check_forward(const Folder& folder, const std::string& path, const dataset::Dataset& data) {
  const Model model = load_model(path);
  dataset::write_npz(folder / "d.npz", data);
  run_ok("image --quiet " + folder / "d.npz" + " --model " + path + " -o " + folder / "i.npz");
  const std::vector<float> outputs = outputs_of_all(model, data);
  const auto rows = forward(folder, path, folder / "i.npz");
  REQUIRE(rows.size() == data.parameters.size());
  const std::size_t width = outputs.size() / rows.size();
  // Means of mixtures are smooth functions of the outputs that change by less than they do.
  const double tolerance = rounding_of(model, outputs);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const sim::Parameters expected = model.decode(std::span(outputs).subspan(i * width, width));
    for (std::size_t p = 0; p < expected.size(); ++p) {
      CAPTURE(p);
      CHECK(within(rows[i][p], expected[p],
                   tolerance * model.targets.stddev[p] + 1e-8 * std::abs(expected[p])));  // digits printed
    }
  }
}

}  // namespace

TEST_CASE("image: the network input of each trial, with its targets") {
  const Folder folder;
  const Model model = models_of_every_layer().front();
  write_text(folder / "m.safetensors", to_bytes(model));
  const dataset::Dataset data = noisy_trials(model, 6, 31);
  dataset::write_npz(folder / "d.npz", data);
  const std::string command =
      "image " + folder / "d.npz" + " --model " + folder / "m.safetensors" + " -o " + folder / "i.npz";
  const auto made = run_ok(command + " --threads 3");
  CHECK(contains(made.err, "6 images of "));
  const dataset::ImageShape s = model.images().shape();
  const std::string path = folder / "i.npz";
  CHECK(array_in<float>(path, "images", {6, std::size_t(s.channels), std::size_t(s.rows), std::size_t(s.columns)}) ==
        images_of(model, data));
  const auto targets = array_in<float>(path, "targets", {6, 7});
  const auto parameters = array_in<double>(path, "parameters", {6, 7});
  for (std::size_t i = 0; i < 6; ++i) {
    const std::vector<float> expected = model.targets.scale(data.parameters[i]);
    for (std::size_t p = 0; p < 7; ++p) {
      CHECK(targets[7 * i + p] == expected[p]);
      CHECK(parameters[7 * i + p] == data.parameters[i][p]);
    }
  }
  CHECK(array_in<std::uint8_t>(path, "split", {6}) == data.split);
  CHECK(array_in<float>(path, "row_mean", {std::size_t(s.channels), std::size_t(s.rows)}) == model.rows.mean);
  CHECK(array_in<float>(path, "row_deviation", {std::size_t(s.channels), std::size_t(s.rows)}) == model.rows.stddev);
  const std::string before = read_text(path);
  REQUIRE(run_decid(command + " --threads 1 --quiet").err.empty());
  CHECK(read_text(path) == before);
}

TEST_CASE("image: of a preset, scaled as a training on the data set would") {
  const Folder folder;
  const dataset::Dataset data = noisy_trials(models_of_every_layer().front(), 12, 31);
  dataset::write_npz(folder / "d.npz", data);
  TrainingSettings settings;
  settings.preset = preset_named("small");
  const Model begun = start_training(*dataset::stored_source(dataset::StoredDataset(data)), settings).model;
  const dataset::ImageShape s = begun.images().shape();
  const std::vector<std::size_t> shape{12, std::size_t(s.channels), std::size_t(s.rows), std::size_t(s.columns)};
  run_ok("image --quiet " + folder / "d.npz" + " --preset small -o " + folder / "i.npz");
  CHECK(array_in<float>(folder / "i.npz", "images", shape) == images_of(begun, data));
  CHECK(array_in<float>(folder / "i.npz", "targets", {12, 7})[3] == begun.targets.scale(data.parameters[0])[3]);
  write_text(folder / "image.json", dataset::to_json(begun.image()));
  run_ok("image --quiet " + folder / "d.npz" + " --image " + folder / "image.json" + " -o " + folder / "j.npz");
  CHECK(array_in<float>(folder / "j.npz", "images", shape) == images_of(begun, data));
}

TEST_CASE("forward.py: NumPy computes decid's estimates from a model file") {
  const Folder folder;
  for (const Model& model : models_of_every_layer()) {
    CAPTURE(model.network.architecture());
    write_text(folder / "m.safetensors", to_bytes(model));
    check_forward(folder, folder / "m.safetensors", noisy_trials(model, 5, 31));
  }
  for (const std::string name : {"built_in", "ideal", "spectra", "firmware"}) {
    CAPTURE(name);
    const std::string path = DECID_SOURCE_DIR "/models/" + name + ".safetensors";
    check_forward(folder, path, noisy_trials(load_model(path), 4, 31));
  }
}

TEST_CASE("model_file.py: a model that NumPy wrote is identified with, and a damaged one noticed") {
  const Folder folder;
  write_text(folder / "make.py", R"(import json, sys
import numpy, model_file
numbers = numpy.random.default_rng(5)
def weights(*shape): return numbers.normal(size=shape) * (2 / numpy.prod(shape[1:])) ** 0.5
tensors = {
    "layers.0.weight": weights(6, 2, 5, 1), "layers.0.bias": 0.1 * numbers.normal(size=6),
    "layers.1.gamma": numpy.ones(6), "layers.1.beta": numpy.zeros(6),
    "layers.1.running_mean": 0.1 * numbers.normal(size=6), "layers.1.running_variance": 1 + numbers.random(6),
    "layers.3.weight": weights(7, 6 * 98), "layers.3.bias": numpy.zeros(7),
}
metadata = {
    "format": "decid model 1",
    "architecture": "conv 6 5x1 stride 1x1 pad 0x0\nbatchnorm\nrelu\nfc 7",
    "protocol": json.dumps({"name": "mine", "sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1],
                                                         "offset_s": 0, "cycles": 1}}),
    "image": json.dumps({"window": 2000, "half_spectrum": True, "rows": 102, "channels": ["log_modulus", "phase"]}),
    "targets": json.dumps({"mean": [881, 252, 220, 126, 0.5, 0.0026, 0.12],
                           "deviation": [218, 73, 91, 36, 0.29, 0.0015, 0.069]}),
    "origin": "{}",
}
model_file.write(sys.argv[1], metadata, tensors)
)");
  const std::string path = folder / "m.safetensors";
  REQUIRE(shell(python + folder / "make.py" + " " + path) == 0);
  const Model model = load_model(path);
  CHECK(model.network.architecture() == "conv 6 5x1 stride 1x1 pad 0x0\nbatchnorm\nrelu\nfc 7");
  const dataset::Dataset data = noisy_trials(model, 4, 31);
  check_forward(folder, path, data);
  run_ok("info " + path);
  CHECK(run_json("evaluate --json --model " + path + " --data " + folder / "d.npz").at("trials") == 4);
  // Both write the same hash; a file whose hash was made by Python is the one that decid writes, too.
  const std::string bytes = read_text(path);
  const nn::TensorFile file = nn::from_safetensors(bytes, path);
  CHECK(file.metadata.at("sha256") == nn::content_sha256(file));
  CHECK(nn::to_safetensors(file) == bytes);
  // A flipped bit, noticed by both; the script gives no hash to what has a wrong one.
  std::string damaged = bytes;
  damaged[damaged.size() - 2] = static_cast<char>(damaged[damaged.size() - 2] ^ 4);
  write_text(path, damaged);
  check_refused("info " + path, "SHA-256");
  CHECK(std::system((python + examples + "/model_file.py " + path + " 2>/dev/null").c_str()) != 0);
  CHECK(read_text(path) == damaged);
  // An old file without a hash is read, and gets one by the script.
  nn::TensorFile old = file;
  old.metadata.erase("sha256");
  write_text(path, nn::to_safetensors(old));
  run_ok("info " + path);
  REQUIRE(shell(python + examples + "/model_file.py " + path) == 0);
  CHECK(read_text(path) == bytes);
}

}  // namespace decid::tools
