// From an architecture's text to its layers: see architecture.hpp.
#include "nn/architecture.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <string_view>
#include <tuple>

#include "base/error.hpp"
#include "nn/layers/detail/layers.hpp"
#include "nn/words.hpp"

namespace decid::nn {
namespace {

LayerKind parse_conv2d(Shape src, Words& words) {
  Conv2dShape s{};
  int groups = 1, dilation_rows = 1, dilation_columns = 1;
  s.src_channels = src.channels;
  s.src_rows = src.rows;
  s.src_columns = src.columns;
  s.dst_channels = words.take_int(1, 4096);
  std::tie(s.kernel_rows, s.kernel_columns) = words.take_pair(1, 255);
  s.stride_rows = s.stride_columns = 1;
  if (words.take_if("stride")) std::tie(s.stride_rows, s.stride_columns) = words.take_pair(1, 255);
  if (words.take_if("pad")) std::tie(s.pad_rows, s.pad_columns) = words.take_pair(0, 254);
  if (words.take_if("groups")) groups = words.take_int(1, 4096);
  if (words.take_if("dilation")) std::tie(dilation_rows, dilation_columns) = words.take_pair(1, 4096);
  const bool plain = groups == 1 && dilation_rows == 1 && dilation_columns == 1;
  const int reach_rows = (s.kernel_rows - 1) * dilation_rows + 1;
  const int reach_columns = (s.kernel_columns - 1) * dilation_columns + 1;
  if (s.pad_rows >= reach_rows || s.pad_columns >= reach_columns) words.fail("has padding as large as its kernel");
  if (s.src_channels % groups != 0 || s.dst_channels % groups != 0)
    words.fail("has " + std::to_string(groups) + " groups that do not divide its channels, " +
               std::to_string(s.src_channels) + " and " + std::to_string(s.dst_channels));
  if (dilation_rows > 1 && s.stride_rows > 1) words.fail("has both dilation and stride along its rows");
  const auto extent = [&](int size, int kernel, int stride, int pad) {
    if (size + 2 * pad < kernel)
      words.fail("has a kernel larger than its padded input of " + std::to_string(src.rows) + "x" +
                 std::to_string(src.columns));
    return (size + 2 * pad - kernel) / stride + 1;
  };
  s.dst_rows = extent(s.src_rows, reach_rows, s.stride_rows, s.pad_rows);
  s.dst_columns = extent(s.src_columns, reach_columns, s.stride_columns, s.pad_columns);
  words.limit(static_cast<long long>(s.dst_channels) * s.src_channels * reach_rows * reach_columns, "weights");
  if (plain) return Conv2d{s};
  return Extension{grouped_conv(s, groups, dilation_rows, dilation_columns)};
}

FullyConnected parse_fully_connected(Shape src, Words& words) {
  const int outputs = words.take_int(1, 65536);
  words.limit(static_cast<long long>(outputs) * src.size(), "weights");
  return {src, outputs};
}

/// Parses the pool that `words` describe, name included, up to its padding. Returns nothing, and takes no word, if they
/// do not describe a pool.
std::optional<Pool> parse_pool(Shape src, Words& words) {
  Pool pool{};
  if (words.take_if("maxpool"))
    pool.kind = Pool::Kind::max;
  else if (words.take_if("avgpool"))
    pool.kind = Pool::Kind::average;
  else if (words.take_if("globalavgpool"))
    pool.kind = Pool::Kind::global_average;
  else
    return std::nullopt;
  PoolShape& s = pool.shape;
  s.channels = src.channels;
  s.src_rows = s.kernel_rows = src.rows;
  s.src_columns = s.kernel_columns = src.columns;
  const bool global = pool.kind == Pool::Kind::global_average;
  if (!global) std::tie(s.kernel_rows, s.kernel_columns) = words.take_pair(1, 4096);
  s.stride_rows = s.kernel_rows;
  s.stride_columns = s.kernel_columns;
  if (!global && words.take_if("stride")) std::tie(s.stride_rows, s.stride_columns) = words.take_pair(1, 4096);
  if (!global && !words.done()) return pool;  // padded: its windows may be larger
  if (s.kernel_rows > s.src_rows || s.kernel_columns > s.src_columns)
    words.fail("has a window larger than its input of " + std::to_string(src.rows) + "x" + std::to_string(src.columns));
  s.dst_rows = (s.src_rows - s.kernel_rows) / s.stride_rows + 1;
  s.dst_columns = (s.src_columns - s.kernel_columns) / s.stride_columns + 1;
  return pool;
}

/// The pool line that `words` describe behind "pad".
LayerKind finish_pool(const Pool& pool, Words& words) {
  if (words.done()) return pool;
  if (pool.kind == Pool::Kind::global_average || !words.take_if("pad")) words.finish();
  const auto [pad_rows, pad_columns] = words.take_pair(0, 4095);
  if (pad_rows >= pool.shape.kernel_rows || pad_columns >= pool.shape.kernel_columns)
    words.fail("has padding as large as its window");
  if (pool.shape.src_rows + 2 * pad_rows < pool.shape.kernel_rows ||
      pool.shape.src_columns + 2 * pad_columns < pool.shape.kernel_columns)
    words.fail("has a window larger than its padded input");
  return Extension{padded_pool(pool, pad_rows, pad_columns)};
}

/// The words that parse_layers() reads itself, before it asks the registry.
constexpr std::array<std::string_view, 12> built_in_words{"conv",      "fc",      "relu",    "statspool",
                                                          "batchnorm", "maxpool", "avgpool", "globalavgpool",
                                                          "residual",  "concat",  "{",       "}"};

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
  return Extension{std::move(made)};
}

/// Makes the end of a residual or concat, whose beginning is `branch`.
Join join_of(const Branch& branch, Shape src, const Words& words) {
  const Shape& skipped = branch.shape;
  if (branch.concatenates && (skipped.rows != src.rows || skipped.columns != src.columns))
    words.fail("ends a concat whose planes have other rows or columns than its input");
  if (!branch.concatenates && skipped != src)
    words.fail("ends a residual whose output has another shape than its input");
  return {src, skipped, branch.concatenates};
}

}  // namespace

