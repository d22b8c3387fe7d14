// Tests of nn/safetensors.hpp: the bytes against the format's description, round trips, and what must be refused.
// Format: https://github.com/huggingface/safetensors, README, section "Format".
#include "nn/safetensors.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>

#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

namespace {

/// A file by hand: header length, header, values.
std::string file_of(const std::string& header, const std::string& data = std::string(8, '\0')) {
  const std::uint64_t length = header.size();
  std::string bytes(8, '\0');
  std::memcpy(bytes.data(), &length, 8);
  return bytes + header + data;
}

void refused(std::string_view bytes, const std::string& fact) {
  check_error([&] { from_safetensors(bytes, "m.safetensors"); }, decid::Code::file_damaged, fact);
}

using Buffers = std::vector<std::vector<float>>;

/// A network and the momentum buffers of its training.
struct Trained {
  Network<float> network{{1, 4, 4}, "conv 2 3x3 pad 1; batchnorm; relu; fc 3"};
  Buffers momentum_buffers;
};
Trained trained() {
  Trained made;
  made.network.initialise(3);
  std::uint32_t id = 1;
  for (Parameter<float>* p : made.network.parameters()) {
    made.momentum_buffers.push_back(hashed_values<float>(id, p->value.size()));
    p->value = hashed_values<float>(++id, p->value.size());
  }
  for (RunningStatistics<float>& s : made.network.layers()[1].statistics())
    s.value = hashed_values<float>(++id, 2, 0.4, 1.0);
  return made;
}

TensorFile small_file() {
  TensorFile file;
  file.metadata = {{"key", "value"}};
  file.tensors = {{"a", {2}, {1.0f, -2.0f}}, {"b", {1, 1}, {0.5f}}};
  return file;
}

}  // namespace

TEST_CASE("safetensors: byte layout") {
  const std::string bytes = to_safetensors(small_file());
  const std::string header = R"({"__metadata__":{"key":"value"},"a":{"dtype":"F32","shape":[2],"data_offsets":[0,8]},)"
                             R"("b":{"dtype":"F32","shape":[1,1],"data_offsets":[8,12]}})";
  const std::size_t padded = (header.size() + 7) / 8 * 8;
  REQUIRE(bytes.size() == 8 + padded + 12);
  for (std::size_t i = 0; i < 8; ++i)
    CHECK(static_cast<unsigned char>(bytes[i]) == (padded >> (8 * i) & 0xff));  // little-endian
  CHECK(bytes.substr(8, padded) == header + std::string(padded - header.size(), ' '));
  const unsigned char data[12] = {0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0, 0, 0, 0, 0x3f};
  CHECK(std::memcmp(bytes.data() + 8 + padded, data, 12) == 0);
}

TEST_CASE("safetensors: a file by hand is read") {
  const TensorFile file = from_safetensors(
      file_of("{\"b\":{\"shape\":[],\"data_offsets\":[4,8],\"dtype\":\"F32\"},\"none\":{\"dtype\":\"F32\",\"shape\":[3,"
              "0],\"data_offsets\":[4,4]},\"\\u00e4\":{\"dtype\":\"F32\",\"shape\":[1],\"data_offsets\":[0,4]}}   ",
              std::string("\0\0\x80\x3f\0\0\0\xc0", 8)),
      "m");
  REQUIRE(file.tensors.size() == 3);
  CHECK(file.metadata.empty());
  CHECK(file.find("b", 1, "m").values[0] == -2.0f);
  CHECK(file.find("b", 1, "m").shape.empty());
  CHECK(file.find("none", 0, "m").shape == std::vector<long long>{3, 0});
  CHECK(file.find("\xc3\xa4", 1, "m").values[0] == 1.0f);
  CHECK(from_safetensors(file_of("{}", ""), "m").tensors.empty());
}

