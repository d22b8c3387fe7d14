// From an architecture's text to its layers: see architecture.hpp.
#include "nn/architecture.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <string_view>

#include "base/error.hpp"
#include "nn/layers/detail/layers.hpp"
#include "nn/words.hpp"

namespace decid::nn {
namespace {

/// As OperationParser, for the kinds of nn/layers/layer.hpp.
using LayerParser = LayerKind (*)(Shape src, Words& words);

/// Returns null for words that are not of these kinds.
LayerParser kind_parser_of(const std::string& word) {
  static const std::map<std::string, LayerParser> all{
      {"conv", parse_conv},    {"fc", parse_fully_connected},        {"batchnorm", parse_batchnorm},
      {"relu", parse_relu},    {"statspool", parse_statistics_pool}, {"maxpool", parse_pool},
      {"avgpool", parse_pool}, {"globalavgpool", parse_pool},        {"residual", parse_block},
      {"concat", parse_block}};
  const auto found = all.find(word);
  return found == all.end() ? nullptr : found->second;
}

/// Returns true for a word as lines begin with it: without the characters at which an architecture's text ends words
/// and lines.
bool is_one_word(const std::string& word) {
  return !word.empty() && std::ranges::none_of(word, [](char c) {
    return static_cast<unsigned char>(c) <= ' ' || std::string_view("#;{}").find(c) != std::string_view::npos;
  });
}

struct Registry {
  std::mutex mutex;
  std::map<std::string, OperationParser> parsers{{"leakyrelu", parse_leaky_relu}, {"tanh", parse_tanh},
                                                 {"sigmoid", parse_sigmoid},      {"gelu", parse_gelu},
                                                 {"layernorm", parse_layernorm},  {"dropout", parse_dropout}};
};
Registry& registry() {
  static Registry all;
  return all;
}

OperationParser parser_of(const std::string& word) {
  const std::lock_guard lock(registry().mutex);
  const auto found = registry().parsers.find(word);
  return found == registry().parsers.end() ? nullptr : found->second;
}

/// Returns true if the same operation is made of its text, which architectures and files have.
bool reads_back(const Operation& operation) {
  const std::string text = operation.text();
  if (text.find_first_of("#;{}\n\r") != std::string::npos) return false;
  try {
    Words words(text);
    const OperationParser parse = words.done() ? nullptr : parser_of(words.take());
    if (parse == nullptr) return false;
    const OperationPointer again = parse(operation.src(), words);
    return words.done() && again != nullptr && again->text() == text && again->dst() == operation.dst();
  } catch (const Error&) {
    return false;
  }
}

/// Makes the layer of a registered parser. Throws Error, naming the line, for an operation that an architecture cannot
/// use.
Extension parse_registered(OperationParser parse, Shape src, Words& words, const std::string& line) {
  const auto fail = [&](const char* problem, const char* remedy) {
    throw Error(Code::setting_malformed, "layer '" + line + "'", problem, remedy);
  };
  OperationPointer made = parse(src, words);
  if (made == nullptr) fail("has a registered parser that returned no operation", "return one, or throw with Words");
  if (made->src() != src)
    fail("has an operation for another input shape than its parser was given", "pass the given shape to Operation");
  const Shape& dst = made->dst();
  if (dst.channels < 1 || dst.rows < 1 || dst.columns < 1)
    fail("has an operation without an output", "give an output of at least 1 channel, 1 row and 1 column");
  if (!reads_back(*made))
    fail("has an operation whose text() is not read back, so that no file of the network could be read",
         "return the complete line from text(): the registered word, then what the parser takes");
  return Extension{std::move(made)};
}

}  // namespace

void register_layer(const std::string& word, OperationParser parser) {
  const auto fail = [&](Code code, const char* problem, const char* remedy) {
    throw Error(code, "layer '" + word + "'", problem, remedy);
  };
  if (parser == nullptr) fail(Code::setting_missing, "is registered without a parser", "give one");
  if (kind_parser_of(word) != nullptr || word == "{" || word == "}")
    fail(Code::setting_conflict, "is one of decid's own", "choose another name");
  if (!is_one_word(word)) fail(Code::setting_malformed, "is not one word", "give a word without spaces, #, ;, { and }");
  const std::lock_guard lock(registry().mutex);
  const auto [place, is_new] = registry().parsers.emplace(word, parser);
  if (!is_new && place->second != parser) fail(Code::setting_conflict, "is registered already", "choose another name");
}

std::vector<LayerKind> parse_layers(Shape src, const std::vector<std::string>& lines) {
  std::vector<LayerKind> layers;
  std::vector<Branch> open;  // whose end is to come
  int number = 0;
  for (const std::string& line : lines) {
    Words words(line, ++number);
    const std::string word = words.take();
    LayerKind kind;
    if (const LayerParser parse_kind = kind_parser_of(word)) {
      kind = parse_kind(src, words);
      if (const auto* branch = std::get_if<Branch>(&kind)) open.push_back(*branch);
    } else if (word == "}") {
      if (open.empty())
        words.fail("ends a block that has no beginning", "begin it with residual { or concat {, or leave out the }");
      kind = end_block(open.back(), src, words);
      open.pop_back();
    } else if (const OperationParser parse = parser_of(word)) {
      kind = parse_registered(parse, src, words, line);
    } else {
      words.fail_unknown();
    }
    words.finish();
    src = std::visit([](const auto& made) { return made.dst(); }, kind);
    words.limit(static_cast<long long>(src.rows) * src.columns * src.channels, "outputs");
    if (layers.empty() || !fuse_with_batchnorm(layers.back(), kind)) layers.push_back(std::move(kind));
  }
  if (!open.empty())
    throw Error(Code::setting_malformed, "network architecture", "has a block without its end",
                "close each { with a line }");
  return layers;
}

template <class T>
std::vector<Layer<T>> make_layers(Shape src, const std::vector<std::string>& lines) {
  std::vector<Layer<T>> layers;
  for (const LayerKind& kind : parse_layers(src, lines)) layers.emplace_back(kind);
  return layers;
}

template std::vector<Layer<float>> make_layers(Shape, const std::vector<std::string>&);
template std::vector<Layer<double>> make_layers(Shape, const std::vector<std::string>&);

}  // namespace decid::nn
