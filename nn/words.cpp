// The words of a layer's line: see words.hpp.
#include "nn/words.hpp"

#include <algorithm>
#include <sstream>
#include <string_view>

#include "base/error.hpp"
#include "base/number.hpp"
#include "base/text.hpp"
#include "nn/layers/layer.hpp"

namespace decid::nn {
namespace {

constexpr std::size_t max_bytes = 200;  // of a layer's line

/// The forms of decid's own lines, which begin with their words.
constexpr std::string_view forms[] = {"conv CHANNELS RxC [stride RxC] [pad RxC] [groups N] [dilation RxC]",
                                      "batchnorm",
                                      "layernorm",
                                      "relu",
                                      "leakyrelu [SLOPE]",
                                      "gelu",
                                      "tanh",
                                      "sigmoid",
                                      "maxpool RxC [stride RxC] [pad RxC]",
                                      "avgpool RxC [stride RxC] [pad RxC]",
                                      "globalavgpool",
                                      "statspool",
                                      "dropout RATE",
                                      "fc OUTPUTS",
                                      "residual { ... }",
                                      "concat { ... }"};

}  // namespace

Words::Words(const std::string& line, int number) : line_(line), number_(number) {
  if (line.size() > max_bytes)
    throw Error(Code::setting_malformed, "a layer's line",
                "has " + std::to_string(line.size()) + " bytes, more than " + std::to_string(max_bytes),
                "write one layer a line");
  std::istringstream stream(line);
  stream.exceptions(std::ios::badbit);  // without this, text dropped for lack of memory would look like the end
  for (std::string word; stream >> word;) words_.push_back(word);
}

void Words::finish() const {
  if (!done()) fail("has '" + words_[next_] + "' left over");
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

std::pair<int, int> Words::take_pair(int low, int high) {
  const std::string word = take();
  const std::size_t x = word.find('x');
  const int rows = to_int(word.substr(0, x), low, high);
  return {rows, x == std::string::npos ? rows : to_int(word.substr(x + 1), low, high)};
}

double Words::take_number(double low, double high) {
  const std::string word = take();
  const std::optional<double> value = number_from<double>(word);
  if (!value || !(*value >= low && *value <= high))
    fail("'" + word + "' is not a number " + format("from %g to %g", low, high));
  return *value;
}

void Words::fail(const std::string& problem) const {
  const std::string word = words_.empty() ? std::string() : name();
  const auto* const form =
      std::ranges::find(forms, word, [](std::string_view text) { return text.substr(0, text.find(' ')); });
  fail(problem, form == std::end(forms) ? "write the line as its parser reads it" : "write " + std::string(*form));
}

void Words::fail(const std::string& problem, const std::string& remedy) const {
  const std::string place = number_ > 0 ? format(" in line %d", number_) : std::string();
  throw Error(Code::setting_malformed, "layer '" + line_ + "'" + place, problem, remedy);
}

void Words::fail_unknown() const {
  fail("is not a layer this program knows",
       "layers are: " + joined(forms, ", ", [](std::string_view form) { return std::string(form); }));
}

void Words::limit(long long count, const std::string& values) const {
  if (count > max_values)
    fail("has " + std::to_string(count) + " " + values + ", more than " + std::to_string(max_values));
}

int Words::to_int(const std::string& word, int low, int high) const {
  const std::optional<int> value = number_from<int>(word);
  if (!value || *value < low || *value > high)
    fail("'" + word + "' is not a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  return *value;
}

}  // namespace decid::nn
