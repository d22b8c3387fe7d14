// Model files: everything identification needs survives the round trip to the bit.
#include "identify/network/model.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <limits>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "identify/network/prediction.hpp"
#include "identify/training/checkpoint.hpp"
#include "identify/training/presets.hpp"
#include "nn/safetensors.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tests/helpers.hpp"

namespace decid::tools {
namespace {

Model example() {
  sim::Protocol protocol = sim::short_protocol();
  protocol.noise.sensor = {0.001, 0.1};
  Model model(protocol, preset_named("small").image, preset_named("small").architecture);
  model.network.initialise(3);
  for (nn::Layer<float>& layer : model.network.layers())
    for (nn::RunningStatistics<float>& statistic : layer.statistics())
      for (std::size_t i = 0; i < statistic.value.size(); ++i) statistic.value[i] = 0.1F + static_cast<float>(i) / 3.0F;
  const auto rows = static_cast<std::size_t>(model.images().shape().channels * model.images().shape().rows);
  for (std::size_t i = 0; i < rows; ++i) {
    model.rows.mean.push_back(static_cast<float>(i) / 7.0F);
    model.rows.stddev.push_back(1.0F + static_cast<float>(i) / 9.0F);
  }
  model.targets.mean = sim::single_pendulum().parameters.middle();
  for (std::size_t p = 0; p < sim::single_pendulum().parameters.size(); ++p)
    model.targets.stddev[p] = 1.0 / (3.0 + static_cast<double>(p));
  model.origin.seed = 3;
  return model;
}

}  // namespace

TEST_CASE("a model survives its file to the bit") {
  const Model model = example();
  const std::string bytes = to_bytes(model);
  CHECK(bytes == to_bytes(model));
  const Model copy = model_from_bytes(bytes, "copy");
  CHECK(nn::weights_sha256(copy.network) == nn::weights_sha256(model.network));
  CHECK(copy.network.architecture() == model.network.architecture());
  CHECK(sim::to_json(copy.protocol) == sim::to_json(model.protocol));
  CHECK(copy.image() == model.image());
  CHECK(copy.rows.mean == model.rows.mean);
  CHECK(copy.rows.stddev == model.rows.stddev);
  CHECK(copy.targets.mean == model.targets.mean);
  CHECK(copy.targets.stddev == model.targets.stddev);
  CHECK(copy.origin == model.origin);
  CHECK(to_bytes(copy) == bytes);
}

TEST_CASE("a flipped bit anywhere in a model file is detected") {
  const std::string bytes = to_bytes(example());
  const std::size_t header = 8 + static_cast<unsigned char>(bytes[0]) + 256 * static_cast<unsigned char>(bytes[1]);
  const auto refused = [](const std::string& changed) {
    try {
      model_from_bytes(changed, "m.safetensors");
    } catch (const Error& error) {
      return error.where() == "m.safetensors";
    }
    return false;
  };
  int values = 0;
  for (std::size_t i = header; i < bytes.size(); i += 127) {
    std::string changed = bytes;
    changed[i] = static_cast<char>(changed[i] ^ (1 << (i % 8)));
    CAPTURE(i);
    CHECK(refused(changed));
    ++values;
  }
  CHECK(values > 200);
  // In the header too, but for the blanks behind it and the hash's own name, without which the file is an old one.
  const std::size_t name = bytes.find("\"sha256\"");
  REQUIRE(name < header);
  for (std::size_t i = 8; i < bytes.find_last_of('}', header) + 1; i += 7) {
    if (i >= name && i < name + 8) continue;
    std::string changed = bytes;
    changed[i] = static_cast<char>(changed[i] ^ 1);
    CAPTURE(changed.substr(i - 8, 16));
    CHECK(refused(changed));
  }
  std::string damaged = bytes;
  damaged.back() = static_cast<char>(damaged.back() ^ 1);
  test::check_error([&] { model_from_bytes(damaged, "m"); }, Code::file_damaged);

  // A file without a hash is read as it is, and gets one when it is written.
  nn::TensorFile old = nn::from_safetensors(bytes, "m");
  CHECK(old.metadata.erase(nn::content_hash_key) == 1);
  CHECK(to_bytes(model_from_bytes(nn::to_safetensors(old), "m")) == bytes);
  // Where a tensor lies says nothing.
  nn::TensorFile turned = nn::from_safetensors(bytes, "m");
  std::ranges::reverse(turned.tensors);
  CHECK(to_bytes(model_from_bytes(nn::to_safetensors(turned), "m")) == bytes);
}

TEST_CASE("a model from before the noise had a period of its own keeps the trial's length") {
  const auto period_s = [](const Json& protocol) {
    nn::TensorFile file = nn::from_safetensors(to_bytes(example()), "m");
    file.metadata.erase(nn::content_hash_key);
    file.metadata["protocol"] = protocol.dump();
    return model_from_bytes(nn::to_safetensors(file), "m").protocol.noise_period_s();
  };
  Json protocol = Json::parse(sim::to_json(example().protocol));
  CHECK(protocol["vestibular_noise"]["period_s"] == 127.4);
  CHECK(period_s(protocol) == 127.4);
  protocol["vestibular_noise"].erase("period_s");
  CHECK(period_s(protocol) == 63.7);
}

TEST_CASE("a model file whose parts do not stand is refused, each with its reason") {
  Model whole = example();
  const auto features = static_cast<std::size_t>(feature_count(whole.network));
  whole.ood_detector = {.mean = std::vector<float>(features, 0.5F),
                        .whitening = std::vector<float>(features * (features + 1) / 2, 1.0F),
                        .usual = 2.0};
  const std::string bytes = to_bytes(whole);
  CHECK(model_from_bytes(bytes, "m").ood_detector.usual == 2.0);
  const auto refused = [&](const char* reason, const auto& change, Code code = Code::file_damaged) {
    nn::TensorFile file = nn::from_safetensors(bytes, "m");
    file.metadata.erase(nn::content_hash_key);
    change(file);
    CAPTURE(reason);
    test::check_error([&] { model_from_bytes(nn::to_safetensors(file), "m"); }, code, reason);
  };
  const auto tensor = [](nn::TensorFile& file, const char* name) -> std::vector<float>& {
    return std::ranges::find(file.tensors, name, &nn::NamedTensor::name)->values;
  };
  refused(
      "of format 'another'", [](auto& file) { file.metadata["format"] = "another"; }, Code::file_unsupported);
  for (const char* key : {"format", "architecture", "image", "protocol", "targets", "origin"}) {
    const std::string reason = "not a decid model: it has no " + std::string(key);
    refused(
        reason.c_str(), [&](auto& file) { file.metadata.erase(key); }, Code::file_unsupported);
  }
  refused("target scaling that cannot be read", [](auto& file) { file.metadata["targets"] = "{}"; });
  for (const char* list : {"mean", "deviation"})
    for (const std::size_t count : {6U, 8U})
      refused("", [&](auto& file) {
        Json targets = Json::parse(file.metadata["targets"]);
        targets[list] = std::vector<double>(count, 1.0);
        file.metadata["targets"] = targets.dump();
      });
  for (const double stddev : {0.0, -1.0})
    refused("target scaling that is not positive", [&](auto& file) {
      Json targets = Json::parse(file.metadata["targets"]);
      targets["deviation"][3] = stddev;
      file.metadata["targets"] = targets.dump();
    });
  using Limits = std::numeric_limits<float>;
  for (const float stddev : {0.0F, Limits::infinity(), Limits::quiet_NaN(), Limits::denorm_min(), -1.0F})
    refused("image scaling that is not positive", [&](auto& file) { tensor(file, "image.row_deviation")[5] = stddev; });
  refused("image scaling that is not positive",
          [&](auto& file) { tensor(file, "image.row_mean")[5] = std::numeric_limits<float>::quiet_NaN(); });
  refused("familiarity that cannot be read", [](auto& file) { file.metadata["familiarity"] = R"({"usual": "two"})"; });
  refused("familiarity that cannot be read", [](auto& file) { file.metadata["familiarity"] = "{}"; });
  refused("familiarity that is not positive", [](auto& file) { file.metadata["familiarity"] = R"({"usual": 0.0})"; });
  refused("recalibration of distributions that its head does not give",
          [](auto& file) { file.metadata["recalibration"] = "{}"; });
  refused(
      "outputs of the kind 'another'", [](auto& file) { file.metadata["head"] = "another"; }, Code::file_unsupported);
  // A network of one layer has no features.
  Model flat(sim::short_protocol(), {.window = 1000}, "fc 7");
  flat.targets = whole.targets;
  nn::TensorFile file = nn::from_safetensors(to_bytes(flat), "m");
  file.metadata.erase(nn::content_hash_key);
  file.metadata["familiarity"] = R"({"usual": 2.0})";
  test::check_error([&] { model_from_bytes(nn::to_safetensors(file), "m"); }, Code::file_damaged);
}

TEST_CASE("outputs of another number than the network's are not decoded") {
  const Model model = example();
  const std::vector<float> outputs(8, 0.5F);
  CHECK(model.decode(std::span(outputs).first(7)).size() == 7);
  test::check_error([&] { model.decode(std::span(outputs).first(6)); }, Code::size_mismatch, "7");
  CHECK_THROWS_AS(model.decode(outputs), Error);
  std::vector<float> scores(7);
  CHECK_THROWS_AS(model.head->scores(outputs, scores), Error);
}

TEST_CASE("a finished model is no checkpoint") {
  Checkpoint checkpoint;
  CHECK_THROWS_AS(model_from_bytes(to_bytes(example()), "m", &checkpoint), Error);
}

TEST_CASE("a model predicts the same for a trial alone and among others") {
  Model model = example();
  const auto samples = static_cast<std::size_t>(model.protocol.samples());
  constexpr int trials = 70;
  std::vector<float> sway(samples * trials);
  for (std::size_t i = 0; i < sway.size(); ++i) sway[i] = static_cast<float>((i * 2654435761U) % 1000) * 1e-5F;
  const auto trial = [&](int i) {
    return std::span<const float>(sway).subspan(static_cast<std::size_t>(i) * samples, samples);
  };
  const std::vector<float> all = predict(model, trials, 33, sways_in_memory(trial));
  for (const int i : {0, 15, 16, 32, 33, 63, 64, 69}) {
    const std::vector<float> one = predict(model, 1, 64, sways_in_memory([&](int) { return trial(i); }));
    for (std::size_t p = 0; p < sim::single_pendulum().parameters.size(); ++p)
      CHECK(one[p] == all[static_cast<std::size_t>(i) * sim::single_pendulum().parameters.size() + p]);
  }
}

TEST_CASE("an architecture without 7 outputs is refused") {
  test::check_error([&] { Model(sim::default_protocol(), {}, "fc 6"); }, Code::setting_conflict, "7 outputs");
}

TEST_CASE("a preset's folded image is refused for protocols of other cycles") {
  int folded = 0;
  for (const Preset& preset : presets()) {
    if (preset.image.fold == 1) continue;
    ++folded;
    CAPTURE(preset.name);
    const sim::Protocol other = preset.name == "short" ? sim::default_protocol() : sim::short_protocol();
    const Head& head = head_named(preset.head, preset.name);
    test::check_error([&] { Model(other, preset.image, preset.architecture, head); }, Code::setting_conflict);
  }
  CHECK(folded >= 3);
}

TEST_CASE("measurement noise other than the model's is reported") {
  const sim::Protocol ours;
  sim::Protocol theirs;
  theirs.noise.sensor = {0.01, 0.01};
  CHECK(noise_difference(ours, theirs).empty());
  theirs.noise.vestibular.scale_deg = 0.4;
  CHECK(noise_difference(ours, theirs).find("0.4 degrees") != std::string::npos);
}

}  // namespace decid::tools
