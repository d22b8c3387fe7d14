// Tests of nn/network_file.hpp.
#include "nn/network_file.hpp"

#include <doctest/doctest.h>

#include <filesystem>

#include "base/files/file.hpp"
#include "nn/fit.hpp"
#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

TEST_CASE("network files: read back what was written, and are refused if damaged") {
  const std::string path = (std::filesystem::temp_directory_path() / "decid_network_file").string();
  Network net({2, 5, 4}, "conv 3 3x3; batchnorm; relu; fc 2");
  net.initialise(3);
  write_network(net, path);
  const Network<float> read = read_network(path);
  CHECK(read.input_shape() == net.input_shape());
  CHECK(weights_sha256(read) == weights_sha256(net));
  const auto inputs = hashed_values<float>(1, 80);
  CHECK(predict(read, inputs) == predict(net, inputs));
  CHECK(predict(net, inputs).size() == 4);
  CHECK_THROWS_AS(predict(net, std::span(inputs).first(79)), decid::Error);
  std::string bytes = decid::read_file(path);
  bytes.back() ^= 1;
  decid::write_file(path, bytes);
  check_error([&] { read_network(path); }, decid::Code::file_damaged);
  for (const std::string input : {"2,5", "2,5,4,1", "x", "0,5,4", "", "2,5,", ",,", "2,5,4x", "99999999999,1,1"}) {
    TensorFile file = to_tensors(net);
    file.metadata[input_key] = input;
    CHECK_THROWS_AS(from_tensors(std::move(file), "test"), decid::Error);
  }
  const Network<float> tall({1, 1000000, 1}, "conv 1 1x1");
  CHECK(from_tensors(to_tensors(tall), "test").input_shape() == tall.input_shape());
  // 2 GB of weights, of which the file has none: refused by their number, not by the first that is missing.
  TensorFile promised;
  promised.metadata = {{architecture_key, "fc 65536;fc 4096"}, {input_key, "4096,1,1"}};
  check_error([&] { from_tensors(std::move(promised), "test"); }, decid::Code::file_damaged, "536940544");
  // A tensor of a type that no layer has is named, instead of the values that are missing without it.
  TensorFile doubles = to_tensors(net);
  doubles.tensors.erase(doubles.tensors.begin());
  doubles.skipped = {"bn.num_batches_tracked (I64)", "layers.0.weight (F64)"};
  check_error([&] { from_tensors(std::move(doubles), "test"); }, decid::Code::file_unsupported,
              "layers.0.weight (F64)");
  TensorFile without = to_tensors(net);
  CHECK(is_network(without));
  without.metadata.erase(input_key);
  CHECK_FALSE(is_network(without));
  CHECK_THROWS_AS(from_tensors(std::move(without), "test"), decid::Error);
  std::filesystem::remove(path);
}
