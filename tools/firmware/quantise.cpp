// A firmware's network in 8-bit integers: see quantise.hpp.
#include "tools/firmware/quantise.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"

namespace decid::tools {
namespace {

using Kind = FirmwareLayer::Kind;
constexpr std::uint64_t calibration_seed = 0x63616c6962;
constexpr int max_taps = 1 << 17;  // this many products of 127 and 128 fit 31 bits
constexpr int parts = 16;          // of the trials; each is one thread's

/// As in runtime/network.c.
int to_integer(float value, const FirmwareMap& map) {
  const float steps = value * map.steps_per_unit + static_cast<float>(map.zero);
  const float clamped = !(steps > -128.0F) ? -128.0F : std::min(steps, 127.0F);
  return static_cast<int>(clamped + 128.5F) - 128;
}

/// The inputs of one output, by channel, row and column; `padding` outside.
template <class T>
void gather(const FirmwareLayer& layer, const FirmwareMap& src, const std::vector<T>& values, int first_channel,
            int channels, int row, int column, T padding, std::vector<T>& patch) {
  const nn::Shape& s = src.shape;
  patch.clear();
  for (int c = first_channel; c < first_channel + channels; ++c)
    for (int ky = 0; ky < layer.kernel.rows; ++ky)
      for (int kx = 0; kx < layer.kernel.columns; ++kx) {
        const int y = row * layer.stride.rows - layer.pad.rows + ky;
        const int x = column * layer.stride.columns - layer.pad.columns + kx;
        const bool inside = y >= 0 && y < s.rows && x >= 0 && x < s.columns;
        patch.push_back(inside ? values[static_cast<std::size_t>((c * s.rows + y) * s.columns + x)] : padding);
      }
}

/// One layer's arithmetic: from its inputs to the number that finish() takes.
struct InFloat {
  using Value = float;
  static Value padding(const FirmwareMap&) { return 0.0F; }
  static Value store(float y, const FirmwareMap&) { return y; }
  static float real(const FirmwareLayer&, int, Value x) { return x; }
  static float sum(const FirmwareLayer& layer, int output, const std::vector<Value>& x) {
    float acc = layer.bias[static_cast<std::size_t>(output)];
    const float* w = layer.weight.data() + 1LL * output * layer.taps;
    for (std::size_t t = 0; t < x.size(); ++t) acc = std::fma(w[t], x[t], acc);
    return acc;
  }
  static float pool(const FirmwareLayer& layer, int, const std::vector<Value>& x) {
    if (layer.kind == Kind::max_pool) return *std::ranges::max_element(x);
    float acc = 0.0F;
    for (const float value : x) acc += value;
    return acc * (1.0F / static_cast<float>(x.size()));
  }
};
struct InIntegers {
  using Value = std::int8_t;
  static Value padding(const FirmwareMap& src) { return static_cast<Value>(src.zero); }
  static Value store(float y, const FirmwareMap& dst) { return static_cast<Value>(to_integer(y, dst)); }
  static float scaled(const FirmwareLayer& layer, int output, std::int32_t acc) {
    const auto o = static_cast<std::size_t>(output);
    return std::fma(static_cast<float>(acc), layer.scale[o], layer.bias[o]);
  }
  static float real(const FirmwareLayer& layer, int channel, Value x) { return scaled(layer, channel, x); }
  static float sum(const FirmwareLayer& layer, int output, const std::vector<Value>& x) {
    const std::int8_t* w = layer.steps.data() + 1LL * output * layer.taps;
    std::int32_t acc = 0;
    for (std::size_t t = 0; t < x.size(); ++t) acc += w[t] * x[t];
    return scaled(layer, output, acc);
  }
  static float pool(const FirmwareLayer& layer, int channel, const std::vector<Value>& x) {
    if (layer.kind == Kind::max_pool) return scaled(layer, channel, *std::ranges::max_element(x));
    return scaled(layer, channel, std::accumulate(x.begin(), x.end(), std::int32_t{0}));
  }
};

float finish(const FirmwareLayer& layer, int channel, float value) {
  const auto c = static_cast<std::size_t>(channel);
  float y = value;
  if (!layer.affine.scale.empty()) {
    y = std::fma(y, layer.affine.scale[c], layer.affine.shift[c]);
  } else if (layer.normalises) {
    y = y + 0.0F;
  }
  return layer.rectifies && y < 0.0F ? 0.0F : y;
}

/// Mean and deviation of a channel's values.
template <class Arithmetic>
std::pair<float, float> statistics(const FirmwareLayer& layer, int channel,
                                   std::span<const typename Arithmetic::Value> x) {
  const float share = 1.0F / static_cast<float>(x.size());
  float sum = 0.0F, squares = 0.0F;
  for (const auto value : x) sum += Arithmetic::real(layer, channel, value);
  const float mean = sum * share;
  for (const auto value : x) {
    const float off = Arithmetic::real(layer, channel, value) - mean;
    squares = std::fma(off, off, squares);
  }
  return {mean, std::sqrt(std::fma(squares, share, static_cast<float>(nn::StatisticsPool::epsilon)))};
}

/// see(map, value as a real number) for every value of every map.
template <class Arithmetic, class See>
std::vector<float> run(const FirmwarePlan& plan, std::span<const float> image, const See& see) {
  using Value = typename Arithmetic::Value;
  std::vector<Value> values, next, patch;
  std::vector<float> outputs;
  for (const float pixel : image) {
    see(0, pixel);
    values.push_back(Arithmetic::store(pixel, plan.maps.front()));
  }
  for (const FirmwareLayer& layer : plan.layers) {
    const FirmwareMap& src = plan.maps[static_cast<std::size_t>(layer.src)];
    const FirmwareMap& dst = plan.maps[static_cast<std::size_t>(layer.dst)];
    const nn::Shape& s = dst.shape;
    next.assign(static_cast<std::size_t>(s.size()), Value{});
    outputs.assign(static_cast<std::size_t>(s.size()), 0.0F);
    const auto put = [&](int c, int i, int j, float value) {
      const auto at = static_cast<std::size_t>((c * s.rows + i) * s.columns + j);
      outputs[at] = finish(layer, c, value);
      see(layer.dst, outputs[at]);
      next[at] = Arithmetic::store(outputs[at], dst);
    };
    if (layer.kind == Kind::statistics) {
      const auto plane = static_cast<std::size_t>(layer.taps);
      for (int c = 0; c < src.shape.channels; ++c) {
        const auto [mean, stddev] = statistics<Arithmetic>(
            layer, c, std::span<const Value>(values).subspan(static_cast<std::size_t>(c) * plane, plane));
        put(c, 0, 0, mean);
        put(src.shape.channels + c, 0, 0, stddev);
      }
      values.swap(next);
      continue;
    }
    for (int i = 0; i < s.rows; ++i)
      for (int j = 0; j < s.columns; ++j) {
        if (layer.sums()) {
          gather(layer, src, values, 0, src.shape.channels, i, j, Arithmetic::padding(src), patch);
          for (int c = 0; c < s.channels; ++c) put(c, i, j, Arithmetic::sum(layer, c, patch));
          continue;
        }
        for (int c = 0; c < s.channels; ++c) {
          gather(layer, src, values, c, 1, i, j, Arithmetic::padding(src), patch);
          put(c, i, j, Arithmetic::pool(layer, c, patch));
        }
      }
    values.swap(next);
  }
  return outputs;
}

struct Range {
  float low = 0.0F, high = 0.0F;  // 0 is one of the values that padding needs
};

/// The range of each map's values over simulated trials.
std::vector<Range> ranges(const FirmwarePlan& plan, const Model& model) {
  const int trials = calibration_trials(plan);
  const std::unique_ptr<dataset::TrialSource> source =
      dataset::stream_source(model.protocol, calibration_seed, trials, 1);
  const auto size = static_cast<std::size_t>(model.images().shape().size());
  std::vector<float> images(static_cast<std::size_t>(trials) * size);
  std::vector<int> indices(static_cast<std::size_t>(trials));
  std::iota(indices.begin(), indices.end(), 0);
  source->take(dataset::Part::training, 0, indices,
               [&](std::size_t place, const sim::Parameters&, const dataset::Sway& sway) {
                 model.make_input(sway, std::span(images).subspan(place * size, size));
               });
  std::vector<std::vector<Range>> found(parts, std::vector<Range>(plan.maps.size()));
  parallel_for(parts, [&](int part) {
    for (int i = part; i < trials; i += parts) {
      std::vector<Range>& mine = found[static_cast<std::size_t>(part)];
      const auto see = [&](int map, float value) {
        Range& range = mine[static_cast<std::size_t>(map)];
        range.low = std::min(range.low, value);
        range.high = std::max(range.high, value);
      };
      run<InFloat>(plan, std::span(images).subspan(static_cast<std::size_t>(i) * size, size), see);
    }
  });
  std::vector<Range> all = found.front();
  for (const std::vector<Range>& part : found)
    for (std::size_t map = 0; map < all.size(); ++map) {
      all[map].low = std::min(all[map].low, part[map].low);
      all[map].high = std::max(all[map].high, part[map].high);
    }
  return all;
}

/// 256 steps from the lowest to the highest value, 0 on one of them.
void scale_map(FirmwareMap& map, Range range) {
  const double width = std::max(static_cast<double>(range.high) - static_cast<double>(range.low), 1e-30);
  const double steps = 255.0 / width;
  map.steps_per_unit = static_cast<float>(steps);
  map.zero =
      static_cast<int>(std::clamp(std::floor(-128.5 - static_cast<double>(range.low) * steps) + 1, -128.0, 127.0));
}

void quantise_weights(FirmwareLayer& layer, const FirmwareMap& src) {
  const double unit = 1.0 / static_cast<double>(src.steps_per_unit);
  for (std::size_t o = 0; o < layer.bias.size(); ++o) {
    const auto w =
        std::span(layer.weight).subspan(o * static_cast<std::size_t>(layer.taps), static_cast<std::size_t>(layer.taps));
    float largest = std::numeric_limits<float>::min();
    for (const float value : w) largest = std::max(largest, std::abs(value));
    const double step = static_cast<double>(largest) / 127.0;
    std::int32_t sum = 0;
    for (const float value : w) {
      const auto steps = static_cast<int>(std::floor(static_cast<double>(value) / step + 0.5));
      layer.steps.push_back(static_cast<std::int8_t>(std::clamp(steps, -127, 127)));
      sum += layer.steps.back();
    }
    layer.scale.push_back(static_cast<float>(step * unit));
    layer.bias[o] = static_cast<float>(static_cast<double>(layer.bias[o]) - step * unit * src.zero * sum);
  }
}

void quantise_pool(FirmwareLayer& layer, const FirmwareMap& src) {
  const double unit = 1.0 / static_cast<double>(src.steps_per_unit);
  const double scale = layer.kind == Kind::average_pool ? unit / layer.taps : unit;
  layer.scale.assign(static_cast<std::size_t>(src.shape.channels), static_cast<float>(scale));
  layer.bias.assign(static_cast<std::size_t>(src.shape.channels), static_cast<float>(-unit * src.zero));
}

}  // namespace

int calibration_trials(const FirmwarePlan& plan) {
  long long products = 1;
  for (const FirmwareLayer& layer : plan.layers)
    if (layer.sums()) products += 1LL * layer.taps * plan.maps[static_cast<std::size_t>(layer.dst)].shape.size();
  return static_cast<int>(std::clamp(10'000'000'000 / products, 16LL, 256LL));
}

void quantise(FirmwarePlan& plan, const Model& model) {
  for (const FirmwareLayer& layer : plan.layers)
    if (layer.taps > max_taps)
      throw Error(Code::not_supported, "export",
                  format("a layer sums %d values, more than %d, which 32 bits may not hold", layer.taps, max_taps),
                  "export it without --int8");
  const std::vector<Range> found = ranges(plan, model);
  for (std::size_t map = 0; map < plan.maps.size(); ++map) scale_map(plan.maps[map], found[map]);
  for (FirmwareLayer& layer : plan.layers) {
    const FirmwareMap& src = plan.maps[static_cast<std::size_t>(layer.src)];
    layer.sums() ? quantise_weights(layer, src) : quantise_pool(layer, src);
  }
}

std::vector<float> run_plan(const FirmwarePlan& plan, std::span<const float> image) {
  const auto see_nothing = [](int, float) {};
  return plan.options.int8 ? run<InIntegers>(plan, image, see_nothing) : run<InFloat>(plan, image, see_nothing);
}

std::vector<float> predict_planned(const FirmwarePlan& plan, const Model& model, int trials, const Sways& sways) {
  constexpr int at_once = 64;
  const auto outputs = static_cast<std::size_t>(model.network.output_shape().size());
  std::vector<float> result(static_cast<std::size_t>(trials) * outputs);
  for (int first = 0; first < trials; first += at_once) {
    std::vector<int> indices(static_cast<std::size_t>(std::min(at_once, trials - first)));
    std::iota(indices.begin(), indices.end(), first);
    sways(indices, [&](std::size_t place, const dataset::Sway& sway) {
      std::vector<float> image(static_cast<std::size_t>(model.images().shape().size()));
      model.make_input(sway, image);
      const std::vector<float> trial = run_plan(plan, image);
      std::ranges::copy(
          trial, result.begin() + static_cast<std::ptrdiff_t>((static_cast<std::size_t>(first) + place) * outputs));
    });
  }
  return result;
}

}  // namespace decid::tools
