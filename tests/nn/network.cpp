// Tests of nn/network.hpp: construction, constness, copies, initialisation, hash.
// Initialisation: He et al., "Delving deep into rectifiers", ICCV 2015; its moments are held to their standard errors.
#include "nn/network.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <type_traits>

#include "tests/near.hpp"
#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

TEST_CASE("Network: parameters and operations") {
  const Network<float> network({2, 110, 110},
                               "conv 8 3x3 pad 1; batchnorm; relu; avgpool 2; conv 16 3x3 pad 1; batchnorm; relu; "
                               "maxpool 2; conv 32 3x3 pad 1; globalavgpool; fc 7");
  CHECK(network.parameter_count() == 2 * 8 * 9 + 8 + 16 + 8 * 16 * 9 + 16 + 32 + 16 * 32 * 9 + 32 + 32 * 7 + 7);
  CHECK(network.output_shape() == Shape{7, 1, 1});
  // Multiply-adds of the convolutions and fc; BatchNorm a multiply-add and ReLU one operation a value; pooling a
  // window's.
  const long long plane1 = 110 * 110, plane2 = 55 * 55, plane3 = 27 * 27;
  CHECK(network.flops() == 2 * plane1 * 8 * 18 + 3 * plane1 * 8 + plane2 * 8 * 4 + 2 * plane2 * 16 * 72 +
                               3 * plane2 * 16 + plane3 * 16 * 4 + 2 * plane3 * 32 * 144 + plane3 * 32 + 2 * 32 * 7);
}

TEST_CASE("parameter_count: of a text, as of the network") {
  for (const char* text : {"conv 8 3x3 pad 1; batchnorm; relu; avgpool 2; fc 7", "conv 6 3x3 groups 2; layernorm; gelu",
                           "residual { conv 2 1x1; concat { tanh } ; conv 2 1x1 }; statspool; fc 3", "maxpool 2"})
    CHECK(parameter_count({2, 8, 8}, text) == Network<float>({2, 8, 8}, text).parameter_count());
  // A terabyte, of which nothing is allocated.
  std::string lines;
  for (int i = 0; i < 1024; ++i) lines += "fc 16384;";
  CHECK(parameter_count({16384, 1, 1}, lines) == 1024ULL * (16384ULL * 16384 + 16384));
  check_error([] { parameter_count({0, 1, 1}, "fc 3"); }, decid::Code::setting_out_of_range);
  check_error([] { parameter_count({1, 1, 1}, "softsign"); }, decid::Code::setting_malformed);
}

TEST_CASE("Network: construction errors") {
  const auto refused = [](Shape shape, const char* text, decid::Code code, const char* fact = "") {
    check_error([&] { Network<float>(shape, text); }, code, fact);
  };
  for (const Shape shape : {Shape{0, 4, 4}, Shape{1, 0, 4}, Shape{1, 4, -1}})
    refused(shape, "fc 3", decid::Code::setting_out_of_range);
  refused({65536, 65536, 65536}, "fc 3", decid::Code::setting_out_of_range, "268435456");
  for (const char* text : {"", " ;\n; ", "relu", "relu; fc 3"})
    refused({1, 4, 4}, text, decid::Code::setting_malformed, "network architecture");
  for (const char* text : {"batchnorm; relu 6; fc 3", "batchnorm; relu relu; maxpool 2; fc 3"})
    refused({1, 4, 4}, text, decid::Code::setting_malformed, "relu");
  refused({1, 4, 4}, "fc 3; maxpool 2", decid::Code::setting_malformed, "' maxpool 2'");
  refused({1, 4, 4}, "fc 3\nconv", decid::Code::setting_malformed, "'conv'");
  // Shapes and the line, counted from 1, of a block that does not fit; a } has no words that say which.
  for (const char* fact : {"layer '}' in line 4", "3 x 2 x 2", "1 x 4 x 4"})
    refused({1, 4, 4}, "tanh; concat { conv 3 3x3 }", decid::Code::setting_malformed, fact);
  refused({1, 4, 4}, "residual { conv 3 1 }", decid::Code::setting_malformed, "3 x 4 x 4");
  refused({1, 4, 4}, "}", decid::Code::setting_malformed, "in line 1");
  // The remedy is the line's own form; a word that is no layer gets all.
  const auto remedy_of = [](const char* text) {
    try {
      Network<float>({1, 4, 4}, text);
    } catch (const decid::Error& error) {
      return error.remedy();
    }
    return std::string("none");
  };
  CHECK(remedy_of("fc 3 4") == "write fc OUTPUTS");
  CHECK(remedy_of("dropout 2") == "write dropout RATE");
  CHECK(remedy_of("softsign").find("statspool, dropout RATE") != std::string::npos);
}

