// Files of networks alone, as nn::write_network makes them: info and export c; export onnx is in tests/tools/onnx.
#include <doctest/doctest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "base/text.hpp"
#include "nn/fit.hpp"
#include "nn/network_file.hpp"
#include "tests/tools/decid/run.hpp"

using namespace decid;
using test::Folder;
using test::run_decid;
using test::run_ok;
using Json = nlohmann::json;

namespace {

constexpr const char* text =
    "conv 6 3x3 pad 1; batchnorm; relu; maxpool 2; conv 9 2x2 stride 2x1; relu; avgpool 1x2; statspool; fc 5";
constexpr nn::Shape shape{2, 11, 9};

nn::Network<float> made(const char* architecture = text) {
  nn::Network network(shape, architecture);
  network.initialise(7);
  for (nn::Parameter<float>* p : network.parameters())
    if (p->fan_in == 0)
      for (std::size_t i = 0; i < p->value.size(); ++i) p->value[i] += 0.125F * static_cast<float>(i % 5) - 0.25F;
  return network;
}

}  // namespace

TEST_CASE("a network alone: info shows its layers, and tensors that were skipped") {
  const Folder folder;
  nn::write_network(made(), folder / "n.safetensors");
  const auto shown = run_ok("info " + folder / "n.safetensors");
  CHECK(shown.out.find("weights   SHA-256 " + nn::weights_sha256(made())) != std::string::npos);
  CHECK(shown.out.find("protocol") == std::string::npos);
  const Json json = Json::parse(run_decid("info --json " + folder / "n.safetensors").out);
  CHECK(json.at("input") == Json{2, 11, 9});
  CHECK(json.at("parameters") == made().parameter_count());
  CHECK(json.at("weights_sha256") == nn::weights_sha256(made()));
  CHECK(json.at("skipped").empty());
  nn::write_network(made(), folder / "m\xff.safetensors");  // JSON is UTF-8, a file's name need not be
  const Json other = Json::parse(run_ok("info --json " + folder / "m\xff.safetensors").out);
  CHECK(other.at("network").get<std::string>().ends_with("m\xEF\xBF\xBD.safetensors"));

  // As a program of PyTorch would write it: half precision, no hash, and a count.
  const std::string header =
      R"({"__metadata__":{"architecture":"fc 1","input":"2,1,1"},"layers.0.weight":{"dtype":"F16","shape":[1,2],)"
      R"("data_offsets":[0,4]},"layers.0.bias":{"dtype":"BF16","shape":[1],"data_offsets":[4,6]},)"
      R"("bn.num_batches_tracked":{"dtype":"I64","shape":[],"data_offsets":[6,14]}})";
  const std::uint64_t length = header.size();
  const std::uint16_t bits[] = {0x3c00, 0xc000, 0x3f00, 1, 0, 0, 0};
  test::write_text(folder / "torch.safetensors", std::string(reinterpret_cast<const char*>(&length), 8) + header +
                                                     std::string(reinterpret_cast<const char*>(bits), sizeof bits));
  const auto torch = run_ok("info " + folder / "torch.safetensors");
  CHECK(torch.out.find("skipped   bn.num_batches_tracked (I64)") != std::string::npos);
  CHECK(nn::predict(nn::read_network(folder / "torch.safetensors"), std::vector<float>{3, 1}) ==
        std::vector<float>{1.5F});
}

