// Tests of the derivatives in nn/: backward passes against central differences of the loss, in double.
// The difference of step h errs by h^2 / 6 of the third derivative and by the loss's rounding error over h; both are
// smallest together for h near epsilon^(1/3). A step that carries a value across a kink of ReLU or past the runner-up
// of a maximum is left out: its pattern of active values differs between x - h, x and x + h.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <limits>

#include "nn/training/loss.hpp"
#include "nn/training/trainer.hpp"
#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

struct Deviation {
  double worst = 0;  // relative error as defined in `relative_error`
  int checked = 0, kinks = 0;
};

class GradientCheck {
 public:
  GradientCheck(Chain<double>& chain, std::uint32_t id) : chain_(chain) {
    std::uint32_t next = 100 * id;
    for (Parameter<double>* p : chain.parameters()) {
      const double offset = p->name == "gamma" ? 1.0 : 0.0;
      const double scale = p->fan_in > 0 ? std::sqrt(6.0 / p->fan_in) : 0.4;
      p->value = hashed_values<double>(next++, p->value.size(), scale, offset);
    }
    for (RunningStatistics<double>* s : chain.statistics()) statistics_.push_back(s->value);
    const auto count = [&](const TensorView<double>& t) {
      return static_cast<std::size_t>(t.batch()) * static_cast<std::size_t>(t.shape().size());
    };
    load_batch(chain.input(), input_ = hashed_values<double>(next++, count(chain.input()), 1.5, 0.2));
    targets_ = hashed_values<double>(next++, count(chain.output()));
    fill_unused_lanes(chain.input(), std::numeric_limits<double>::quiet_NaN());
  }

  /// Mean square of output - target over all values, summed in long double: what rounds is the network, not the sum.
  double loss() {
    // In-place layers overwrite the input; BatchNorm's pivot moves with its running mean.
    load_batch(chain_.input(), input_);
    const auto statistics = chain_.statistics();
    for (std::size_t i = 0; i < statistics.size(); ++i) statistics[i]->value = statistics_[i];
    chain_.forward();
    const std::vector<double> output = store_batch(chain_.output());
    long double sum = 0;
    for (std::size_t i = 0; i < output.size(); ++i) {
      const long double error = static_cast<long double>(output[i]) - static_cast<long double>(targets_[i]);
      sum += error * error;
    }
    return static_cast<double>(sum / static_cast<long double>(output.size()));
  }

  /// Compares the derivatives of all parameters and of the input; of tensors larger than `most` a sample of them.
  Deviation run(std::size_t most) {
    loss_ = loss();
    pattern_ = pattern();
    std::vector<double> diff = store_batch(chain_.output());
    for (std::size_t i = 0; i < diff.size(); ++i)
      diff[i] = 2 * (diff[i] - targets_[i]) / static_cast<double>(diff.size());
    fill_unused_lanes(chain_.output_diff(), std::numeric_limits<double>::quiet_NaN());
    load_batch(chain_.output_diff(), diff);
    chain_.backward();
    std::vector<std::vector<double>> gradients;
    for (std::size_t k = 0; k < chain_.parameters().size(); ++k) gradients.push_back(chain_.gradient(k));
    const std::vector<double> input_gradient = store_batch(chain_.input_diff());

    Deviation stddev;
    std::uint32_t id = 7;
    const auto compare = [&](std::vector<double>& values, const std::vector<double>& analytic) {
      const bool all = values.size() <= most;
      for (std::size_t i = 0; i < (all ? values.size() : most); ++i) {
        const auto drawn = static_cast<std::size_t>((hashed(id, i) + 1) / 2 * static_cast<double>(values.size()));
        compare_one(values[all ? i : drawn], analytic[all ? i : drawn], stddev);
      }
      ++id;
    };
    const auto parameters = chain_.parameters();
    for (std::size_t k = 0; k < parameters.size(); ++k) compare(parameters[k]->value, gradients[k]);
    compare(input_, input_gradient);
    return stddev;
  }

