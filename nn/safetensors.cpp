// The safetensors format: see safetensors.hpp.
#include "nn/safetensors.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <iterator>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/files/sha256.hpp"
#include "base/text.hpp"
#include "nn/detail/finite.hpp"

namespace decid::nn {
namespace {

static_assert(std::endian::native == std::endian::little, "values are copied as they lie in memory");
constexpr std::size_t max_header = 100'000'000;  // the format's own limit

constexpr std::uint64_t max_in_tensor = std::uint64_t{1} << 40;

std::size_t value_count(const std::vector<std::uint64_t>& shape, const std::function<void()>& too_large) {
  std::uint64_t count = 1;
  for (const std::uint64_t extent : shape) {
    if (extent > max_in_tensor || (extent > 0 && count > max_in_tensor / extent)) too_large();
    count *= extent;
  }
  return static_cast<std::size_t>(count);
}

/// A list of whole numbers from 0; the JSON library would round fractions and wrap signs.
std::vector<std::uint64_t> whole_numbers(const Json& list, const std::function<void()>& fail) {
  if (!list.is_array()) fail();
  std::vector<std::uint64_t> numbers;
  for (const Json& number : list) {
    if (!number.is_number_unsigned()) fail();
    numbers.push_back(number.get<std::uint64_t>());
  }
  return numbers;
}

/// Bytes of a value of each type that a file may have; 0 for an unknown one.
std::size_t bytes_of(const std::string& type) {
  for (const auto& [bytes, names] : {std::pair<std::size_t, std::string>{1, " BOOL U8 I8 F8_E4M3 F8_E5M2 "},
                                     {2, " F16 BF16 U16 I16 "},
                                     {4, " F32 U32 I32 "},
                                     {8, " F64 U64 I64 "}})
    if (type.find(' ') == std::string::npos && names.find(" " + type + " ") != std::string::npos) return bytes;
  return 0;
}

float from_half(std::uint16_t bits) {
  const std::uint32_t sign = (bits & 0x8000U) << 16U, exponent = (bits >> 10U) & 31U, fraction = bits & 0x3ffU;
  if (exponent == 0) {  // 0, or a number of 2^-24
    const float size = static_cast<float>(fraction) * 0x1p-24F;
    return sign != 0 ? -size : size;
  }
  const std::uint32_t wide = exponent == 31 ? 255 : exponent + 112;
  return std::bit_cast<float>(sign | wide << 23U | fraction << 13U);
}

/// Values of type F32, F16 or BF16.
std::vector<float> values_of(const std::string& type, std::string_view bytes, std::size_t count) {
  std::vector<float> values(count);
  if (type == "F32") {
    if (count > 0) std::memcpy(values.data(), bytes.data(), count * sizeof(float));
    return values;
  }
  for (std::size_t i = 0; i < count; ++i) {
    std::uint16_t bits = 0;
    std::memcpy(&bits, bytes.data() + 2 * i, sizeof bits);
    values[i] = type == "F16" ? from_half(bits) : std::bit_cast<float>(static_cast<std::uint32_t>(bits) << 16U);
  }
  return values;
}

Json parse_header(std::string_view text, const std::function<void(const std::string&)>& fail) {
  if (!text.starts_with('{')) fail("has a header that is no JSON object");
  // The parser would take a zero byte for the end.
  if (text.find('\0') != std::string_view::npos) fail("has a header that is not JSON (a zero byte)");
  Json header;
  try {
    header = parse_json(text, "its header");
  } catch (const Error& error) {
    fail("has a header that cannot be read (" + error.where() + ": " + error.problem() + ")");
  }
  return header;
}

/// Returns the tensor at a place; throws Error for one behind the last, which was not found, or of another size.
const NamedTensor& tensor_at(const TensorFile& file, std::size_t place, const std::string& name, std::size_t count,
                             const std::string& where) {
  if (place >= file.tensors.size()) {
    for (const std::string& other : file.skipped)
      if (other.starts_with(name + " (")) refuse_type(other, where);
    throw Error(Code::file_damaged, where, "holds no tensor '" + name + "'",
                "give a model file written by this version of decid");
  }
  const NamedTensor& found = file.tensors[place];
  if (found.values.size() != count)
    throw Error(Code::file_damaged, where,
                "has " + std::to_string(found.values.size()) + " values in '" + name +
                    "' where the architecture needs " + std::to_string(count),
                "give a model file that was not edited");
  return found;
}

}  // namespace

void refuse_type(const std::string& skipped, const std::string& where) {
  throw Error(Code::file_unsupported, where, "has a tensor of a type that no layer has: " + skipped,
              "store it as F32, F16 or BF16");
}

const NamedTensor& TensorFile::find(const std::string& name, std::size_t count, const std::string& where) const {
  const auto it = std::ranges::find(tensors, name, &NamedTensor::name);
  return tensor_at(*this, static_cast<std::size_t>(it - tensors.begin()), name, count, where);
}

TensorIndex::TensorIndex(const TensorFile& file) : file_(file) {
  for (std::size_t i = 0; i < file.tensors.size(); ++i) places_.emplace(file.tensors[i].name, i);
}

const NamedTensor& TensorIndex::find(const std::string& name, std::size_t count, const std::string& where) const {
  const auto it = places_.find(name);
  return tensor_at(file_, it == places_.end() ? file_.tensors.size() : it->second, name, count, where);
}

std::string content_sha256(const TensorFile& file) {
  Sha256 hash;
  const auto add = [&](const std::string& text) { hash.update(text.c_str(), text.size() + 1); };
  for (const auto& [key, value] : file.metadata) {
    if (key == content_hash_key) continue;
    add(key);
    add(value);
  }
  std::vector<const NamedTensor*> tensors;
  for (const NamedTensor& t : file.tensors) tensors.push_back(&t);
  std::ranges::sort(tensors, {}, &NamedTensor::name);
  for (const NamedTensor* t : tensors) {
    add(t->name);
    add(joined(t->shape, ",", [](long long extent) { return std::to_string(extent); }));
    hash.update(t->values.data(), t->values.size() * sizeof(float));
  }
  return hash.hex();
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
  std::string text;
  try {
    text = header.dump();
  } catch (const Json::exception&) {
    throw Error(Code::setting_malformed, "model", "has metadata or a name that is not UTF-8", "give texts in UTF-8");
  }
  text.resize((text.size() + 7) / 8 * 8, ' ');
  const std::uint64_t length = text.size();
  std::string bytes(sizeof length + text.size() + offset, '\0');
  std::memcpy(bytes.data(), &length, sizeof length);
  std::memcpy(bytes.data() + sizeof length, text.data(), text.size());
  char* out = bytes.data() + sizeof length + text.size();
  for (const NamedTensor& t : file.tensors) {
    if (!t.values.empty()) std::memcpy(out, t.values.data(), t.values.size() * sizeof(float));
    out += t.values.size() * sizeof(float);
  }
  return bytes;
}

TensorFile from_safetensors(std::string_view bytes, const std::string& where) {
  const auto fail = [&](const std::string& problem) {
    throw Error(Code::file_damaged, where, problem, "give a whole safetensors file, as decid train writes it");
  };
  std::uint64_t length = 0;
  if (bytes.size() < sizeof length) fail("is too short (" + std::to_string(bytes.size()) + " bytes) for a model");
  std::memcpy(&length, bytes.data(), sizeof length);
  if (length > max_header) fail("is not a safetensors file");
  if (length > bytes.size() - sizeof length)
    fail("is truncated, or no safetensors file: its header should have " + std::to_string(length) + " bytes");
  const auto header_bytes = static_cast<std::size_t>(length);
  const Json header = parse_header(bytes.substr(sizeof length, header_bytes), fail);
  const std::string_view data = bytes.substr(sizeof length + header_bytes);

  TensorFile file;
  std::vector<std::pair<std::size_t, std::size_t>> ranges;
  try {
    for (const auto& item : header.items()) {
      const std::string& name = item.key();  // clang 14 captures no structured bindings
      const Json& entry = item.value();
      if (name == "__metadata__") {
        file.metadata = entry.get<std::map<std::string, std::string>>();
        continue;
      }
      const auto type = entry.at("dtype").get<std::string>();
      const std::size_t width = bytes_of(type);
      if (width == 0) fail("stores '" + name + "' as " + type + ", not F32, F16 or BF16");
      const auto absurd_shape = [&] { fail("has an absurd shape for '" + name + "'"); };
      const auto shape = whole_numbers(entry.at("shape"), absurd_shape);
      const std::size_t count = value_count(shape, absurd_shape);
      const auto offsets = whole_numbers(entry.at("data_offsets"), [&] { fail("has bad offsets for '" + name + "'"); });
      NamedTensor t{name, {shape.begin(), shape.end()}, {}};
      if (offsets.size() != 2 || offsets[0] > offsets[1] || offsets[1] > data.size())
        fail("is truncated: '" + name + "' lies outside it");
      if (offsets[1] - offsets[0] != count * width) fail("has a shape for '" + name + "' that does not fit its data");
      ranges.emplace_back(offsets[0], offsets[1]);
      if (type != "F32" && type != "F16" && type != "BF16") {
        file.skipped.push_back(name + " (" + type + ")");
        continue;
      }
      t.values = values_of(type, data.substr(static_cast<std::size_t>(offsets[0])), count);
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

namespace {

/// Throws Error for values that no network may have; `name` is the tensor's.
void check_values(const std::vector<float>& values, const std::string& name, bool never_negative,
                  const std::string& where) {
  if (!is_finite(values))
    throw Error(Code::file_damaged, where, "has a value in '" + name + "' that is not finite", "train the model again");
  if (never_negative && std::any_of(values.begin(), values.end(), [](float v) { return v < 0; }))
    throw Error(Code::file_damaged, where, "has a negative value in '" + name + "'", "train the model again");
}

/// Returns "(4, 2, 3, 1)".
template <class Extents>
std::string shape_text(const Extents& shape) {
  return "(" + joined(shape, ", ", [](auto extent) { return std::to_string(extent); }) + ")";
}

/// Returns a shape without its axes of length 1, which other libraries may leave out: as PyTorch's Conv1d.
template <class Extents>
std::vector<long long> without_ones(const Extents& shape) {
  std::vector<long long> rest;
  std::ranges::copy_if(shape, std::back_inserter(rest), [](auto extent) { return extent != 1; });
  return rest;
}

}  // namespace

void save_network(const Network<float>& network, TensorFile& file,
                  const std::vector<std::vector<float>>* momentum_buffers) {
  std::size_t line = 0, parameter = 0;
  std::vector<NamedTensor> tensors;
  const auto add = [&](const std::string& name, std::vector<long long> shape, const std::vector<float>& values,
                       bool never_negative = false) {
    check_values(values, name, never_negative, "network");
    tensors.push_back({name, std::move(shape), values});
  };
  for (const Layer<float>& layer : network.layers()) {
    const std::string index = std::to_string(line) + ".";
    line += layer.lines();
    for (const Parameter<float>& p : layer.parameters()) {
      const std::vector<long long> shape(p.shape.begin(), p.shape.end());
      add("layers." + index + p.name, shape, p.value);
      if (momentum_buffers != nullptr) add("momentum." + index + p.name, shape, momentum_buffers->at(parameter));
      ++parameter;
    }
    for (const RunningStatistics<float>& s : layer.statistics())
      add("layers." + index + s.name, {static_cast<long long>(s.value.size())}, s.value, s.never_negative);
  }
  std::move(tensors.begin(), tensors.end(), std::back_inserter(file.tensors));
}

void load_network(Network<float>& network, TensorFile&& file, const std::string& where,
                  std::vector<std::vector<float>>* momentum_buffers) {
  // All is checked before anything is changed.
  std::vector<std::pair<NamedTensor*, std::vector<float>*>> pairs;
  std::vector<NamedTensor*> found;
  const TensorIndex index_of(file);
  const auto checked = [&](const std::string& name, const std::vector<int>& shape, std::size_t count,
                           bool never_negative = false) -> NamedTensor& {
    auto& t = const_cast<NamedTensor&>(index_of.find(name, count, where));  // file is not const
    if (without_ones(t.shape) != without_ones(shape))
      throw Error(Code::file_damaged, where,
                  "has the shape " + shape_text(t.shape) + " for '" + name + "' where the architecture needs " +
                      shape_text(shape),
                  "store the tensor in this shape; axes of length 1 may be left out");
    check_values(t.values, name, never_negative, where);
    return t;
  };
  std::size_t line = 0;
  for (Layer<float>& layer : network.layers()) {
    const std::string index = std::to_string(line) + ".";
    line += layer.lines();
    for (Parameter<float>& p : layer.parameters()) {
      pairs.emplace_back(&checked("layers." + index + p.name, p.shape, p.value.size()), &p.value);
      if (momentum_buffers != nullptr) found.push_back(&checked("momentum." + index + p.name, p.shape, p.value.size()));
    }
    for (RunningStatistics<float>& s : layer.statistics()) {
      const std::vector<int> shape{static_cast<int>(s.value.size())};
      pairs.emplace_back(&checked("layers." + index + s.name, shape, s.value.size(), s.never_negative), &s.value);
    }
  }
  for (const auto& [tensor, values] : pairs) std::ranges::copy(tensor->values, values->begin());
  if (momentum_buffers == nullptr) return;
  momentum_buffers->clear();
  for (NamedTensor* const tensor : found) momentum_buffers->push_back(std::move(tensor->values));
}

}  // namespace decid::nn