TEST_CASE("Network: a block's brace needs no space, and grouped weights are counted by group") {
  CHECK(Network<float>({1, 4, 4}, "residual{tanh}").architecture() ==
        Network<float>({1, 4, 4}, "residual { tanh }").architecture());
  CHECK(parameter_count({4096, 8, 8}, "conv 4096 5 groups 4096") == 4096 * 25 + 4096);
  check_error(
      [] {
        parameter_count({4096, 8, 8}, "conv 4096 5 groups 1");
      },
      decid::Code::setting_malformed, "419430400");
}

// From a const Network nothing can be reached that could be changed; each of these lines fails to compile if it can.
template <class T>
using ParametersOf = decltype(std::declval<T&>().parameters());
template <class T>
using LayersOf = decltype(std::declval<T&>().layers());
static_assert(std::is_same_v<ParametersOf<const Network<float>>, std::vector<const Parameter<float>*>>);
static_assert(std::is_same_v<ParametersOf<Network<float>>, std::vector<Parameter<float>*>>);
static_assert(std::is_same_v<LayersOf<const Network<float>>, std::span<const Layer<float>>>);
static_assert(std::is_same_v<ParametersOf<const Layer<float>>, std::span<const Parameter<float>>>);
static_assert(std::is_same_v<decltype(std::declval<const Layer<float>&>().statistics()),
                             std::span<const RunningStatistics<float>>>);
static_assert(std::is_same_v<decltype(std::declval<const TensorView<const float>&>().row(0, 0, 0)), const float*>);
static_assert(std::is_same_v<decltype(std::declval<const TensorView<const float>&>().at(0, 0, 0, 0)), const float&>);
static_assert(std::is_same_v<decltype(std::declval<const AlignedBuffer<float>&>().data()), const float*>);
static_assert(std::is_convertible_v<TensorView<float>, TensorView<const float>>);
static_assert(!std::is_convertible_v<TensorView<const float>, TensorView<float>>);
static_assert(!std::is_convertible_v<BlockView<const float>, BlockView<float>>);
static_assert(!std::is_convertible_v<Plane<const float>, Plane<float>>);
template <class View>
concept Loads = requires(const View& view, std::span<const float> values) {
  view.load(0, values);
};
static_assert(Loads<TensorView<float>> && !Loads<TensorView<const float>>);

TEST_CASE("TensorView: a sample outside the batch and a span of another size are refused, and nothing is written") {
  const Shape shape{2, 2, 3};
  std::vector<float> memory(TensorView<float>::required(shape, 17, {1, 1}), 0.5F);
  TensorView<float> view(memory.data(), shape, 17, {1, 1});
  std::vector<float> values(12, 1.0F);
  const auto refused = [&](int sample, std::size_t count) {
    std::vector<float> some(count, 2.0F);
    CHECK_THROWS_AS(view.load(sample, some), decid::Error);
    CHECK_THROWS_AS(view.store(sample, some), decid::Error);
    CHECK_THROWS_AS(TensorView<const float>(view).store(sample, some), decid::Error);
    CHECK(some == std::vector<float>(count, 2.0F));
  };
  for (const int sample : {-1, 17, 31, 32, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()})
    refused(sample, 12);
  for (const std::size_t count : {0U, 11U, 13U}) refused(16, count);
  view.set_batch(3);
  refused(3, 12);  // the memory has room for it, the batch has not
  CHECK(memory == std::vector<float>(memory.size(), 0.5F));
  view.load(2, values);
  std::vector<float> back(12);
  view.store(2, back);
  CHECK(back == values);
}