 private:
  void compare_one(double& value, double analytic, Deviation& stddev) {
    const double kept = value, step = std::cbrt(epsilon) * std::max(1.0, std::abs(kept));
    value = kept + step;
    const double right = value, loss_right = loss();
    const bool kink_right = pattern() != pattern_;
    value = kept - step;
    const double left = value, loss_left = loss();
    const bool kink = kink_right || pattern() != pattern_;
    value = kept;
    ++stddev.checked;
    if (kink) {
      ++stddev.kinks;
      return;
    }
    const double numeric = (loss_right - loss_left) / (right - left);
    // The losses round to a few epsilon of themselves. A derivative so small that this alone makes 1e-6 of it is
    // compared to that much.
    const double scale = 4 * epsilon * loss_ / step / 1e-6;
    const double error = std::abs(analytic - numeric) / std::max({std::abs(analytic), std::abs(numeric), scale});
    stddev.worst = std::isnan(error) ? std::numeric_limits<double>::infinity() : std::max(stddev.worst, error);
  }

  /// Which values pass each ReLU and which win each maximum, hashed (FNV-1a).
  std::uint64_t pattern() const {
    std::uint64_t hash = 0xcbf29ce484222325u;
    for (std::size_t i = 0; i < chain_.layers().size(); ++i) {
      const TensorView<double>&src = chain_.activations()[i], &dst = chain_.activations()[i + 1];
      const std::string text = chain_.layers()[i].text();
      int rows = 1, columns = 1, stride_rows = 1, stride_columns = 1;
      const bool maximum =
          std::sscanf(text.c_str(), "maxpool %dx%d stride %dx%d", &rows, &columns, &stride_rows, &stride_columns) == 4;
      if (!maximum && text != "relu") continue;
      const Shape& s = dst.shape();
      for (int v = 0; v < dst.batch() * s.size(); ++v) {
        const int n = v / s.size(), c = v / (s.rows * s.columns) % s.channels, y = v / s.columns % s.rows,
                  x = v % s.columns;
        const double value = dst.at(n, c, y, x);
        for (int k = 0; k < rows * columns; ++k) {
          const bool on = maximum
                              ? src.at(n, c, y * stride_rows + k / columns, x * stride_columns + k % columns) == value
                              : value > 0;
          hash = (hash ^ static_cast<std::uint64_t>(on)) * 0x100000001b3u;
        }
      }
    }
    return hash;
  }

  Chain<double>& chain_;
  std::vector<double> input_, targets_;
  std::vector<std::vector<double>> statistics_;
  double loss_ = 0;
  std::uint64_t pattern_ = 0;
};

void check_gradients(Shape input, const std::string& architecture, std::uint32_t id, std::size_t most = 40) {
  CAPTURE(architecture);
  const OneThread one_thread;
  for (const int batch : {3, 16, 19}) {
    CAPTURE(batch);
    Chain<double> chain(input, architecture, batch);
    GradientCheck check(chain, id + static_cast<std::uint32_t>(batch));
    const Deviation stddev = check.run(most);
    CHECK(stddev.worst < 1e-6);
    CHECK(stddev.checked >= 3);
    CHECK(stddev.kinks * 20 <= stddev.checked);
  }
}

}  // namespace

