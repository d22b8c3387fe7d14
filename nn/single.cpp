// One sample at a time: see single.hpp.
#include "nn/single.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "nn/sharing.hpp"

namespace decid::nn {
namespace {

/// Blocks of channels that one thread computes at a time: a tile's two.
constexpr int block_group = 2;

}  // namespace

SingleNetwork::SingleNetwork(const Network<float>& network)
    : input_shape_(network.input_shape()), output_shape_(network.output_shape()) {
  if (network.mode() != Mode::inference || network.planned_batch() == 0)
    throw Error("single-sample network", "is made from one that is not planned for inference", "plan() that one first");
  std::vector<Stage<float>> stages;
  std::size_t current = add_map(input_shape_);
  for (const auto& layer : network.layers()) {
    const Stage<float> stage = layer->stage();
    if (stage.conv != nullptr || stage.fully_connected) {
      Map& src = maps_[current];
      src.halo = std::max(src.halo, layer->src_halo());
      Step step;
      step.src = current;
      step.dst = current = add_map(layer->dst_shape());
      steps_.push_back(std::move(step));
      stages.push_back(stage);
    }
    if (stage.conv == nullptr && !stage.fully_connected) {
      Step step;
      step.src = step.dst = current;
      step.affine = stage.affine;
      step.relu = stage.relu;
      if (stage.pool != nullptr) {
        step.pool = *stage.pool;
        step.dst = current = add_map(layer->dst_shape());
      }
      steps_.push_back(std::move(step));
      stages.push_back(stage);
    }
  }
  std::size_t values = 0;
  for (Map& map : maps_) {
    map.offset = values;
    values += map.values();
  }
  memory_.reserve(values);
  for (std::size_t i = 0; i < steps_.size(); ++i)
    if (stages[i].weight != nullptr) pack(stages[i], steps_[i]);
}

std::size_t SingleNetwork::add_map(Shape shape) {
  maps_.push_back({shape, 0, 0});
  return maps_.size() - 1;
}

// Taps in the order of the batch kernels' chains: channel, row, column.
void SingleNetwork::pack(const Stage<float>& stage, Step& step) const {
  const Map &src = maps_[step.src], &dst = maps_[step.dst];
  Conv2dShape shape{};
  if (stage.conv != nullptr) {
    shape = *stage.conv;
  } else {
    shape.kernel_rows = src.shape.rows;
    shape.kernel_columns = src.shape.columns;
    shape.stride_rows = shape.stride_columns = 1;
  }
  for (int c = 0; c < src.shape.channels; ++c)
    for (int ky = 0; ky < shape.kernel_rows; ++ky)
      for (int kx = 0; kx < shape.kernel_columns; ++kx)
        step.offset.push_back(c / lanes * src.block() + (ky - shape.pad_rows) * src.row() +
                              (kx - shape.pad_columns) * lanes + c % lanes);
  const std::size_t taps = step.offset.size();
  step.weight.assign(static_cast<std::size_t>(dst.blocks()) * taps * lanes, 0.0F);
  step.bias.assign(static_cast<std::size_t>(dst.blocks()) * lanes, 0.0F);
  for (std::size_t o = 0; o < static_cast<std::size_t>(dst.shape.channels); ++o) {
    step.bias[o] = stage.bias[o];
    for (std::size_t t = 0; t < taps; ++t)
      step.weight[(o / lanes * taps + t) * lanes + o % lanes] = stage.weight[o * taps + t];
  }
  step.conv = {dst.shape.rows,
               dst.shape.columns,
               at(src),
               shape.stride_rows * src.row(),
               static_cast<std::ptrdiff_t>(shape.stride_columns) * lanes,
               step.offset.data(),
               static_cast<int>(taps),
               step.weight.data(),
               step.bias.data(),
               at(dst),
               dst.block(),
               dst.row()};
}

void SingleNetwork::run(std::span<const float> image, std::span<float> output) {
  if (image.size() != static_cast<std::size_t>(input_shape_.size()) ||
      output.size() != static_cast<std::size_t>(output_shape_.size()))
    throw Error("single-sample network",
                "got an image of " + std::to_string(image.size()) + " and room for " + std::to_string(output.size()) +
                    " outputs where it has " + std::to_string(input_shape_.size()) + " and " +
                    std::to_string(output_shape_.size()),
                "give spans of those sizes");
  const auto each = [&](const Map& map, const auto& body) {
    std::size_t k = 0;
    for (int c = 0; c < map.shape.channels; ++c)
      for (int i = 0; i < map.shape.rows; ++i)
        for (int j = 0; j < map.shape.columns; ++j)
          body(at(map)[c / lanes * map.block() + i * map.row() + j * lanes + c % lanes], k++);
  };
  each(maps_.front(), [&](float& value, std::size_t k) { value = image[k]; });
  for (const Step& step : steps_) {
    if (step.conv.taps > 0)
      for_each_group(1, maps_[step.dst].blocks(), block_group,
                     [&](int, int first, int last) { kernels<float>().conv2d_single(step.conv, first, last); });
    else
      activate(step);
  }
  each(maps_.back(), [&](float& value, std::size_t k) { output[k] = value; });
}

void SingleNetwork::activate(const Step& step) const {
  const Map &src = maps_[step.src], &dst = maps_[step.dst];
  for (int b = 0; b < src.blocks(); ++b) {
    float* const values = at(src) + b * src.block();
    const Plane<float> plane{values, src.row(), src.shape.rows, src.shape.columns};
    const Plane<const float> constant{values, src.row(), src.shape.rows, src.shape.columns};
    if (step.affine.scale.empty()) {
      // What Network does with a folded BatchNorm: fma(x, 1, 0), which makes -0 a 0.
      kernels<float>().activation_forward({1.0F, 0.0F, false, Pooling::none}, {}, constant, plane);
    } else {
      for (int l = 0; l < lanes && b * lanes + l < src.shape.channels; ++l) {
        const auto c = static_cast<std::size_t>(b * lanes + l);
        for (int i = 0; i < plane.rows; ++i)
          for (int j = 0; j < plane.columns; ++j) {
            float& x = plane.data[i * plane.row + j * lanes + l];
            x = std::fma(x, step.affine.scale[c], step.affine.shift[c]);
          }
      }
    }
    if (step.relu) kernels<float>().relu_forward(plane);
    if (!step.pool) continue;
    PoolShape shape = step.pool->shape;
    shape.channels = 1;
    pool_forward(step.pool->kind, shape, View<const float>{values, 0, 0, src.row()},
                 View<float>{at(dst) + b * dst.block(), 0, 0, dst.row()});
  }
}

std::size_t SingleNetwork::weight_bytes() const {
  std::size_t values = 0;
  for (const Step& step : steps_) values += step.weight.size() + step.bias.size();
  return values * sizeof(float);
}

std::size_t SingleNetwork::activation_bytes() const {
  return memory_.size() * sizeof(float);
}

}  // namespace decid::nn
