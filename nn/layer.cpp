// Architecture lines: the words of a layer's description, and which layer they make.
#include "nn/layer.hpp"

#include <algorithm>
#include <charconv>
#include <sstream>

#include "base/error.hpp"
#include "nn/layers.hpp"

namespace decid::nn {

template <class T>
Parameter<T>::Parameter(std::string name_, std::vector<int> shape_, int fan_in_, T initial_, bool decays_)
    : name(std::move(name_)), shape(std::move(shape_)), fan_in(fan_in_), initial(initial_), decays(decays_) {
  std::size_t count = 1;
  for (const int extent : shape) count *= static_cast<std::size_t>(extent);
  value.assign(count, initial);
  gradient.assign(count, T(0));
  velocity.assign(count, T(0));
}

template <class T>
std::size_t Layer<T>::lines() const {
  const std::string all = text();
  return 1 + static_cast<std::size_t>(std::count(all.begin(), all.end(), '\n'));
}

Words::Words(const std::string& line) : line_(line) {
  std::istringstream stream(line);
  for (std::string word; stream >> word;) words_.push_back(word);
}

void Words::fail(const std::string& problem) const {
  throw Error("layer '" + line_ + "'", problem,
              "layers are: conv CHANNELS RxC [stride RxC] [pad RxC], batchnorm, relu, maxpool RxC [stride RxC], "
              "avgpool RxC [stride RxC], globalavgpool, fc OUTPUTS");
}

void Words::limit(long long count, const std::string& what) const {
  if (count > most_values)
    fail("has " + std::to_string(count) + " " + what + ", more than " + std::to_string(most_values));
}

std::string Words::take() {
  if (done()) fail("ends where another word is expected");
  return words_[next_++];
}

bool Words::take_if(const std::string& word) {
  if (done() || words_[next_] != word) return false;
  ++next_;
  return true;
}

void Words::finish() const {
  if (!done()) fail("has '" + words_[next_] + "' left over");
}

int Words::to_int(const std::string& word, int low, int high) const {
  int value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value < low || value > high)
    fail("'" + word + "' is not a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  return value;
}

int Words::take_int(int low, int high) {
  return to_int(take(), low, high);
}

std::pair<int, int> Words::take_pair(int low, int high) {
  const std::string word = take();
  const std::size_t x = word.find('x');
  const int rows = to_int(word.substr(0, x), low, high);
  return {rows, x == std::string::npos ? rows : to_int(word.substr(x + 1), low, high)};
}

template <class T>
std::vector<std::unique_ptr<Layer<T>>> make_layers(Shape src, const std::vector<std::string>& lines) {
  std::vector<std::unique_ptr<Layer<T>>> layers;
  for (std::size_t i = 0; i < lines.size();) {
    Words words(lines[i++]);
    if (words.take_if("conv")) {
      layers.push_back(make_conv2d<T>(src, words));
    } else if (words.take_if("fc")) {
      layers.push_back(make_fully_connected<T>(src, words));
    } else if (words.take_if("relu")) {
      layers.push_back(make_relu<T>(src));
    } else if (words.take_if("batchnorm")) {
      words.finish();
      const bool relu = i < lines.size() && Words(lines[i]).take_if("relu");
      if (relu) words = Words(lines[i++]), words.take();
      std::optional<Pool> pool;
      if (i < lines.size()) {
        Words next(lines[i]);
        pool = parse_pool(src, next);
        if (pool && pool->overlaps()) pool.reset();
        if (pool) words = next, ++i;
      }
      layers.push_back(make_batchnorm<T>(src, relu, pool));
    } else if (const std::optional<Pool> pool = parse_pool(src, words)) {
      layers.push_back(make_pool<T>(*pool));
    } else {
      words.take();
      words.fail("is not a layer this program knows");
    }
    words.finish();
    src = layers.back()->dst_shape();
    words.limit(static_cast<long long>(src.rows) * src.columns * src.channels, "outputs");
  }
  return layers;
}

template class Layer<float>;
template class Layer<double>;
template struct Parameter<float>;
template struct Parameter<double>;
template std::vector<std::unique_ptr<Layer<float>>> make_layers(Shape, const std::vector<std::string>&);
template std::vector<std::unique_ptr<Layer<double>>> make_layers(Shape, const std::vector<std::string>&);

}  // namespace decid::nn