TEST_CASE("gradients: convolutions") {
  check_gradients({3, 5, 4}, "conv 4 1x1", 1000);
  check_gradients({2, 6, 5}, "conv 3 3x3", 1100);
  check_gradients({2, 6, 5}, "conv 3 3x3 pad 1", 1200);
  check_gradients({2, 6, 5}, "conv 3 3x3 pad 2", 1300);
  check_gradients({2, 7, 6}, "conv 2 5x5 pad 2", 1400);
  check_gradients({2, 7, 6}, "conv 2 5x3 pad 0x2", 1500);
  check_gradients({1, 6, 7}, "conv 3 5x5 pad 4", 1600);
  check_gradients({2, 7, 6}, "conv 3 3x3 stride 2", 1700);
  check_gradients({2, 7, 6}, "conv 3 3x3 stride 2 pad 1", 1800);
  check_gradients({2, 7, 6}, "conv 3 3x3 stride 2x1 pad 1x0", 1900);
  check_gradients({2, 8, 9}, "conv 3 5x5 stride 3 pad 2", 2000);
  check_gradients({2, 8, 9}, "conv 3 2x4 stride 3x2 pad 1x3", 2100);
  check_gradients({3, 7, 8}, "conv 4 1x1 stride 3", 2200);
  check_gradients({2, 3, 4}, "conv 3 3x4", 2300);
  check_gradients({17, 2, 3}, "conv 18 2x2 pad 1", 2400);  // more channels than a group
}

TEST_CASE("gradients: batch normalisation") {
  check_gradients({3, 4, 5}, "batchnorm", 3000, 60);
  check_gradients({9, 1, 1}, "batchnorm", 3100, 60);  // more channels than a group
}

TEST_CASE("gradients: ReLU and pooling") {
  check_gradients({3, 4, 5}, "relu", 4000, 180);
  check_gradients({2, 6, 4}, "maxpool 2", 4100, 96);
  check_gradients({2, 7, 5}, "maxpool 2", 4200, 96);           // a row and a column left out
  check_gradients({2, 7, 5}, "maxpool 3 stride 2", 4300, 96);  // windows overlap
  check_gradients({9, 5, 6}, "maxpool 2x3 stride 1x2", 4400, 96);
  check_gradients({2, 5, 7}, "maxpool 2 stride 3", 4500, 96);  // windows leave values out
  check_gradients({2, 6, 4}, "avgpool 2", 4600, 96);
  check_gradients({2, 7, 5}, "avgpool 2", 4700, 96);
  check_gradients({2, 7, 5}, "avgpool 3 stride 2", 4800, 96);
  check_gradients({9, 5, 6}, "avgpool 2x3 stride 1x2", 4900, 96);
  check_gradients({2, 5, 7}, "avgpool 2 stride 3", 5000, 96);
  check_gradients({3, 4, 5}, "globalavgpool", 5100, 96);
  check_gradients({3, 4, 5}, "statspool", 5200, 96);
  check_gradients({9, 7, 1}, "statspool", 5300, 96);
}

TEST_CASE("gradients: fully connected") {
  check_gradients({2, 3, 4}, "fc 5", 6000, 60);
  check_gradients({9, 1, 1}, "fc 34", 6100, 60);                         // more outputs than a group
  check_gradients({2, 3, 2}, "fc 3; conv 2 3x3 pad 1; fc 2", 6200, 60);  // outputs with a halo
}

TEST_CASE("gradients: networks") {
  check_gradients({2, 8, 8},
                  "conv 4 3x3 pad 1; batchnorm; relu; maxpool 2; conv 3 3x3 pad 1; batchnorm; relu; avgpool 2; fc 3",
                  7000);
  check_gradients({2, 9, 8}, "conv 4 3x3 stride 2 pad 1; relu; batchnorm; conv 3 2x2; relu; globalavgpool; fc 3", 7100);
  check_gradients({2, 9, 1}, "conv 4 3x1 pad 1x0; batchnorm; relu; statspool; fc 6; relu; fc 2", 7300);
  check_gradients({1, 7, 7}, "batchnorm; conv 3 5x5 pad 2; relu; maxpool 3 stride 2; fc 6; relu; fc 2", 7200);
}