TEST_CASE("a network alone: exported C has the predictor's bits" * doctest::test_suite("slow")) {
  const char* architecture = text;
  SUBCASE("the first layers of decid") {}
  SUBCASE("blocks, functions, padded pools, groups, dilation") {
    architecture =
        "conv 4 3x2 pad 2x3 groups 2 dilation 2x3; layernorm; gelu; maxpool 3 stride 2 pad 1; "
        "residual { batchnorm; leakyrelu 0.2; conv 4 3x3 pad 1; batchnorm }; relu; "
        "concat { tanh; residual { conv 4 3x1 pad 5x0 groups 4 dilation 5x1; sigmoid; relu } }; "
        "avgpool 3x2 stride 1x2 pad 1x1; dropout 0.3; conv 5 3x3 pad 1; gelu; relu; statspool; layernorm; fc 5";
  }
  SUBCASE("a block on the input, functions at both ends") {
    architecture = "residual { tanh }; concat { sigmoid; leakyrelu }; layernorm; maxpool 2 stride 1 pad 1; fc 6; gelu";
  }
  SUBCASE("a normalisation as output") {
    architecture = "leakyrelu; fc 4; layernorm";
  }
  SUBCASE("planes as outputs") {
    architecture = "conv 4 3x3; batchnorm; relu; maxpool 2; conv 3 2x3 pad 1";
  }
  SUBCASE("planes as outputs of a normalisation") {
    architecture = "conv 3 1x1; layernorm";
  }
  SUBCASE("planes as outputs of a block") {
    architecture = "concat { conv 3 3x3 pad 1; tanh }";
  }
  CAPTURE(architecture);
  const Folder folder;
  const nn::Network<float> network = made(architecture);
  nn::write_network(network, folder / "net.safetensors");
  run_ok("export c " + folder / "net.safetensors" + " -o " + folder / "c");
  test::write_text(folder / "main.c",
                   "#include <stdio.h>\n#include \"net.h\"\n"
                   R"(static net_arena arena;
int main(void) {
  float input[NET_INPUT_CHANNELS * NET_INPUT_ROWS * NET_INPUT_COLUMNS], outputs[NET_OUTPUTS];
  int i;
  for (i = 0; i < 198; ++i) input[i] = (float)((i * 37) % 64) * 0.25F - 8.0F;
  if (net_self_test(&arena) != NET_OK || net_run(input, outputs, &arena) != NET_OK) return 1;
  if (net_run(input, outputs, NULL) != NET_ERROR_NULL || net_run(NULL, outputs, &arena) != NET_ERROR_NULL) return 2;
  fwrite(outputs, sizeof outputs, 1, stdout);
  input[5] = 1.0F / 0.0F;
  return net_run(input, outputs, &arena) == NET_ERROR_NOT_FINITE ? 0 : 3;
}
)");
  std::vector<float> input;
  for (int i = 0; i < 198; ++i) input.push_back(static_cast<float>(i * 37 % 64) * 0.25F - 8.0F);
  const std::vector<float> expected = nn::predict(network, input);
  for (const char* compiler : {"gcc -std=c99 -O2", "gcc -std=c99 -O1 -fsanitize=address,undefined", "g++ -x c++ -O0"}) {
    CAPTURE(compiler);
    REQUIRE(std::system((std::string(compiler) + " -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror -I" +
                         folder / "c" + " " + folder / "main.c" + " " + folder / "c/net.c" + " -o " + folder / "run")
                            .c_str()) == 0);
    REQUIRE(std::system((folder / "run" + " > " + folder / "out").c_str()) == 0);
    const std::string bytes = test::read_text(folder / "out");
    REQUIRE(bytes.size() == expected.size() * sizeof(float));
    CHECK(std::memcmp(bytes.data(), expected.data(), bytes.size()) == 0);
  }
}

TEST_CASE("a network alone: dropout without other layers is exported as C99 that passes its input on") {
  for (const char* architecture : {"dropout 0.5", "dropout 0.5; dropout 0.2"}) {
    const Folder folder;
    const nn::Network<float> network({3, 1, 1}, architecture);
    nn::write_network(network, folder / "net.safetensors");
    run_ok("export c " + folder / "net.safetensors" + " -o " + folder / "c");
    test::write_text(folder / "main.c", R"(#include "net.h"
static net_arena arena;
int main(void) {
  const float input[3] = {1.5F, -2.0F, 0.0F};
  float outputs[NET_OUTPUTS];
  if (net_self_test(&arena) != NET_OK || net_run(input, outputs, &arena) != NET_OK) return 1;
  return outputs[0] == 1.5F && outputs[1] == -2.0F && outputs[2] == 0.0F ? 0 : 2;
}
)");
    REQUIRE(std::system(("gcc -std=c99 -pedantic-errors -Wall -Wextra -Werror -I" + folder / "c" + " " +
                         folder / "main.c" + " " + folder / "c/net.c" + " -o " + folder / "run")
                            .c_str()) == 0);
    CHECK(std::system((folder / "run").c_str()) == 0);
  }
}

TEST_CASE("a network alone: the checkpoint of a fit is refused") {
  const Folder folder;
  const std::string path = folder / "fit.safetensors";
  const std::vector<float> inputs{0, 1, 2, 3}, targets{0, 1, 2, 3};
  nn::Network<float> network({1, 1, 1}, "fc 1");
  nn::fit(network, {inputs, targets, 4}, {.epochs = 1, .average = 0.9, .checkpoint = path});
  for (const char* command : {"info ", "export c ", "export onnx "}) {
    const std::string output = std::string(command) == "info " ? "" : " -o " + folder / "out";
    test::check_refused(command + path + output, "is the checkpoint of a fit");
  }
}

TEST_CASE("a network alone: what exported C does not have is refused") {
  const Folder folder;
  const std::string path = folder / "net.safetensors";
  nn::write_network(made(), path);
  for (const char* flag : {"--int8", "--incremental", "--ood-score", "--mass 70 --height 1.7"})
    test::check_refused("export c " + path + " " + flag + " -o " + folder / "c");
}