TEST_CASE("safetensors: round trip of values, shapes, names, metadata") {
  TensorFile file;
  file.metadata = {{"author", "Zoë Müller, 東京 \"q\" \\ \n\t\x01"}, {"", "empty key"}, {"e", ""}, {"snow", "☃ 🂡"}};
  const float infinity = std::numeric_limits<float>::infinity();
  file.tensors = {{"z", {2, 3}, {0.0f, -0.0f, 1e-45f, 3.4028235e38f, infinity, -infinity}},
                  {"größe", {1}, {std::bit_cast<float>(0x7fc12345u)}},
                  {"empty", {0, 5}, {}},
                  {"a\"b", {}, {7.25f}}};
  const std::string bytes = to_safetensors(file);
  const TensorFile back = from_safetensors(bytes, "m");
  CHECK(back.metadata == file.metadata);
  REQUIRE(back.tensors.size() == file.tensors.size());
  for (std::size_t i = 0; i < file.tensors.size(); ++i) {
    CHECK(back.tensors[i].name == file.tensors[i].name);
    CHECK(back.tensors[i].shape == file.tensors[i].shape);
    CHECK(same_bits(back.tensors[i].values, file.tensors[i].values));
  }
  CHECK(to_safetensors(back) == bytes);
  file.metadata["bad"] = "\xff\xfe";
  check_error([&] { to_safetensors(file); }, decid::Code::setting_malformed, "UTF-8");
}

TEST_CASE("safetensors: a network returns to the bit, running statistics and momentum too") {
  const auto [network, momentum_buffers] = trained();
  TensorFile file;
  save_network(network, file, &momentum_buffers);
  REQUIRE(file.tensors.size() == 6 * 2 + 2);
  CHECK(file.find("layers.0.weight", 18, "m").shape == std::vector<long long>{2, 1, 3, 3});
  CHECK(file.find("layers.3.weight", 96, "m").shape == std::vector<long long>{3, 32});
  CHECK(file.find("layers.1.running_variance", 2, "m").shape == std::vector<long long>{2});
  CHECK(same_bits(file.find("momentum.1.gamma", 2, "m").values, momentum_buffers[2]));

  const std::string bytes = to_safetensors(file);
  Network<float> other({1, 4, 4}, network.architecture());
  Buffers other_buffers;
  const float* const place = other.parameters()[0]->value.data();
  load_network(other, from_safetensors(bytes, "m"), "m", &other_buffers);
  CHECK(other.parameters()[0]->value.data() == place);  // arrays of Python are views of it
  CHECK(weights_sha256(other) == weights_sha256(network));
  REQUIRE(other_buffers.size() == network.parameters().size());
  for (std::size_t k = 0; k < network.parameters().size(); ++k) {
    CHECK(same_bits(other.parameters()[k]->value, network.parameters()[k]->value));
    CHECK(same_bits(other_buffers[k], momentum_buffers[k]));
  }
  for (std::size_t k = 0; k < 2; ++k)
    CHECK(same_bits(other.layers()[1].statistics()[k].value, network.layers()[1].statistics()[k].value));
  TensorFile again;
  save_network(other, again, &other_buffers);
  CHECK(to_safetensors(again) == bytes);

  Network<float> fresh({1, 4, 4}, network.architecture());
  load_network(fresh, std::move(file), "m");  // without momentum
  CHECK(weights_sha256(fresh) == weights_sha256(network));
}

TEST_CASE("safetensors: load_network refuses what does not fit, and changes nothing then") {
  const auto [source, momentum_buffers] = trained();
  Network<float> network({1, 4, 4}, source.architecture());
  const std::string before = weights_sha256(network);
  TensorFile whole;
  save_network(source, whole, &momentum_buffers);
  const auto refuses = [&](const std::string& fact, const auto& change, bool momentum = false) {
    TensorFile file = whole;
    change(file);
    Buffers found{{7.0F}};
    check_error([&] { load_network(network, std::move(file), "m", momentum ? &found : nullptr); },
                decid::Code::file_damaged, fact);
    CHECK(weights_sha256(network) == before);
    CHECK(found == Buffers{{7.0F}});
  };
  for (std::size_t i = 0; i < whole.tensors.size(); ++i)
    refuses(
        "'" + whole.tensors[i].name + "'",
        [&](TensorFile& f) { f.tensors.erase(f.tensors.begin() + static_cast<std::ptrdiff_t>(i)); }, true);
  refuses("17 values in 'layers.0.weight'", [](TensorFile& f) { f.tensors[0].values.pop_back(); });
  for (const std::vector<long long>& shape : {std::vector<long long>{3, 2, 3}, {18}})
    refuses("for 'layers.0.weight' where the architecture needs (2, 1, 3, 3)",
            [&](TensorFile& f) { f.tensors[0].shape = shape; });
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    refuses("'layers.0.weight'", [&](TensorFile& f) { f.tensors[0].values[17] = bad; });
    refuses(
        "'momentum.3.bias'", [&](TensorFile& f) { f.tensors.back().values[0] = -bad; }, true);
  }
  const auto variance = std::ranges::find(whole.tensors, "layers.1.running_variance", &NamedTensor::name);
  REQUIRE(variance != whole.tensors.end());
  const auto place = static_cast<std::size_t>(variance - whole.tensors.begin());
  refuses("'layers.1.running_variance'", [&](TensorFile& f) { f.tensors[place].values[0] = -0.1F; });
}

