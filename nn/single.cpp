// One sample at a time through the steps of inference: see single.hpp.
#include "nn/single.hpp"

#include <algorithm>
#include <cmath>

#include "nn/detail/forward.hpp"
#include "nn/operation.hpp"

namespace decid::nn {
namespace {

/// Blocks of channels that one thread computes at a time: a tile's two.
constexpr int block_group = 2;

/// body(value's place in its map from row 0, column 0 on, number of the value) for each value, channel-major.
template <class M, class Body>
void for_each_place(const M& map, const Body& body) {
  std::size_t k = 0;
  for (int c = 0; c < map.shape.channels; ++c)
    for (int i = 0; i < map.shape.rows; ++i)
      for (int j = 0; j < map.shape.columns; ++j)
        body(c / lanes * map.block() + i * map.row() + j * lanes + c % lanes, k++);
}

}  // namespace

SingleExecutor::SingleExecutor(const Inference<float>& inference) : inference_(inference) {
  maps_.push_back({inference.input_shape()});
  for (const Step<float>& step : inference.steps()) {
    Edge way{.src = maps_.size() - 1, .dst = maps_.size() - 1, .offset = {}};
    if (step.kind == Step<float>::Kind::operation)
      batch_.reserve(TensorView<float>::required(step.src, 1, step.halo()) +
                     TensorView<float>::required(step.dst, 1, {}));
    if (step.sums()) maps_.back().halo = larger(maps_.back().halo, src_halo(step.conv));
    if (!step.in_place()) {
      way.dst = maps_.size();
      maps_.push_back({step.dst});
    }
    edges_.push_back(std::move(way));
  }
  std::size_t values = 0;
  for (Map& map : maps_) {
    map.offset = values;
    values += map.values();
  }
  memory_.reserve(values);
  // Taps in the order of the batch kernels' chains: channel, row, column.
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const Step<float>& step = inference.steps()[i];
    if (!step.sums()) continue;
    const Map& src = maps_[edges_[i].src];
    for (int c = 0; c < step.conv.src_channels; ++c)
      for (int ky = 0; ky < step.conv.kernel_rows; ++ky)
        for (int kx = 0; kx < step.conv.kernel_columns; ++kx)
          edges_[i].offset.push_back(c / lanes * src.block() + (ky - step.conv.pad_rows) * src.row() +
                                     (kx - step.conv.pad_columns) * lanes + c % lanes);
  }
}

void SingleExecutor::load(std::span<const float> image) {
  float* const to = at(maps_.front());
  for_each_place(maps_.front(), [&](std::ptrdiff_t place, std::size_t k) { to[place] = image[k]; });
}

void SingleExecutor::store(const Map& map, std::span<float> values) {
  const float* const from = at(map);
  for_each_place(map, [&](std::ptrdiff_t place, std::size_t k) { values[k] = from[place]; });
}

void SingleExecutor::run_steps(std::size_t count) {
  kept_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const Step<float>& step = inference_.steps()[i];
    if (step.sums())
      convolve(step, edges_[i]);
    else if (step.kind == Step<float>::Kind::statistics)
      take_statistics(edges_[i]);
    else if (step.kind == Step<float>::Kind::branch)
      store(maps_[edges_[i].src], kept_.emplace_back(static_cast<std::size_t>(step.src.size())));
    else if (step.kind == Step<float>::Kind::join)
      join(step, edges_[i]);
    else if (step.kind == Step<float>::Kind::operation)
      operate(step, edges_[i]);
    else
      activate(step, edges_[i]);
  }
}

void SingleExecutor::run(std::span<const float> image, std::span<float> output, std::span<float> features) {
  load(image);
  run_steps(edges_.size());
  store(maps_.back(), output);
  if (!features.empty()) store(maps_[edges_.back().src], features);
}

void SingleExecutor::activation(std::size_t step, std::span<const float> image, std::span<float> values) {
  load(image);
  run_steps(step + 1);
  store(maps_[edges_[step].dst], values);
}

void SingleExecutor::convolve(const Step<float>& step, const Edge& way) {
  const Map &src = maps_[way.src], &dst = maps_[way.dst];
  const SingleConv<float> conv{dst.shape.rows,
                               dst.shape.columns,
                               at(src),
                               step.conv.stride_rows * src.row(),
                               static_cast<std::ptrdiff_t>(step.conv.stride_columns) * lanes,
                               way.offset.data(),
                               static_cast<int>(way.offset.size()),
                               step.lane_weight.data(),
                               step.lane_bias.data(),
                               at(dst),
                               dst.block(),
                               dst.row()};
  for_each_group(1, dst.blocks(), block_group,
                 [&](int, int first, int last) { kernels<float>().conv2d_single(conv, first, last); });
}

