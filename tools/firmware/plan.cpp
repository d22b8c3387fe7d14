// From a model to a firmware's layers and memory: see plan.hpp.
#include "tools/firmware/plan.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/text.hpp"
#include "nn/operation.hpp"
#include "nn/words.hpp"
#include "sim/fft.hpp"

namespace decid::tools {
namespace {

using Kind = FirmwareLayer::Kind;
constexpr int complex_bytes = 16;
constexpr int max_layers = 250;  // their numbers fit a byte
constexpr long long max_bytes = 1LL << 30;

/// The layers' list while it grows; maps are numbered as layers write them.
class Chain {
 public:
  explicit Chain(nn::Shape input) { shapes_.push_back(input); }

  FirmwareLayer& add(Kind kind, nn::Shape dst) {
    FirmwareLayer layer;
    layer.kind = kind;
    layer.src = static_cast<int>(shapes_.size()) - 1;
    layer.dst = layer.src + 1;
    shapes_.push_back(dst);
    layers_.push_back(std::move(layer));
    finished_ = false;
    return layers_.back();
  }
  /// The layer whose outputs BatchNorm and ReLU change: the last one, unless it has some already; then one that does
  /// nothing else.
  FirmwareLayer& to_finish() {
    if (layers_.empty() || finished_) add(Kind::max_pool, shapes_.back()).taps = 1;
    finished_ = true;
    return layers_.back();
  }
  /// The current map is the input of a block: nothing may change it any more.
  void open_block() {
    kept_.push_back(static_cast<int>(shapes_.size()) - 1);
    finished_ = true;
  }
  void close_block(const nn::Join& join) {
    add(join.concatenates ? Kind::concat : Kind::add, join.dst()).kept = kept_.back();
    kept_.pop_back();
  }
  bool is_empty() const { return layers_.empty(); }
  std::vector<FirmwareLayer> layers() && { return std::move(layers_); }
  const std::vector<nn::Shape>& shapes() const { return shapes_; }

