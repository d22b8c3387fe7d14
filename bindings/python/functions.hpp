// Losses, samples and optimisers that are Python functions. nn::fit calls them from its own thread, in the order of its
// steps, so no result depends on the number of threads. The functions get arrays of their own, and may keep them. A
// function's exception passes through nn::fit, and the call of fit() raises it.
#pragma once

#include <pybind11/stl.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "bindings/python/errors.hpp"
#include "bindings/python/network.hpp"
#include "nn/fit.hpp"

namespace decid::python {

using FloatsIn = py::array_t<float, py::array::c_style | py::array::forcecast>;
/// An array's axes, or a sample's: the array's without the first.
using Axes = std::vector<py::ssize_t>;

inline Axes with_first(py::ssize_t count, const Axes& sample) {
  Axes axes{count};
  axes.insert(axes.end(), sample.begin(), sample.end());
  return axes;
}

/// Returns the axes of a sample's output, as predict() gives it.
inline Axes output_axes(const Network& network) {
  const nn::Shape shape = network.output_shape();
  Axes axes{shape.channels};
  if (shape.rows > 1 || shape.columns > 1) axes.insert(axes.end(), {shape.rows, shape.columns});
  return axes;
}

template <class Array>
void require_size(const Array& array, std::size_t size, const char* where) {
  if (array.size() != static_cast<py::ssize_t>(size))
    throw Error(Code::size_mismatch, where,
                "has an array of " + std::to_string(array.size()) + " values instead of " + std::to_string(size),
                "leave its shape, and write its values");
}

/// Copies the values of an array that a function had. It may have resized it.
template <class Array, class T>
void copy_values(const Array& from, std::span<T> to, const char* where) {
  require_size(from, to.size(), where);
  std::copy_n(from.data(), to.size(), to.begin());
}

/// call(outputs, targets) returns each sample's loss, and the derivatives of their mean by the outputs.
class FunctionLoss final : public nn::BatchLoss {
 public:
  FunctionLoss(py::object call, const std::string& name, Axes target, Network& network)
      : call_(std::move(call)), text_("python " + name), target_(std::move(target)), network_(network) {}

  void batch(std::span<const double> outputs, std::span<const double> targets, std::span<double> losses,
             std::span<double> diffs) const override {
    const py::gil_scoped_acquire locked;
    const auto scope = in_callback(network_);
    const auto count = static_cast<py::ssize_t>(losses.size());
    const py::tuple found = call_(py::array_t<double>(with_first(count, output_axes(network_)), outputs.data()),
                                  py::array_t<double>(with_first(count, target_), targets.data()));
    copy_values(found[0].cast<DoublesIn>(), losses, "loss");
    copy_values(found[1].cast<DoublesIn>(), diffs, "loss");
  }
  int targets(int) const override {
    py::ssize_t values = 1;
    for (const py::ssize_t extent : target_) values *= extent;
    return static_cast<int>(values);
  }
  std::string text() const override { return text_; }

 private:
  py::object call_;
  std::string text_;
  Axes target_;  // of a sample
  Network& network_;
};

/// call(value, gradient, learning rate, step, *memory) changes a parameter's values and its memory. If it raises, the
/// parameters get back the values that they had before the step.
class FunctionOptimiser final : public nn::Optimiser {
 public:
  FunctionOptimiser(py::object call, const std::string& name, int memory, Network& network)
      : call_(std::move(call)), text_("python " + name), memory_(memory), network_(network) {}

  void update(const Values& v, double learning_rate, long long step) const override {
    const py::gil_scoped_acquire locked;
    const auto scope = in_callback(network_);
    if (step != step_) before_.clear();
    step_ = step;
    before_.push_back({v.value, {v.value, v.value + v.count}});
    try {
      const auto array = [axes = Axes(v.shape.begin(), v.shape.end())](const float* values) {
        return py::array_t<float>(axes, values);
      };
      const py::array_t<float> value = array(v.value);
      std::vector<py::array_t<float>> kept;
      for (int k = 0; k < memory_; ++k) kept.push_back(array(v.memory[k]));
      const py::object result = call_(value, array(v.gradient), learning_rate, step, *py::cast(kept));
      if (!result.is_none())
        throw Error(Code::setting_malformed, "optimiser", "returns a value, which fit() does not use",
                    "change value and the memory in place (value -= ...), and return None");
      copy_values(value, std::span(v.value, v.count), "optimiser");
      for (std::size_t k = 0; k < kept.size(); ++k) copy_values(kept[k], std::span(v.memory[k], v.count), "optimiser");
    } catch (...) {
      for (const auto& [to, values] : before_) std::ranges::copy(values, to);
      throw;
    }
  }
  bool whole_parameters() const override { return true; }
  int memory() const override { return memory_; }
  std::string text() const override { return text_ + " " + std::to_string(memory_); }

 private:
  py::object call_;
  std::string text_;
  int memory_;
  Network& network_;
  // Parameters that the step has changed, with their values before it. Only the thread of fit() uses these.
  mutable std::vector<std::pair<float*, std::vector<float>>> before_;
  mutable long long step_ = 0;
};

/// The counted random numbers of some samples in an epoch. Each call goes on with the next numbers of each sample.
class SamplesRandom {
 public:
  explicit SamplesRandom(std::span<const Random> random) : random_(random.begin(), random.end()) {}

  /// Returns (samples, count) numbers.
  py::array_t<double> uniform(py::ssize_t count) {
    return draw(count, [this](const Random& random, std::span<double> to) {
      for (std::size_t i = 0; i < to.size(); ++i) to[i] = random.uniform(next_ + i);
    });
  }
  py::array_t<double> normal(py::ssize_t count) {
    return draw(count, [this](const Random& random, std::span<double> to) { random.fill_normal(to, next_); });
  }

 private:
  template <class Fill>
  py::array_t<double> draw(py::ssize_t count, const Fill& fill) {
    py::array_t<double> numbers({static_cast<py::ssize_t>(random_.size()), count});  // refuses a negative count
    const auto width = static_cast<std::size_t>(count);
    for (std::size_t i = 0; i < random_.size(); ++i) fill(random_[i], {numbers.mutable_data() + i * width, width});
    next_ += width;
    return numbers;
  }

  std::vector<Random> random_;
  std::uint64_t next_ = 0;
};

/// Samples of arrays, which it keeps, or of a function: load(samples, epoch, random, inputs, targets) writes them.
struct GivenSamples {
  FloatsIn inputs, targets;
  int count = 0;
  py::object load = {};
  Axes target = {};  ///< of a sample
};

/// Writes samples of a function. The arrays that it gets are NaN as nn::fit's are, which refuses values that it does
/// not write.
inline void load_samples(const GivenSamples& given, Network& network, const nn::Samples::Batch& batch) {
  const py::gil_scoped_acquire locked;
  const auto scope = in_callback(network);
  const auto count = static_cast<py::ssize_t>(batch.samples.size());
  const nn::Shape shape = network.input_shape();
  const py::array_t<float> inputs(with_first(count, {shape.channels, shape.rows, shape.columns}), batch.inputs.data());
  py::array_t<float> targets(with_first(count, given.target));
  require_size(targets, batch.targets.size(), "samples' targets");
  std::ranges::copy(batch.targets, targets.mutable_data());
  given.load(py::array_t<int>(count, batch.samples.data()), batch.epoch,
             batch.random.empty() ? py::none() : py::cast(SamplesRandom(batch.random)), inputs, targets);
  copy_values(inputs, batch.inputs, "samples' inputs");
  copy_values(targets, batch.targets, "samples' targets");
}

}  // namespace decid::python