// PyTorch's Conv1d has no axis for the columns.
TEST_CASE("safetensors: a tensor's axes of length 1 may be left out") {
  const auto [source, momentum_buffers] = trained();
  for (const std::vector<long long>& shape : {std::vector<long long>{2, 3, 3}, {2, 3, 1, 3}}) {
    Network<float> network({1, 4, 4}, source.architecture());
    TensorFile file;
    save_network(source, file);
    file.tensors[0].shape = shape;
    load_network(network, std::move(file), "m");
    CHECK(weights_sha256(network) == weights_sha256(source));
  }
}

TEST_CASE("safetensors: save_network refuses what load_network refuses, and adds nothing then") {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  const auto refuses = [](const char* fact, const auto& change) {
    Trained made = trained();
    change(made);
    TensorFile file = small_file();
    check_error([&] { save_network(made.network, file, &made.momentum_buffers); }, decid::Code::file_damaged, fact);
    CHECK(file.tensors.size() == 2);
  };
  for (const float bad : {nan, infinity, -infinity}) {
    refuses("'layers.0.weight'", [&](Trained& t) { t.network.parameters()[0]->value[17] = bad; });
    refuses("'layers.1.running_mean'", [&](Trained& t) { t.network.layers()[1].statistics()[0].value[1] = bad; });
    refuses("'momentum.3.bias'", [&](Trained& t) { t.momentum_buffers.back()[2] = bad; });
  }
  refuses("'layers.1.running_variance'", [](Trained& t) { t.network.layers()[1].statistics()[1].value[0] = -0.1F; });
}

TEST_CASE("safetensors: truncation at every byte is refused") {
  TensorFile file;
  save_network(trained().network, file);
  const std::string bytes = to_safetensors(file);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    refused(std::string_view(bytes).substr(0, size), "m.safetensors");
  refused(bytes + '\0', "1 bytes that belong to no tensor");
  refused(bytes + std::string(1000, 'x'), "1000 bytes that belong to no tensor");
}

TEST_CASE("safetensors: F16 and BF16 are read, tensors of other types are skipped by name") {
  // 1.5, -2^-24 (the smallest), 65504 (the largest), infinity; then 1.5, -2, 2^-126, 0; then a count.
  const std::uint16_t bits[] = {0x3e00, 0x8001, 0x7bff, 0x7c00, 0x3fc0, 0xc000, 0x0080, 0x0000};
  std::string data(reinterpret_cast<const char*>(bits), sizeof bits);
  const std::string header =
      R"({"half":{"dtype":"F16","shape":[2,2],"data_offsets":[0,8]},"brain":{"dtype":"BF16","shape":[4],)"
      R"("data_offsets":[8,16]},"bn.num_batches_tracked":{"dtype":"I64","shape":[],"data_offsets":[16,24]}})";
  const std::uint64_t length = header.size();
  const std::string bytes =
      std::string(reinterpret_cast<const char*>(&length), sizeof length) + header + data + std::string(8, '\0');
  const TensorFile file = from_safetensors(bytes, "test");
  CHECK(file.find("half", 4, "test").values ==
        std::vector<float>{1.5F, -0x1p-24F, 65504.0F, std::numeric_limits<float>::infinity()});
  CHECK(file.find("brain", 4, "test").values == std::vector<float>{1.5F, -2.0F, 0x1p-126F, 0.0F});
  CHECK(file.tensors.size() == 2);
  CHECK(file.skipped == std::vector<std::string>{"bn.num_batches_tracked (I64)"});
  check_error([&] { file.find("bn.num_batches_tracked", 1, "test"); }, decid::Code::file_unsupported);
  const TensorIndex index(file);
  CHECK(&index.find("brain", 4, "test") == &file.find("brain", 4, "test"));
  check_error([&] { index.find("bn.num_batches_tracked", 1, "test"); }, decid::Code::file_unsupported);
  check_error([&] { index.find("bra", 4, "test"); }, decid::Code::file_damaged);
  check_error([&] { index.find("half", 3, "test"); }, decid::Code::file_damaged);
}