TEST_CASE("Network: a copy has weights of its own, and parameters stay in their place when it is moved") {
  Network<float> network({2, 8, 8}, "conv 4 3x3 pad 1; batchnorm; fc 3");
  network.initialise(3);
  const std::string sha256 = weights_sha256(network);
  Network<float> copy = network;
  CHECK(weights_sha256(copy) == sha256);
  copy.parameters()[0]->value[0] += 1;
  copy.layers()[1].statistics()[0].value[0] += 1;
  CHECK(weights_sha256(network) == sha256);
  CHECK(weights_sha256(copy) != sha256);
  copy = network;
  CHECK(weights_sha256(copy) == sha256);
  const std::vector<Parameter<float>*> before = network.parameters();
  const Network<float> moved = std::move(network);
  CHECK(weights_sha256(moved) == sha256);
  for (std::size_t k = 0; k < before.size(); ++k) CHECK(moved.parameters()[k] == before[k]);
}

TEST_CASE("Network: He's initialisation") {
  Network<float> network({2, 20, 20}, "conv 32 5x5; batchnorm; conv 32 3x3; fc 40");
  network.initialise(42);
  for (const Parameter<float>* p : network.parameters()) {
    CAPTURE(p->name);
    if (p->name != "weight") {
      for (const float v : p->value) CHECK(v == (p->name == "gamma" ? 1.0f : 0.0f));
      continue;
    }
    const auto count = static_cast<double>(p->value.size());
    REQUIRE(p->fan_in == static_cast<int>(count) / p->shape[0]);
    double sum = 0, squares = 0, fourth = 0;
    for (const float v : p->value) {
      const double z = static_cast<double>(v) * std::sqrt(p->fan_in / 2.0);  // standard normal
      sum += z;
      squares += z * z;
      fourth += z * z * z * z;
    }
    CHECK(std::abs(sum / count) < 4 * std::sqrt(1 / count));
    CHECK(std::abs(squares / count - 1) < 4 * std::sqrt(2 / count));
    CHECK(std::abs(fourth / count - 3) < 4 * std::sqrt(96 / count));
  }
  const std::string sha256 = weights_sha256(network);
  Network<float> other({2, 20, 20}, network.architecture());
  other.initialise(42);
  CHECK(weights_sha256(other) == sha256);
  other.initialise(43);
  CHECK(weights_sha256(other) != sha256);
  // Tensors have numbers of their own, and a precision rounds the same ones.
  CHECK(!decid::test::near(network.parameters()[0]->value[0] / network.parameters()[4]->value[0],
                           std::sqrt(288.0 / 50.0), 1e-3));
  Network<double> precise({2, 20, 20}, network.architecture());
  precise.initialise(42);
  CHECK(static_cast<float>(precise.parameters()[4]->value[7]) == network.parameters()[4]->value[7]);
}

TEST_CASE("weights_sha256: every value, name and shape counts") {
  Network<float> network({1, 4, 4}, "conv 2 3x1; batchnorm; fc 2");
  network.initialise(1);
  const std::string sha256 = weights_sha256(network);
  CHECK(sha256.size() == 64);
  const auto changes = [&](std::vector<float>& values) {
    for (float& v : values) {
      const float kept = v;
      v = std::nextafter(v, 10.0f);
      CHECK(weights_sha256(network) != sha256);
      v = kept;
    }
  };
  for (Parameter<float>* p : network.parameters()) changes(p->value);
  for (Layer<float>& layer : network.layers())
    for (RunningStatistics<float>& s : layer.statistics()) changes(s.value);
  CHECK(weights_sha256(network) == sha256);
  const Network<float> tall({1, 4, 4}, "conv 2 3x1"), wide({1, 4, 4}, "conv 2 1x3");
  CHECK(weights_sha256(tall) != weights_sha256(wide));
}