void register_layer(const std::string& word, OperationParser parser) {
  const auto fail = [&](Code code, const char* problem, const char* remedy) {
    throw Error(code, "layer '" + word + "'", problem, remedy);
  };
  if (parser == nullptr) fail(Code::setting_missing, "is registered without a parser", "give one");
  if (std::ranges::find(built_in_words, word) != built_in_words.end())
    fail(Code::setting_conflict, "is one of decid's own", "choose another name");
  if (!is_one_word(word)) fail(Code::setting_malformed, "is not one word", "give a word without spaces, #, ;, { and }");
  const std::lock_guard lock(registry().mutex);
  const auto [place, is_new] = registry().parsers.emplace(word, parser);
  if (!is_new && place->second != parser) fail(Code::setting_conflict, "is registered already", "choose another name");
}

std::vector<LayerKind> parse_layers(Shape src, const std::vector<std::string>& lines) {
  std::vector<LayerKind> layers;
  std::vector<Branch> open;  // whose end is to come
  for (std::size_t i = 0; i < lines.size();) {
    Words words(lines[i++]);
    if (words.take_if("conv")) {
      layers.push_back(parse_conv2d(src, words));
    } else if (words.take_if("fc")) {
      layers.emplace_back(parse_fully_connected(src, words));
    } else if (words.take_if("relu")) {
      layers.emplace_back(Relu{src});
    } else if (words.take_if("statspool")) {
      layers.emplace_back(StatisticsPool{src});
    } else if (words.take_if("batchnorm")) {
      words.finish();
      BatchNorm norm{src, i < lines.size() && Words(lines[i]).take_if("relu"), std::nullopt};
      if (norm.relu) words = Words(lines[i++]), words.take(), words.finish();
      if (i < lines.size()) {
        Words next(lines[i]);
        const std::optional<Pool> pool = parse_pool(src, next);
        if (pool && next.done() && !pool->overlaps()) norm.pool = pool, words = next, ++i;
      }
      layers.emplace_back(norm);
    } else if (const std::optional<Pool> pool = parse_pool(src, words)) {
      layers.push_back(finish_pool(*pool, words));
    } else if (words.take_if("}")) {
      if (open.empty()) words.fail("ends a block that has no beginning");
      layers.emplace_back(join_of(open.back(), src, words));
      open.pop_back();
    } else {
      const std::string word = words.take();
      if (word == "residual" || word == "concat") {
        if (!words.take_if("{")) words.fail("has no { behind " + word);
        open.push_back({src, word == "concat"});
        layers.emplace_back(open.back());
      } else if (const OperationParser parse = parser_of(word)) {
        layers.emplace_back(parse_registered(parse, src, words, lines[i - 1]));
      } else {
        words.fail("is not a layer this program knows");
      }
    }
    words.finish();
    src = std::visit([](const auto& kind) { return kind.dst(); }, layers.back());
    words.limit(static_cast<long long>(src.rows) * src.columns * src.channels, "outputs");
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
