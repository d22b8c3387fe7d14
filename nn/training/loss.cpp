// Losses: see loss.hpp. First those of nn::fit, a sample at a time; then the mean squared error of whole blocks.
#include "nn/training/loss.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/number.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "nn/detail/finite.hpp"
#include "nn/kernels/kernels.hpp"
#include "nn/training/detail/classes.hpp"

namespace decid::nn {
namespace {

class SquaredError final : public Loss {
 public:
  double sample(std::span<const double> output, std::span<const double> target, std::span<double> diff) const override {
    const auto count = static_cast<double>(output.size());
    double sum = 0;
    for (std::size_t i = 0; i < output.size(); ++i) {
      const double error = output[i] - target[i];
      sum += error * error;
      diff[i] = 2 * error / count;
    }
    return sum / count;
  }
  std::string text() const override { return "squared-error"; }
};

class CrossEntropy final : public Loss {
 public:
  double sample(std::span<const double> output, std::span<const double> target, std::span<double> diff) const override {
    const double wanted = target.front();
    require_class(wanted, static_cast<int>(output.size()), [] { return "cross-entropy"; });
    // max_element() may pass over NaN, and decid's log of NaN is a number.
    if (!is_finite<double>(output)) {
      std::ranges::fill(diff, std::numeric_limits<double>::quiet_NaN());
      return std::numeric_limits<double>::quiet_NaN();
    }
    const double largest =
        *std::max_element(output.begin(), output.end());  // softmax may shift by it: exp stays finite
    double sum = 0;
    for (std::size_t i = 0; i < output.size(); ++i) sum += diff[i] = exp(output[i] - largest);
    for (double& probability : diff) probability /= sum;
    const auto own = static_cast<std::size_t>(wanted);
    diff[own] -= 1;
    return log(sum) - (output[own] - largest);
  }
  int targets(int) const override { return 1; }
  void require(const Shape& output) const override { require_classes(output, "cross-entropy"); }
  void require_target(std::span<const float> target, int outputs, int sample) const override {
    require_class(static_cast<double>(target.front()), outputs,
                  [&] { return format("cross-entropy, sample %d counted from 0", sample); });
  }
  std::string text() const override { return "cross-entropy"; }
};

class Huber final : public Loss {
 public:
  explicit Huber(double delta) : delta_(delta) {
    if (!(delta > 0))
      throw Error(Code::setting_out_of_range, "huber", format("has a delta of %g", delta), "give a number above 0");
  }
  double sample(std::span<const double> output, std::span<const double> target, std::span<double> diff) const override {
    const auto count = static_cast<double>(output.size());
    double sum = 0;
    for (std::size_t i = 0; i < output.size(); ++i) {
      const double error = output[i] - target[i], size = std::abs(error);
      sum += size <= delta_ ? 0.5 * error * error : delta_ * (size - 0.5 * delta_);
      diff[i] = std::clamp(error, -delta_, delta_) / count;
    }
    return sum / count;
  }
  std::string text() const override { return format("huber %.17g", delta_); }