 private:
  std::vector<nn::Shape> shapes_;
  std::vector<FirmwareLayer> layers_;
  std::vector<int> kept_;  // inputs of the open blocks
  bool finished_ = false;
};

void add_sums(Chain& chain, const nn::Step<float>& step) {
  const bool convolution = step.kind == nn::Step<float>::Kind::convolution;
  FirmwareLayer& layer = chain.add(convolution ? Kind::convolution : Kind::all, step.dst);
  layer.kernel = {step.conv.kernel_rows, step.conv.kernel_columns};
  if (convolution) {
    layer.stride = {step.conv.stride_rows, step.conv.stride_columns};
    layer.pad = {step.conv.pad_rows, step.conv.pad_columns};
  }
  layer.taps = step.src.channels * layer.kernel.rows * layer.kernel.columns;
  layer.weight = step.weight;
  layer.bias = step.bias;
}

void add_pool(Chain& chain, const nn::Pool& pool) {
  FirmwareLayer& layer = chain.add(pool.kind == nn::Pool::Kind::max ? Kind::max_pool : Kind::average_pool, pool.dst());
  layer.kernel = {pool.shape.kernel_rows, pool.shape.kernel_columns};
  layer.stride = {pool.shape.stride_rows, pool.shape.stride_columns};
  layer.taps = layer.kernel.rows * layer.kernel.columns;
}

/// The pair behind `name` of a line that text() wrote: all its options are there, in this order.
Extent option(nn::Words& words, const char* name) {
  words.take_if(name);
  const auto [rows, columns] = words.take_pair(0, 1 << 20);
  return {rows, columns};
}

/// Convolution with groups and dilation. Along columns the kernel gets zeros between its taps, as in the engine.
void add_grouped(Chain& chain, const nn::Step<float>& step, nn::Words& words) {
  words.take();
  const Extent kernel = option(words, "");
  FirmwareLayer& layer = chain.add(Kind::convolution, step.dst);
  layer.stride = option(words, "stride");
  layer.pad = option(words, "pad");
  layer.groups = option(words, "groups").rows;
  const Extent dilation = option(words, "dilation");
  layer.dilation = dilation.rows;
  layer.kernel = {kernel.rows, (kernel.columns - 1) * dilation.columns + 1};
  layer.taps = step.src.channels / layer.groups * layer.kernel.rows * layer.kernel.columns;
  layer.bias = step.parameters[1];
  layer.weight.assign(layer.bias.size() * static_cast<std::size_t>(layer.taps), 0.0F);
  const auto columns = static_cast<std::size_t>(kernel.columns), wide = static_cast<std::size_t>(layer.kernel.columns),
             gap = static_cast<std::size_t>(dilation.columns);
  for (std::size_t i = 0; i < step.parameters[0].size(); ++i)
    layer.weight[i / columns * wide + i % columns * gap] = step.parameters[0][i];
}

void add_padded(Chain& chain, Kind kind, const nn::Step<float>& step, nn::Words& words) {
  FirmwareLayer& layer = chain.add(kind, step.dst);
  layer.kernel = option(words, "");
  layer.stride = option(words, "stride");
  layer.pad = option(words, "pad");
  layer.taps = layer.kernel.rows * layer.kernel.columns;
}

void add_layernorm(Chain& chain, const nn::Step<float>& step) {
  FirmwareLayer& layer = chain.add(Kind::layer_norm, step.dst);
  layer.kernel = {step.src.rows, step.src.columns};
  layer.taps = step.src.rows * step.src.columns;
  layer.weight = step.parameters[0];
  layer.bias = step.parameters[1];
}

/// A layer of one file, by the words of its line.
void add_operation(Chain& chain, const nn::Step<float>& step) {
  const std::string text = step.operation->text();
  nn::Words words(text);
  const std::string word = words.take();
  if (word == "conv") return add_grouped(chain, step, words);
  if (word == "maxpool") return add_padded(chain, Kind::max_pool, step, words);
  if (word == "avgpool") return add_padded(chain, Kind::average_pool, step, words);
  if (word == "layernorm") return add_layernorm(chain, step);
  if (word == "dropout") return;  // passes on in inference
  constexpr std::pair<const char*, Kind> functions[] = {
      {"leakyrelu", Kind::leaky_relu}, {"tanh", Kind::tanh}, {"sigmoid", Kind::sigmoid}, {"gelu", Kind::gelu}};
  for (const auto& [name, kind] : functions)
    if (word == name) {
      FirmwareLayer& layer = chain.add(kind, step.dst);
      layer.taps = 1;
      if (kind == Kind::leaky_relu) layer.slope = static_cast<float>(words.take_number(0, 1));
      return;
    }
  throw Error(Code::not_supported, "export", "the network has a layer '" + text + "', which exported C does not have",
              "export a network of decid's own layers");
}

Chain chain_of(const nn::Inference<float>& inference) {
  Chain chain(inference.input_shape());
  for (const nn::Step<float>& step : inference.steps()) {
    if (step.kind == nn::Step<float>::Kind::statistics) {
      FirmwareLayer& layer = chain.add(Kind::statistics, step.dst);
      layer.kernel = {step.src.rows, step.src.columns};
      layer.taps = step.src.rows * step.src.columns;
      continue;
    }
    if (step.sums()) {
      add_sums(chain, step);
      continue;
    }
    if (step.kind == nn::Step<float>::Kind::operation) {
      add_operation(chain, step);
      continue;
    }
    if (step.kind == nn::Step<float>::Kind::branch) {
      chain.open_block();
      continue;
    }
    if (step.kind == nn::Step<float>::Kind::join) {
      chain.close_block(step.join);
      continue;
    }
    FirmwareLayer& finished = chain.to_finish();
    finished.affine = step.affine;
    finished.normalises = step.affine.scale.empty();
    finished.rectifies = step.relu;
    if (step.pool) add_pool(chain, *step.pool);
  }
  if (chain.is_empty()) chain.to_finish();  // dropout alone; C has no arrays of size zero
  return chain;
}

/// at_once: all lines are made before the first one is read.
void lay_out(FirmwareMap& map, const FirmwareLayer* consumer, bool stream_rows, bool at_once) {
  const nn::Shape& s = map.shape;
  map.lines = stream_rows ? s.rows : s.columns;
  map.positions = stream_rows ? s.columns : s.rows;
  map.whole = at_once || (consumer != nullptr && consumer->reads_all());
  if (map.whole) {
    map.capacity = map.lines;
    map.channel_stride = s.rows * s.columns;
    map.line_stride = stream_rows ? s.columns : 1;
    map.position_stride = stream_rows ? 1 : s.columns;
    return;
  }
  const Extent extent = consumer == nullptr ? Extent{} : consumer->extent();
  const int kernel = stream_rows ? extent.rows : extent.columns;
  map.capacity = std::min(kernel, map.lines);
  map.channel_stride = map.positions;
  map.line_stride = s.channels * map.positions;
  map.position_stride = 1;
}

/// Maps that layers read more than once, or write at once: inputs and outputs of blocks, outputs of layernorm.
std::vector<bool> whole_maps(const std::vector<FirmwareLayer>& layers) {
  std::vector<bool> whole(layers.size() + 1, false);
  for (const FirmwareLayer& layer : layers) {
    if (layer.joins()) whole[static_cast<std::size_t>(layer.kept)] = whole[static_cast<std::size_t>(layer.src)] = true;
    if (layer.kind == Kind::layer_norm) whole[static_cast<std::size_t>(layer.dst)] = true;
  }
  return whole;
}

long long aligned(long long bytes) {
  return (bytes + 7) / 8 * 8;
}

/// Offsets of all maps and of the rest of the arena. With rows as lines the network begins when the last spectrum is
/// drawn, so it has the spectra's memory; with columns it works in between.
void plan_memory(FirmwarePlan& plan, const Model& model) {
  const dataset::ImageSettings& image = model.image();
  const dataset::ImageShape shape = model.images().shape();
  const int value_bytes = plan.options.int8 ? 1 : 4;
  const auto fold = static_cast<long long>(image.fold);
  const bool series = image.block > 0;
  const auto outputs = static_cast<long long>(model.network.output_shape().size());
  const long long state_bytes =
      aligned((6 + static_cast<long long>(plan.maps.size()) + outputs) * 4) + (series ? (1 + 3 * fold) * 8 : 0);
  ArenaPlan& arena = plan.arena;
  arena.maps = aligned(state_bytes);
  long long values = 0;
  for (FirmwareMap& map : plan.maps) {
    map.offset = static_cast<int>(std::min(values, max_bytes));
    if (&map != &plan.maps.back()) values += map.values();
  }
  long long patch = 0;
  for (const FirmwareLayer& layer : plan.layers) {
    if (!layer.reads_all()) patch = std::max<long long>(patch, layer.taps);
  }
  arena.patch = aligned(arena.maps + values * value_bytes);
  const long long network_end = aligned(arena.patch + patch * value_bytes);

  if (series) {
    arena.samples = network_end;
    arena.bytes = network_end + (plan.options.incremental ? (fold - 1) * shape.rows * 8 : 0);
    return;
  }
  const int length = image.window % 2 == 0 ? image.window / 2 : image.window;
  const int bins = std::min(image.window / 2 + 1, shape.rows);
  const int kept_columns = plan.options.incremental ? shape.columns : 1;
  arena.signal = plan.stream_rows ? aligned(arena.maps + plan.maps.front().values() * value_bytes) : network_end;
  arena.scratch = arena.signal + 1LL * length * complex_bytes;
  arena.spectra = arena.scratch + 2LL * plan.max_radix() * complex_bytes;
  arena.samples = arena.spectra + (fold - 1) * kept_columns * bins * complex_bytes;
  const long long end = arena.samples + (plan.options.incremental ? 4LL * image.window : 0);
  arena.bytes = aligned(std::max(network_end, end));
}

FirmwarePlan plan_by(const Chain& chain, const Model& model, const FirmwareOptions& options, bool stream_rows) {
  FirmwarePlan plan;
  plan.options = options;
  plan.stream_rows = stream_rows;
  plan.layers = Chain(chain).layers();
  const int window = model.image().window;
  const bool series = model.image().block > 0;
  if (!series) plan.radices = sim::fft_radices(window % 2 == 0 ? window / 2 : window);
  const std::vector<bool> whole = whole_maps(plan.layers);
  for (std::size_t i = 0; i < chain.shapes().size(); ++i) {
    FirmwareMap map;
    map.shape = chain.shapes()[i];
    lay_out(map, i < plan.layers.size() ? &plan.layers[i] : nullptr, stream_rows,
            whole[i] || (i == 0 && stream_rows && !series));
    plan.maps.push_back(map);
  }
  plan_memory(plan, model);
  return plan;
}

void check_sizes(const Chain& chain) {
  if (chain.shapes().size() > max_layers)
    throw Error(Code::not_supported, "export",
                format("the network has %zu layers, more than %d", chain.shapes().size() - 1, max_layers),
                "export a smaller network");
}
void check_sizes(const FirmwarePlan& plan) {
  if (plan.arena.bytes > max_bytes)
    throw Error(Code::not_supported, "export",
                format("the network needs %lld bytes to work in, more than 1 GiB", plan.arena.bytes),
                "export a smaller network");
}

}  // namespace

int FirmwarePlan::max_radix() const {
  return radices.empty() ? 1 : *std::ranges::max_element(radices);
}

long long FirmwarePlan::weight_bytes() const {
  std::size_t bytes = 0;
  for (const FirmwareLayer& layer : layers) {
    bytes += options.int8 ? layer.steps.size() : layer.weight.size() * sizeof(float);
    bytes += (layer.bias.size() + layer.scale.size() + 2 * layer.affine.scale.size()) * sizeof(float);
  }
  return static_cast<long long>(bytes);
}

long long FirmwarePlan::whole_map_bytes() const {
  long long values = 0;
  for (const FirmwareMap& map : maps) values += map.shape.size();
  return values * (options.int8 ? 1 : 4);
}

FirmwarePlan plan_firmware(const Model& model, const FirmwareOptions& options) {
  if (model.head != &point_head() && !model.gives_distribution())
    throw Error(Code::not_supported, "export", "the model's outputs are of the kind '" + model.head->name() + "'",
                "export a model whose outputs are the parameters, or a mixture");
  if (options.ood_score && !model.ood_detector.known())
    throw Error(Code::not_supported, "--ood-score", "the model has no features of its training trials to compare with",
                "leave it out, or export another model");
  if (options.ood_score && options.int8)
    throw Error(Code::setting_conflict, "--ood-score", "is learned of the network in float, not of 8-bit integers",
                "leave one of them out");
  const Chain chain = chain_of(nn::Inference<float>(model.network));
  check_sizes(chain);
  const std::vector<FirmwareLayer> layers = Chain(chain).layers();
  if (options.int8 && !std::ranges::all_of(layers, &FirmwareLayer::has_integers))
    throw Error(Code::not_supported, "--int8", "the network has a layer that 8-bit integers do not have",
                "leave it out, or use conv, fc, batchnorm, relu, pools without padding and statspool");
  FirmwarePlan rows = plan_by(chain, model, options, true), columns = plan_by(chain, model, options, false);
  const bool by_columns = options.incremental && model.images().shape().columns > 1;
  const bool by_rows = model.image().block > 0;
  FirmwarePlan plan =
      !by_rows && (by_columns || columns.arena.bytes < rows.arena.bytes) ? std::move(columns) : std::move(rows);
  check_sizes(plan);
  return plan;
}

FirmwarePlan plan_network(const nn::Network<float>& network) {
  const nn::Shape out = network.output_shape();
  const Chain chain = chain_of(nn::Inference<float>(network));
  check_sizes(chain);
  FirmwarePlan plan;
  plan.layers = Chain(chain).layers();
  plan.outputs_in_map = out.rows != 1 || out.columns != 1;
  const std::vector<bool> whole = whole_maps(plan.layers);
  long long values = 0, patch = 0;
  for (std::size_t i = 0; i < chain.shapes().size(); ++i) {
    FirmwareMap map;
    map.shape = chain.shapes()[i];
    const bool is_last = i + 1 == chain.shapes().size();
    lay_out(map, i < plan.layers.size() ? &plan.layers[i] : nullptr, true,
            i == 0 || whole[i] || (is_last && plan.outputs_in_map));
    map.offset = static_cast<int>(std::min(values, max_bytes));
    if (!is_last || plan.outputs_in_map) values += map.values();
    plan.maps.push_back(map);
  }
  for (const FirmwareLayer& layer : plan.layers)
    if (!layer.reads_all()) patch = std::max<long long>(patch, layer.taps);
  plan.arena.maps = aligned(static_cast<long long>(plan.maps.size()) * 4);
  plan.arena.patch = aligned(plan.arena.maps + values * 4);
  plan.arena.outputs = aligned(plan.arena.patch + patch * 4);
  plan.arena.bytes = aligned(plan.arena.outputs + 4LL * out.channels);
  if (plan.outputs_in_map) {
    plan.arena.bytes = plan.arena.outputs;
    plan.arena.outputs = plan.arena.maps + 4LL * plan.maps.back().offset;
  }
  check_sizes(plan);
  return plan;
}

}  // namespace decid::tools
