// A chain of layers: construction from text, initialisation, hash.
#include "nn/network.hpp"

#include <bit>
#include <cmath>
#include <sstream>

#include "base/error.hpp"
#include "base/files/sha256.hpp"
#include "base/math/random.hpp"
#include "base/text.hpp"
#include "nn/architecture.hpp"

namespace decid::nn {
namespace {

void check_input(Shape input) {
  if (input.channels < 1 || input.rows < 1 || input.columns < 1)
    throw Error(Code::setting_out_of_range, "network input", "has no values",
                "give at least 1 channel, 1 row and 1 column");
  if (input.channels > max_values / input.rows / input.columns)
    throw Error(Code::setting_out_of_range, "network input",
                "has more than " + std::to_string(max_values) + " values a sample", "give fewer");
}

/// Lines end at ; too, # begins a comment, and a block's braces end lines.
std::vector<std::string> lines_of(const std::string& architecture) {
  std::string lines;
  bool comments = false;
  for (const char c : architecture) {
    comments = c != '\n' && (comments || c == '#');
    if (comments) continue;
    if (c == '}') lines += '\n';
    if (c == '{') lines += ' ';  // residual{ is residual {
    lines += c == ';' ? '\n' : c;
    if (c == '{' || c == '}') lines += '\n';
  }
  std::istringstream stream(lines);
  stream.exceptions(std::ios::badbit);  // without this, text dropped for lack of memory would look like the end
  std::vector<std::string> wanted;
  for (std::string line; std::getline(stream, line);)
    if (line.find_first_not_of(" \t\r") != std::string::npos) wanted.push_back(line);
  return wanted;
}

}  // namespace

template <class T>
Network<T>::Network(Shape input, const std::string& architecture) : input_shape_(input) {
  check_input(input);
  layers_ = make_layers<T>(input, lines_of(architecture));
  if (layers_.empty() || std::holds_alternative<Relu>(layers_.front().kind()))
    throw Error(Code::setting_malformed, "network architecture", "does not begin with a layer that computes",
                "start with conv or fc");
}

std::size_t parameter_count(Shape input, const std::string& architecture) {
  check_input(input);
  std::size_t count = 0;
  for (const LayerKind& kind : parse_layers(input, lines_of(architecture))) count += parameter_count(kind);
  return count;
}

template <class T>
std::string Network<T>::architecture() const {
  return joined(layers_, "\n", &Layer<T>::text);
}

template <class T>
std::vector<Parameter<T>*> Network<T>::parameters() {
  std::vector<Parameter<T>*> all;
  for (Layer<T>& layer : layers_)
    for (Parameter<T>& p : layer.parameters()) all.push_back(&p);
  return all;
}

template <class T>
std::vector<const Parameter<T>*> Network<T>::parameters() const {
  std::vector<const Parameter<T>*> all;
  for (const Layer<T>& layer : layers_)
    for (const Parameter<T>& p : layer.parameters()) all.push_back(&p);
  return all;
}

template <class T>
std::size_t Network<T>::parameter_count() const {
  std::size_t count = 0;
  for (const Parameter<T>* p : parameters()) count += p->value.size();
  return count;
}

template <class T>
long long Network<T>::flops() const {
  long long sum = 0;
  for (const Layer<T>& layer : layers_) sum += layer.flops();
  return sum;
}

template <class T>
void Network<T>::initialise(std::uint64_t seed) {
  std::uint64_t item = 0;
  for (Parameter<T>* p : parameters()) {
    const Random random(seed, Stream::weights, item++);
    const double stddev = p->fan_in > 0 ? std::sqrt(2.0 / p->fan_in) : 0.0;
    for (std::size_t i = 0; i < p->value.size(); ++i)
      p->value[i] = p->fan_in > 0 ? static_cast<T>(stddev * random.normal(i)) : p->initial;
  }
  for (Layer<T>& layer : layers_)
    for (RunningStatistics<T>& s : layer.statistics()) s.value.assign(s.value.size(), s.initial);
}

std::string weights_sha256(const Network<float>& network) {
  static_assert(std::endian::native == std::endian::little, "values are hashed as they lie in memory");
  Sha256 hash;
  const auto add = [&](const std::string& name, const std::vector<int>& shape, const std::vector<float>& values) {
    std::string header = name + ":";
    for (const int extent : shape) header += std::to_string(extent) + ",";
    header += ";";
    hash.update(header.data(), header.size());
    hash.update(values.data(), values.size() * sizeof(float));
  };
  std::size_t line = 0;
  for (const Layer<float>& layer : network.layers()) {
    const std::string prefix = std::to_string(line) + ".";
    for (const Parameter<float>& p : layer.parameters()) add(prefix + p.name, p.shape, p.value);
    for (const RunningStatistics<float>& s : layer.statistics())
      add(prefix + s.name, {static_cast<int>(s.value.size())}, s.value);
    line += layer.lines();
  }
  return hash.hex();
}

template class Network<float>;
template class Network<double>;

}  // namespace decid::nn
