// From an architecture's text to its layers: see architecture.hpp.
#include "nn/architecture.hpp"

#include <charconv>
#include <sstream>
#include <tuple>

#include "base/error.hpp"

namespace decid::nn {
namespace {

constexpr std::size_t max_bytes = 200;  // of a layer's line

/// The words of a layer's line, read one by one with errors that name the line.
class Words {
 public:
  /// Throws Error if the line is longer than any layer, whose errors quote it.
  explicit Words(const std::string& line) : line_(line) {
    if (line.size() > max_bytes)
      throw Error("a layer's line",
                  "has " + std::to_string(line.size()) + " bytes, more than " + std::to_string(max_bytes),
                  "write one layer a line");
    std::istringstream stream(line);
    stream.exceptions(std::ios::badbit);  // or what is left out for want of memory would pass for the end
    for (std::string word; stream >> word;) words_.push_back(word);
  }

  bool done() const { return next_ == words_.size(); }
  /// Throws Error if words are left over.
  void finish() const {
    if (!done()) fail("has '" + words_[next_] + "' left over");
  }
  std::string take() {
    if (done()) fail("ends where another word is expected");
    return words_[next_++];
  }
  /// Takes the next word if it is `word`.
  bool take_if(const std::string& word) {
    if (done() || words_[next_] != word) return false;
    ++next_;
    return true;
  }
  /// A whole number in [low, high].
  int take_int(int low, int high) { return to_int(take(), low, high); }
  /// "3" or "3x5": rows and columns, each in [low, high].
  std::pair<int, int> take_pair(int low, int high) {
    const std::string word = take();
    const std::size_t x = word.find('x');
    const int rows = to_int(word.substr(0, x), low, high);
    return {rows, x == std::string::npos ? rows : to_int(word.substr(x + 1), low, high)};
  }
  [[noreturn]] void fail(const std::string& problem) const {
    throw Error("layer '" + line_ + "'", problem,
                "layers are: conv CHANNELS RxC [stride RxC] [pad RxC], batchnorm, relu, maxpool RxC [stride RxC], "
                "avgpool RxC [stride RxC], globalavgpool, statspool, fc OUTPUTS");
  }
  /// Fails if `count` of `what` are more than max_values.
  void limit(long long count, const std::string& what) const {
    if (count > max_values)
      fail("has " + std::to_string(count) + " " + what + ", more than " + std::to_string(max_values));
  }

 private:
  int to_int(const std::string& word, int low, int high) const {
    int value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size() || value < low || value > high)
      fail("'" + word + "' is not a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    return value;
  }

  std::string line_;
  std::vector<std::string> words_;
  std::size_t next_ = 0;
};

Conv2d parse_conv2d(Shape src, Words& words) {
  Conv2dShape s{};
  s.src_channels = src.channels;
  s.src_rows = src.rows;
  s.src_columns = src.columns;
  s.dst_channels = words.take_int(1, 4096);
  std::tie(s.kernel_rows, s.kernel_columns) = words.take_pair(1, 255);
  s.stride_rows = s.stride_columns = 1;
  if (words.take_if("stride")) std::tie(s.stride_rows, s.stride_columns) = words.take_pair(1, 255);
  if (words.take_if("pad")) std::tie(s.pad_rows, s.pad_columns) = words.take_pair(0, 254);
  if (s.pad_rows >= s.kernel_rows || s.pad_columns >= s.kernel_columns)
    words.fail("has padding as large as its kernel");
  const auto extent = [&](int size, int kernel, int stride, int pad) {
    if (size + 2 * pad < kernel)
      words.fail("has a kernel larger than its padded input of " + std::to_string(src.rows) + "x" +
                 std::to_string(src.columns));
    return (size + 2 * pad - kernel) / stride + 1;
  };
  s.dst_rows = extent(s.src_rows, s.kernel_rows, s.stride_rows, s.pad_rows);
  s.dst_columns = extent(s.src_columns, s.kernel_columns, s.stride_columns, s.pad_columns);
  words.limit(static_cast<long long>(s.dst_channels) * s.src_channels * s.kernel_rows * s.kernel_columns, "weights");
  return {s};
}

FullyConnected parse_fully_connected(Shape src, Words& words) {
  const int outputs = words.take_int(1, 65536);
  words.limit(static_cast<long long>(outputs) * src.size(), "weights");
  return {src, outputs};
}

/// The pool that `words` describe, name included; nothing, and no word taken, if they describe no pool.
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
  if (s.kernel_rows > s.src_rows || s.kernel_columns > s.src_columns)
    words.fail("has a window larger than its input of " + std::to_string(src.rows) + "x" + std::to_string(src.columns));
  s.dst_rows = (s.src_rows - s.kernel_rows) / s.stride_rows + 1;
  s.dst_columns = (s.src_columns - s.kernel_columns) / s.stride_columns + 1;
  return pool;
}

}  // namespace

template <class T>
std::vector<Layer<T>> make_layers(Shape src, const std::vector<std::string>& lines) {
  std::vector<Layer<T>> layers;
  for (std::size_t i = 0; i < lines.size();) {
    Words words(lines[i++]);
    if (words.take_if("conv")) {
      layers.emplace_back(parse_conv2d(src, words));
    } else if (words.take_if("fc")) {
      layers.emplace_back(parse_fully_connected(src, words));
    } else if (words.take_if("relu")) {
      layers.emplace_back(Relu{src});
    } else if (words.take_if("statspool")) {
      layers.emplace_back(StatisticsPool{src});
    } else if (words.take_if("batchnorm")) {
      words.finish();
      BatchNorm norm{src, i < lines.size() && Words(lines[i]).take_if("relu"), std::nullopt};
      if (norm.relu) words = Words(lines[i++]), words.take();
      if (i < lines.size()) {
        Words next(lines[i]);
        const std::optional<Pool> pool = parse_pool(src, next);
        if (pool && !pool->overlaps()) norm.pool = pool, words = next, ++i;
      }
      layers.emplace_back(norm);
    } else if (const std::optional<Pool> pool = parse_pool(src, words)) {
      layers.emplace_back(*pool);
    } else {
      words.take();
      words.fail("is not a layer this program knows");
    }
    words.finish();
    src = layers.back().dst_shape();
    words.limit(static_cast<long long>(src.rows) * src.columns * src.channels, "outputs");
  }
  return layers;
}

template std::vector<Layer<float>> make_layers(Shape, const std::vector<std::string>&);
template std::vector<Layer<double>> make_layers(Shape, const std::vector<std::string>&);

}  // namespace decid::nn