TEST_CASE("safetensors: headers that are refused") {
  const auto entry = [](const std::string& rest) { return file_of("{\"a\":" + rest + "}"); };
  const auto of = [&](const std::string& shape, const std::string& offsets) {
    return entry("{\"dtype\":\"F32\",\"shape\":" + shape + ",\"data_offsets\":" + offsets + "}");
  };
  CHECK_NOTHROW(from_safetensors(of("[2]", "[0,8]"), "m"));
  CHECK_NOTHROW(from_safetensors(of("[1,2,1]", "[0,8]"), "m"));

  for (const char* shape : {"[-2]", "[-1,-2]", "[1.0,2]", "[2.5]", "[true,2]", "[\"2\"]", "[null]", "[[]]", "2", "{}",
                            "[18446744073709551615]", "[9223372036854775808,2]", "[4294967296,4294967296]",
                            "[1099511627777]", "[0,18446744073709551615]", "[1e300]", "null"})
    refused(of(shape, "[0,8]"), "has an absurd shape for 'a'");
  for (const char* shape : {"[1]", "[3]", "[]", "[0]", "[2,2]", "[1099511627776]"})
    refused(of(shape, "[0,8]"), "has a shape for 'a' that does not fit its data");
  for (const char* offsets : {"[-8,0]", "[0,8.0]", "[0.0,8]", "[0,1e300]", "[false,8]", "{}", "8", "\"0,8\""})
    refused(of("[2]", offsets), "has bad offsets for 'a'");
  for (const char* offsets :
       {"[]", "[8]", "[0,8,8]", "[8,0]", "[0,9]", "[4,12]", "[18446744073709551608,0]", "[0,18446744073709551615]"})
    refused(of("[2]", offsets), "'a' lies outside it");
  refused(of("[1]", "[0,4]"), "has 4 bytes that belong to no tensor");
  refused(of("[1]", "[4,8]"), "has a gap or an overlap at byte 4");

  for (const char* type : {"F4", "I128", "f32", "", " ", "F16 BF16"})
    refused(entry(std::string("{\"dtype\":\"") + type + "\",\"shape\":[2],\"data_offsets\":[0,8]}"),
            std::string("stores 'a' as ") + type + ", not F32");
  const std::string good = R"({"dtype":"F32","shape":[2],"data_offsets":[0,8]})";
  for (const char* bad :
       {"3", "[]", "null", "{}", R"({"dtype":"F32"})", R"({"shape":[2],"data_offsets":[0,8]})",
        R"({"dtype":"F32","data_offsets":[0,8]})", R"({"dtype":"F32","shape":[2]})",
        R"({"dtype":1,"shape":[2],"data_offsets":[0,8]})", R"({"dtype":["F32"],"shape":[2],"data_offsets":[0,8]})"})
    refused(entry(bad), "has a header of another form");
  const auto pair = [&](const std::string& b, const std::string& name = "b") {
    return file_of(R"({"a":{"dtype":"F32","shape":[1],"data_offsets":[0,4]},")" + name +
                   R"(":{"dtype":"F32","shape":[1],"data_offsets":)" + b + "}}");
  };
  CHECK_NOTHROW(from_safetensors(pair("[4,8]"), "m"));
  refused(pair("[0,4]"), "has a gap or an overlap at byte 0");
  refused(pair("[2,6]"), "has a gap or an overlap at byte 2");
  refused(pair("[4,8]", "a"), "'a' is repeated");
  refused(pair("[4,8]", "\\u0061"), "'a' is repeated");
  refused(entry(R"({"dtype":"F32","dtype":"F32","shape":[2],"data_offsets":[0,8]})"), "'dtype' is repeated");
  refused(file_of("{\"__metadata__\":{\"k\":\"1\",\"k\":\"2\"},\"a\":" + good + "}"), "'k' is repeated");
  for (const char* metadata : {"3", "[]", "null", "\"x\"", "{\"k\":1}", "{\"k\":null}", "{\"k\":[\"v\"]}"})
    refused(file_of(std::string("{\"__metadata__\":") + metadata + ",\"a\":" + good + "}"), "of another form");

  for (const char* text : {"", " ", "[]", "null", "3", "\"a\"", " {}", "\n{}", "\xef\xbb\xbf{}"})
    refused(file_of(text, ""), "has a header that is no JSON object");
  for (const char* text : {"{", "{]", "{}x", "{} {}", "{\"a\"}", "{'a':1}", "{\"a\":1,}", "{\"\xff\":1}", "{\"a\":nan}",
                           "{\"a\":1e999}", "{\"a\":01}", "{/**/}"})
    refused(file_of(text, ""), "not valid JSON");
  refused(file_of(std::string("{}\0", 3), ""), "not JSON");
  refused(file_of("{\"a\":" + std::string(100'000, '[')), "deeper than 32 levels");
}

TEST_CASE("safetensors: header lengths that are refused") {
  std::string bytes = to_safetensors(small_file());
  for (const std::uint64_t length :
       {bytes.size() - 7, std::size_t{100'000'000}, std::size_t{100'000'001}, std::size_t{1} << 63, ~std::size_t{0}}) {
    std::memcpy(bytes.data(), &length, 8);
    // The error does not show an impossible length as a length.
    refused(bytes, length <= 100'000'000 ? "its header should have " + std::to_string(length) + " bytes"
                                         : "is not a safetensors file");
  }
}

TEST_CASE("safetensors: only Error comes out of 2,000 mutated files") {
  const auto [network, momentum_buffers] = trained();
  TensorFile file;
  file.metadata = {{"architecture", network.architecture()}};
  save_network(network, file, &momentum_buffers);
  const std::string whole = to_safetensors(file);
  std::uint64_t header = 0;
  std::memcpy(&header, whole.data(), 8);
  const auto below = [](std::uint32_t id, std::size_t index, std::size_t bound) {
    return static_cast<std::size_t>((hashed(id, index) + 1) / 2 * static_cast<double>(bound));
  };
  int errors = 0, accepted = 0;
  Network<float> other({1, 4, 4}, network.architecture());
  Buffers other_buffers;
  for (std::size_t k = 0; k < 2000; ++k) {
    std::string bytes = whole;
    // Mostly in the header, where bytes have meaning: bits, digits and brackets, pieces removed, doubled or moved.
    for (std::size_t m = 0; m <= k % 3; ++m) {
      const std::size_t range = k % 5 == 0 ? bytes.size() : std::min<std::size_t>(header + 8, bytes.size());
      if (range == 0) break;
      const auto draw = static_cast<std::uint32_t>(10 * m);
      const std::size_t at = below(draw, k, range), length = 1 + below(draw + 1, k, 40);
      switch (below(draw + 2, k, 5)) {
        case 0:
          bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(draw + 3, k, 8)));
          break;
        case 1:
          bytes[at] = "0123456789-[]{}\":,.e"[below(draw + 3, k, 20)];
          break;
        case 2:
          bytes.erase(at, length);
          break;
        case 3:
          bytes.insert(at, bytes.substr(at, length));
          break;
        default:
          bytes.insert(below(draw + 3, k, range), bytes.substr(at, length));
      }
    }
    try {
      load_network(other, from_safetensors(bytes, "m"), "m", &other_buffers);
      ++accepted;
    } catch (const decid::Error&) {
      ++errors;
    }  // anything else ends the test
  }
  CHECK(errors + accepted == 2000);
  CHECK(errors > 1500);
  CHECK(accepted > 20);  // values changed, and nothing else: the mutations reach beyond the header's length
}
