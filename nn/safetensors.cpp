// The safetensors format: see safetensors.hpp.
#include "nn/safetensors.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>

#include "base/error.hpp"

namespace decid::nn {
namespace {

static_assert(std::endian::native == std::endian::little, "values are copied as they lie in memory");
using Json = nlohmann::ordered_json;

constexpr std::size_t largest_header = 100'000'000;  // the format's own limit

std::size_t value_count(const std::vector<long long>& shape, const std::function<void()>& too_large) {
  std::size_t count = 1;
  for (const long long extent : shape) {
    if (extent < 0 || (extent > 0 && count > (std::size_t{1} << 40) / static_cast<std::size_t>(extent))) too_large();
    count *= static_cast<std::size_t>(extent);
  }
  return count;
}

/// Refuses keys given twice, which the JSON parser would let pass.
Json parse_header(std::string_view text, const std::function<void(const std::string&)>& fail) {
  std::vector<std::set<std::string>> keys;
  std::string repeated;
  const auto watch = [&](int, Json::parse_event_t event, Json& value) {
    if (event == Json::parse_event_t::object_start) keys.emplace_back();
    if (event == Json::parse_event_t::object_end) keys.pop_back();
    if (event == Json::parse_event_t::key && !keys.back().insert(value.get<std::string>()).second)
      repeated = value.get<std::string>();
    return true;
  };
  Json header;
  try {
    header = Json::parse(text, watch);
  } catch (const Json::exception& error) {
    fail(std::string("has a header that is not JSON (") + error.what() + ")");
  }
  if (!repeated.empty()) fail("names '" + repeated + "' twice");
  if (!header.is_object()) fail("has a header that is no JSON object");
  return header;
}

}  // namespace

const NamedTensor& TensorFile::find(const std::string& name, std::size_t count, const std::string& where) const {
  const auto it = std::find_if(tensors.begin(), tensors.end(), [&](const NamedTensor& t) { return t.name == name; });
  if (it == tensors.end())
    throw Error(where, "holds no tensor '" + name + "'", "give a model file written by this version of decid");
  if (it->values.size() != count)
    throw Error(where,
                "has " + std::to_string(it->values.size()) + " values in '" + name + "' where the architecture needs " +
                    std::to_string(count),
                "give a model file that was not edited");
  return *it;
}

std::string to_safetensors(const TensorFile& file) {
  Json header = Json::object();
  if (!file.metadata.empty()) header["__metadata__"] = file.metadata;
  std::size_t offset = 0;
  for (const NamedTensor& t : file.tensors) {
    const std::size_t bytes = t.values.size() * sizeof(float);
    header[t.name] = {{"dtype", "F32"}, {"shape", t.shape}, {"data_offsets", {offset, offset + bytes}}};
    offset += bytes;
  }
  std::string text = header.dump();
  text.resize((text.size() + 7) / 8 * 8, ' ');
  const std::uint64_t length = text.size();
  std::string bytes(sizeof length + text.size() + offset, '\0');
  std::memcpy(bytes.data(), &length, sizeof length);
  std::memcpy(bytes.data() + sizeof length, text.data(), text.size());
  char* out = bytes.data() + sizeof length + text.size();
  for (const NamedTensor& t : file.tensors) {
    std::memcpy(out, t.values.data(), t.values.size() * sizeof(float));
    out += t.values.size() * sizeof(float);
  }
  return bytes;
}

TensorFile from_safetensors(std::string_view bytes, const std::string& where) {
  const auto fail = [&](const std::string& problem) {
    throw Error(where, problem, "give a whole safetensors file, as decid train writes it");
  };
  std::uint64_t length = 0;
  if (bytes.size() < sizeof length) fail("is too short (" + std::to_string(bytes.size()) + " bytes) for a model");
  std::memcpy(&length, bytes.data(), sizeof length);
  if (length > largest_header || length > bytes.size() - sizeof length)
    fail("is truncated, or no safetensors file: its header should have " + std::to_string(length) + " bytes");
  const Json header = parse_header(bytes.substr(sizeof length, length), fail);
  const std::string_view data = bytes.substr(sizeof length + length);

  TensorFile file;
  std::vector<std::pair<std::size_t, std::size_t>> ranges;
  try {
    for (const auto& [name, entry] : header.items()) {
      if (name == "__metadata__") {
        file.metadata = entry.get<std::map<std::string, std::string>>();
        continue;
      }
      if (entry.at("dtype") != "F32") fail("stores '" + name + "' as " + entry.at("dtype").dump() + ", not F32");
      NamedTensor t{name, entry.at("shape").get<std::vector<long long>>(), {}};
      const auto offsets = entry.at("data_offsets").get<std::vector<std::size_t>>();
      const std::size_t count = value_count(t.shape, [&] { fail("has an absurd shape for '" + name + "'"); });
      if (offsets.size() != 2 || offsets[0] > offsets[1] || offsets[1] > data.size())
        fail("is truncated: '" + name + "' lies outside it");
      if (offsets[1] - offsets[0] != count * sizeof(float))
        fail("has a shape for '" + name + "' that does not fit its data");
      ranges.emplace_back(offsets[0], offsets[1]);
      t.values.resize(count);
      std::memcpy(t.values.data(), data.data() + offsets[0], count * sizeof(float));
      file.tensors.push_back(std::move(t));
    }
  } catch (const Json::exception& error) {
    fail(std::string("has a header of another form (") + error.what() + ")");
  }
  std::sort(ranges.begin(), ranges.end());
  std::size_t end = 0;
  for (const auto& [first, last] : ranges) {
    if (first != end) fail("has a gap or an overlap at byte " + std::to_string(first) + " of its data");
    end = last;
  }
  if (end != data.size()) fail("has " + std::to_string(data.size() - end) + " bytes that belong to no tensor");
  return file;
}

void save_network(const Network<float>& network, TensorFile& file, bool momentum) {
  for (std::size_t i = 0; i < network.layers().size(); ++i) {
    const std::string index = std::to_string(i) + ".";
    for (const Parameter<float>* p : network.layers()[i]->parameters()) {
      const std::vector<long long> shape(p->shape.begin(), p->shape.end());
      file.tensors.push_back({"layers." + index + p->name, shape, p->value});
      if (momentum) file.tensors.push_back({"momentum." + index + p->name, shape, p->velocity});
    }
    for (const Statistic<float>* s : network.layers()[i]->statistics())
      file.tensors.push_back({"layers." + index + s->name, {static_cast<long long>(s->value.size())}, s->value});
  }
}

void load_network(const Network<float>& network, const TensorFile& file, const std::string& where, bool momentum) {
  const auto load = [&](const std::string& name, std::vector<float>& values) {
    const NamedTensor& t = file.find(name, values.size(), where);
    for (const float v : t.values)
      if (!std::isfinite(v))
        throw Error(where, "has a value in '" + name + "' that is not finite", "train the model again");
    values = t.values;
  };
  for (std::size_t i = 0; i < network.layers().size(); ++i) {
    const std::string index = std::to_string(i) + ".";
    for (Parameter<float>* p : network.layers()[i]->parameters()) {
      load("layers." + index + p->name, p->value);
      if (momentum) load("momentum." + index + p->name, p->velocity);
    }
    for (Statistic<float>* s : network.layers()[i]->statistics()) load("layers." + index + s->name, s->value);
  }
}

}  // namespace decid::nn
