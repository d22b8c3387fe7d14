// Architecture lines: the words of a layer's description and the table of layers.
#include "nn/layer.hpp"

#include <charconv>
#include <map>
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
std::unique_ptr<Layer<T>> make_layer(Shape src, const std::string& line) {
  using Maker = std::unique_ptr<Layer<T>> (*)(Shape, Words&);
  static const std::map<std::string, Maker> makers{
      {"conv", make_conv2d<T>},
      {"batchnorm", make_batchnorm<T>},
      {"relu", make_relu<T>},
      {"maxpool", make_max_pool<T>},
      {"avgpool", make_average_pool<T>},
      {"globalavgpool", make_global_average_pool<T>},
      {"fc", make_fully_connected<T>},
  };
  Words words(line);
  const auto maker = makers.find(words.take());
  if (maker == makers.end()) words.fail("is not a layer this program knows");
  auto layer = maker->second(src, words);
  if (!words.done()) words.fail("has '" + words.take() + "' left over");
  const Shape& dst = layer->dst_shape();
  words.limit(static_cast<long long>(dst.rows) * dst.columns * dst.channels, "outputs");
  return layer;
}

template struct Parameter<float>;
template struct Parameter<double>;
template std::unique_ptr<Layer<float>> make_layer(Shape, const std::string&);
template std::unique_ptr<Layer<double>> make_layer(Shape, const std::string&);

}  // namespace decid::nn