 private:
  double delta_;
};

/// Calls body(value's place in the tensor) for all values of a sample, channel-major.
template <class T, class Body>
void for_each_place(const TensorView<T>& tensor, int block, const Body& body) {
  const Shape& s = tensor.shape();
  std::size_t k = 0;
  for (int c = 0; c < s.channels; ++c)
    for (int r = 0; r < s.rows; ++r)
      for (int j = 0; j < s.columns; ++j) body(tensor.row(block, c, r) + j * lanes, k++);
}

}  // namespace

void Loss::require(const Shape&) const {}
void Loss::require_target(std::span<const float>, int, int) const {}

void Loss::batch(std::span<const double> outputs, std::span<const double> targets, std::span<double> losses,
                 std::span<double> diffs) const {
  if (losses.empty()) return;
  const std::size_t samples = losses.size(), values = outputs.size() / samples, width = targets.size() / samples;
  constexpr std::size_t at_once = lanes;
  parallel_for(static_cast<int>((samples + at_once - 1) / at_once), [&](int block) {
    const std::size_t first = static_cast<std::size_t>(block) * at_once;
    for (std::size_t i = first; i < std::min(samples, first + at_once); ++i) {
      const std::span<double> diff = diffs.subspan(i * values, values);
      losses[i] = sample(outputs.subspan(i * values, values), targets.subspan(i * width, width), diff);
      for (double& d : diff) d /= static_cast<double>(samples);
    }
  });
}

double BatchLoss::sample(std::span<const double> output, std::span<const double> target, std::span<double> diff) const {
  double loss = 0.0;
  batch(output, target, {&loss, 1}, diff);
  return loss;
}

std::shared_ptr<const Loss> squared_error() {
  return std::make_shared<SquaredError>();
}
std::shared_ptr<const Loss> cross_entropy() {
  return std::make_shared<CrossEntropy>();
}
std::shared_ptr<const Loss> huber(double delta) {
  return std::make_shared<Huber>(delta);
}

std::shared_ptr<const Loss> loss_named(const std::string& text) {
  if (text == "squared-error") return squared_error();
  if (text == "cross-entropy") return cross_entropy();
  if (text == "huber") return huber();
  if (text.starts_with("huber "))
    if (const std::optional<double> delta = number_from<double>(text.substr(6))) return huber(*delta);
  throw Error(Code::setting_unknown, "loss '" + text + "'", "is not known",
              "give squared-error, cross-entropy, huber or 'huber DELTA'");
}

template <class T>
double total_loss(const Loss& loss, const std::type_identity_t<TensorView<const T>>& output,
                  std::type_identity_t<std::span<const T>> targets, const TensorView<T>& diff) {
  const auto outputs = static_cast<std::size_t>(output.shape().size());
  const auto width = static_cast<std::size_t>(loss.targets(output.shape().size()));
  const int batch = output.batch();
  loss.require(output.shape());
  if (diff.shape() != output.shape() || diff.batch() != batch)
    throw Error(Code::size_mismatch, loss.text(), "has derivatives of another shape than the outputs",
                "give a tensor of the same shape");
  if (targets.size() < width * static_cast<std::size_t>(batch))
    throw Error(Code::size_mismatch, loss.text(),
                format("has %zu target values for %d samples of %zu", targets.size(), batch, width),
                "give a target for each sample");
  const auto samples = static_cast<std::size_t>(batch);
  std::vector<double> losses(samples), values(samples * outputs), slopes(samples * outputs);
  const auto each_block = [&](const auto& tensor, const auto& body) {
    parallel_for(output.blocks(), [&](int block) {
      for_each_place(tensor, block, [&](auto* lane, std::size_t k) {
        for (int l = 0; l < lanes; ++l)
          body(lane[l], static_cast<std::size_t>(block * lanes + l) * outputs + k, l < output.valid_lanes(block));
      });
    });
  };
  each_block(output, [&](const T& x, std::size_t place, bool valid) {
    if (valid) values[place] = static_cast<double>(x);
  });
  const std::vector<double> wanted(targets.begin(), targets.begin() + static_cast<std::ptrdiff_t>(samples * width));
  loss.batch(values, wanted, losses, slopes);
  each_block(diff, [&](T& d, std::size_t place, bool valid) { d = valid ? static_cast<T>(slopes[place]) : T(0); });
  double sum = 0;
  for (const double one : losses) sum += one;
  return sum;
}

template double total_loss<float>(const Loss&, const TensorView<const float>&, std::span<const float>,
                                  const TensorView<float>&);
template double total_loss<double>(const Loss&, const TensorView<const double>&, std::span<const double>,
                                   const TensorView<double>&);

namespace {

/// The squared errors of one output of a block; its derivatives are written.
template <class T>
double compute_errors(const TensorView<const T>& output, std::span<const T> targets, T factor, int block, int o,
                      const TensorView<T>& diff) {
  const auto width = static_cast<std::size_t>(output.shape().channels);
  std::array<double, lanes> squared{};
  for (int l = 0; l < lanes; ++l) {
    const int sample = block * lanes + l;
    T gradient = T(0);
    if (sample < output.batch()) {
      const T error =
          output.row(block, o, 0)[l] - targets[static_cast<std::size_t>(sample) * width + static_cast<std::size_t>(o)];
      squared[static_cast<std::size_t>(l)] = static_cast<double>(error) * static_cast<double>(error);
      gradient = factor * error;
    }
    diff.row(block, o, 0)[l] = gradient;
  }
  tree_sum(squared.data(), lanes, 1, 1);
  return squared[0];
}

}  // namespace

template <class T>
void squared_errors(const std::type_identity_t<TensorView<const T>>& output,
                    std::type_identity_t<std::span<const T>> targets, int batch, std::span<double> parts,
                    const TensorView<T>& diff) {
  const int outputs = output.shape().channels, samples = output.batch();
  if (output.shape() != Shape{outputs, 1, 1} || diff.shape() != output.shape() || diff.batch() != samples)
    throw Error(Code::size_mismatch, "mean squared error", "of tensors that are not both (outputs, 1, 1) of one batch",
                "give a fully connected layer's output and a derivative of its shape");
  if (parts.size() < static_cast<std::size_t>(output.blocks() * outputs) ||
      targets.size() < static_cast<std::size_t>(samples) * static_cast<std::size_t>(outputs))
    throw Error(Code::size_mismatch, "mean squared error",
                format("%zu targets and %zu sums for a batch of %d with %d outputs", targets.size(), parts.size(),
                       samples, outputs),
                "give a target for each output of each sample, a sum for each output");
  const T slope = T(2) / static_cast<T>(static_cast<long long>(batch) * outputs);
  std::size_t i = 0;
  for (int block = 0; block < output.blocks(); ++block)
    for (int o = 0; o < outputs; ++o) parts[i++] = compute_errors(output, targets, slope, block, o, diff);
}

template void squared_errors<float>(const TensorView<const float>&, std::span<const float>, int, std::span<double>,
                                    const TensorView<float>&);
template void squared_errors<double>(const TensorView<const double>&, std::span<const double>, int, std::span<double>,
                                     const TensorView<double>&);

}  // namespace decid::nn