void SingleExecutor::take_statistics(const Edge& way) {
  const Map &src = maps_[way.src], &dst = maps_[way.dst];
  float mean[lanes], stddev[lanes];
  const auto put = [&](int channel, float value) { at(dst)[channel / lanes * dst.block() + channel % lanes] = value; };
  for (int b = 0; b < src.blocks(); ++b) {
    const Plane<const float> plane{at(src) + b * src.block(), src.row(), src.shape.rows, src.shape.columns};
    kernels<float>().statistics_pool_forward(plane, static_cast<float>(StatisticsPool::epsilon), mean, stddev);
    for (int l = 0; l < lanes && b * lanes + l < src.shape.channels; ++l) {
      put(b * lanes + l, mean[l]);
      put(src.shape.channels + b * lanes + l, stddev[l]);
    }
  }
}

void SingleExecutor::join(const Step<float>& step, const Edge& way) {
  const Map& dst = maps_[way.dst];
  const std::vector<float>& kept = kept_.back();
  float* const to = at(dst);
  if (step.join.concatenates) {
    values_.resize(static_cast<std::size_t>(step.src.size()));
    store(maps_[way.src], values_);
    for_each_place(dst, [&](std::ptrdiff_t place, std::size_t k) {
      to[place] = k < kept.size() ? kept[k] : values_[k - kept.size()];
    });
  } else {
    for_each_place(dst, [&](std::ptrdiff_t place, std::size_t k) { to[place] = kept[k] + to[place]; });
  }
  kept_.pop_back();
}

void SingleExecutor::operate(const Step<float>& step, const Edge& way) {
  const TensorView<float> src(batch_.data(), step.src, 1, step.halo());
  const TensorView<float> dst(batch_.data() + TensorView<float>::required(step.src, 1, step.halo()), step.dst, 1, {});
  // Another operation's values may lie where this one's halo and idle lanes are.
  std::fill_n(batch_.data(), TensorView<float>::required(step.src, 1, step.halo()), 0.0F);
  values_.resize(static_cast<std::size_t>(std::max(step.src.size(), step.dst.size())));
  const std::span<float> in = std::span(values_).first(static_cast<std::size_t>(step.src.size()));
  store(maps_[way.src], in);
  src.load(0, in);
  const std::vector<std::span<const float>> parameters(step.parameters.begin(), step.parameters.end());
  step.operation->forward(ForwardPass<float>{src, dst, parameters, {}});
  dst.store(0, std::span(values_).first(static_cast<std::size_t>(step.dst.size())));
  const Map& map = maps_[way.dst];
  float* const to = at(map);
  for_each_place(map, [&](std::ptrdiff_t place, std::size_t k) { to[place] = values_[k]; });
}

void SingleExecutor::activate(const Step<float>& step, const Edge& way) {
  const Map &src = maps_[way.src], &dst = maps_[way.dst];
  const Kernels<float>& k = kernels<float>();
  for (int b = 0; b < src.blocks(); ++b) {
    const Plane<float> plane{at(src) + b * src.block(), src.row(), src.shape.rows, src.shape.columns};
    if (step.affine.scale.empty()) {
      k.activation_forward({1.0F, 0.0F, step.relu, Pooling::none}, {}, plane, plane);
    } else {
      for (int l = 0; l < lanes && b * lanes + l < src.shape.channels; ++l) {
        const auto c = static_cast<std::size_t>(b * lanes + l);
        for (int i = 0; i < plane.rows; ++i)
          for (int j = 0; j < plane.columns; ++j) {
            float& x = plane.data[i * plane.row + j * lanes + l];
            x = std::fma(x, step.affine.scale[c], step.affine.shift[c]);
          }
      }
      if (step.relu) k.relu_forward(plane);
    }
    if (!step.pool) continue;
    PoolShape shape = step.pool->shape;
    shape.channels = 1;
    pool_block_forward<float>(step.pool->kind, shape, {plane.data, 0, plane.row},
                              {at(dst) + b * dst.block(), 0, dst.row()});
  }
}

}  // namespace decid::nn