// A Trainer fuses lines and shares memory among tensors: neither may change a bit.
TEST_CASE_TEMPLATE("gradients: a Trainer's are those of its network's lines one by one", T, float, double) {
  struct Case {
    Shape shape;
    const char* architecture;
  };
  const Shape square{2, 8, 8};
  const Case cases[]{
      {square, "conv 4 3x3 pad 1; batchnorm; relu; maxpool 2; conv 3 3x3 pad 1; batchnorm; relu; avgpool 2; fc 3"},
      {square, "conv 4 3x3 stride 2 pad 1; relu; batchnorm; conv 3 2x2; relu; globalavgpool; fc 3"},
      {square,
       "batchnorm; conv 3 5x5 pad 4; relu; relu; conv 2 3x3 stride 2; maxpool 2; fc 6; relu; conv 5 3x3 pad 2; fc 3"},
      {square,
       "batchnorm; maxpool 3; conv 9 3x3 pad 2; batchnorm; relu; maxpool 2 stride 1; conv 2 1x1; batchnorm; "
       "avgpool 2x1; batchnorm; relu; globalavgpool; batchnorm; batchnorm; relu; fc 3"},
      {square, "conv 4 3x3 stride 2 pad 1; batchnorm; relu; statspool; conv 3 3x3 pad 1; relu; fc 3"},
      {{1, 61, 90},
       "batchnorm; relu; conv 2 3x3 pad 1; batchnorm; relu; maxpool 2; batchnorm; relu; avgpool 7x3; fc 3"},
  };
  const OneThread one_thread;
  for (const Case& one : cases) {
    for (const int batch : {3, 16, 19}) {
      const Shape shape = one.shape;
      const std::string architecture = one.architecture;
      CAPTURE(architecture);
      CAPTURE(batch);
      Network<T> network(shape, architecture);
      network.initialise(5);
      Trainer<T> trainer(network, batch);
      const auto samples = static_cast<std::size_t>(batch);
      const auto input = hashed_values<T>(1, samples * static_cast<std::size_t>(shape.size()));
      const auto targets = hashed_values<T>(2, samples * 3);
      load_batch(trainer.input(), input);
      trainer.forward();
      std::vector<double> parts(6), chain_parts(6);
      squared_errors<T>(trainer.output(), targets, batch, parts, trainer.output_diff());
      trainer.backward();

      Chain<T> chain(shape, architecture, batch);
      const auto parameters = network.parameters(), chain_parameters = chain.parameters();
      REQUIRE(chain_parameters.size() == parameters.size());
      for (std::size_t k = 0; k < parameters.size(); ++k) chain_parameters[k]->value = parameters[k]->value;
      load_batch(chain.input(), input);
      chain.forward();
      squared_errors<T>(chain.output(), targets, batch, chain_parts, chain.output_diff());
      CHECK(store_batch(chain.output()) == store_batch(trainer.output()));
      CHECK(chain_parts == parts);
      chain.backward();
      for (std::size_t k = 0; k < parameters.size(); ++k) {
        CAPTURE(k);
        CHECK(std::ranges::equal(chain.gradient(k), trainer.gradient(k)));
      }
      std::size_t k = 0;
      for (const Layer<T>& layer : network.layers())
        for (const RunningStatistics<T>& s : layer.statistics()) CHECK(chain.statistics()[k++]->value == s.value);
      CHECK(k == chain.statistics().size());

      const Inference<T> inference(network);
      BatchExecutor<T> executor(inference, batch);
      load_batch(executor.input(), input);
      executor.forward();
      load_batch(chain.input(), input);
      chain.infer();
      // In inference BatchNorm is folded into the convolution's weights: each is rounded once more, and so is each
      // product. Sums of at most 36 terms, two layers deep, of values of order one.
      const auto by_lines = store_batch(chain.output()), folded = store_batch(executor.output());
      const T tolerance = T(2 * 2 * (36 + 3)) * std::numeric_limits<T>::epsilon();
      for (std::size_t i = 0; i < folded.size(); ++i)
        CHECK(std::abs(by_lines[i] - folded[i]) <= tolerance * std::max(T(1), std::abs(by_lines[i])));
    }
  }
}
