// Tests of the losses of nn/training/loss.hpp: derivatives by central differences, figures of PyTorch, bits.
#include "nn/training/loss.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "tests/nn/chain.hpp"

using namespace decid::nn;
using namespace decid::nn::testing;

namespace {

/// A custom loss, as another program would add it: the largest error.
class LargestError final : public Loss {
 public:
  double sample(std::span<const double> output, std::span<const double> target, std::span<double> diff) const override {
    std::size_t worst = 0;
    for (std::size_t i = 1; i < output.size(); ++i)
      if (std::abs(output[i] - target[i]) > std::abs(output[worst] - target[worst])) worst = i;
    std::ranges::fill(diff, 0.0);
    diff[worst] = output[worst] > target[worst] ? 1 : -1;
    return std::abs(output[worst] - target[worst]);
  }
  std::string text() const override { return "largest-error"; }
};

struct Batch {
  AlignedBuffer<double> memory, diff_memory;
  TensorView<double> output, diff;

  Batch(Shape shape, int batch) {
    memory.reserve(TensorView<double>::required(shape, batch, {}));
    diff_memory.reserve(TensorView<double>::required(shape, batch, {}));
    output = {memory.data(), shape, batch, {}};
    diff = {diff_memory.data(), shape, batch, {}};
  }
};

void check_derivatives(const Loss& loss, Shape shape, int batch, std::span<const double> targets) {
  CAPTURE(loss.text());
  Batch b(shape, batch);
  std::vector<double> values = hashed_values<double>(3, static_cast<std::size_t>(batch * shape.size()), 2.0);
  load_batch(b.output, values);
  fill_unused_lanes(b.output, std::numeric_limits<double>::quiet_NaN());
  fill_unused_lanes(b.diff, std::numeric_limits<double>::quiet_NaN());
  const double here = total_loss<double>(loss, b.output, targets, b.diff) / batch;
  CHECK(std::isfinite(here));
  const std::vector<double> diff = store_batch(b.diff);
  for (std::size_t i = 0; i < values.size(); i += 7) {
    constexpr double step = 1e-5;
    const auto at = [&](double value) {
      const double kept = std::exchange(values[i], value);
      load_batch(b.output, values);
      values[i] = kept;
      return total_loss<double>(loss, b.output, targets, b.diff) / batch;
    };
    // The differences err by step^2 / 6 of a third derivative of order one, and by rounding over the step.
    CHECK(std::abs(diff[i] - (at(values[i] + step) - at(values[i] - step)) / (2 * step)) < 1e-9);
  }
}

}  // namespace

TEST_CASE("losses: derivatives are differences of the loss, lanes without a sample are 0") {
  for (const int batch : {1, 16, 19}) {
    const Shape shape{3, 2, 2};
    const auto targets = hashed_values<double>(4, static_cast<std::size_t>(batch) * 12);
    std::vector<double> classes;
    for (int i = 0; i < batch; ++i) classes.push_back(i % 12);
    check_derivatives(*squared_error(), shape, batch, targets);
    check_derivatives(*huber(0.7), shape, batch, targets);
    check_derivatives(LargestError(), shape, batch, targets);
    check_derivatives(*cross_entropy(), {12, 1, 1}, batch, classes);
    Batch b(shape, batch);
    fill_unused_lanes(b.diff, std::numeric_limits<double>::quiet_NaN());
    total_loss<double>(*squared_error(), b.output, targets, b.diff);
    for (int l = batch % lanes; batch % lanes != 0 && l < lanes; ++l) CHECK(b.diff.row(batch / lanes, 0, 0)[l] == 0);
  }
}

TEST_CASE("losses: cross-entropy refuses outputs in planes, others take them") {
  for (const Shape shape : {Shape{3, 2, 1}, Shape{3, 1, 2}}) {
    Batch b(shape, 2);
    const std::vector<double> classes{0, 1};
    check_error([&] { total_loss<double>(*cross_entropy(), b.output, classes, b.diff); }, decid::Code::size_mismatch,
                "cross-entropy");
    squared_error()->require(shape);
    LargestError().require(shape);
  }
}

// PyTorch 1.13 in double: cross_entropy, mse_loss and huber_loss(delta=0.5).
TEST_CASE("losses: figures of PyTorch") {
  const std::vector<double> output{1, 2, 3, -1}, target{0.75, 0, 3.25, 1}, second{1};
  std::vector<double> diff(4);
  const auto near = [](double a, double b) { return std::abs(a - b) < 1e-15 * 8; };
  CHECK(near(cross_entropy()->sample(output, second, diff), 1.4197166463153397));
  // softmax - [0, 1, 0, 0]
  const double expected[] = {0.0889468172974043, -0.7582174828411993, 0.6572330228318554, 0.01203764271193945};
  for (std::size_t i = 0; i < 4; ++i) CHECK(near(diff[i], expected[i]));
  CHECK(squared_error()->sample(output, target, diff) == 2.03125);
  CHECK(diff == std::vector<double>{0.125, 1, -0.125, -1});
  CHECK(huber(0.5)->sample(output, target, diff) == 0.453125);
  CHECK(diff == std::vector<double>{0.0625, 0.125, -0.0625, -0.125});
  // Scores of which exp() overflows.
  CHECK(cross_entropy()->sample(std::vector<double>{2000, 0, 0, 0}, second, diff) == 2000);
}

TEST_CASE("losses: an output that is not finite gives no finite loss") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  std::vector<double> diff(3);
  for (const double bad : {nan, infinity, -infinity})
    for (std::size_t place = 0; place < 3; ++place) {
      std::vector<double> output{1, 2, 3};
      output[place] = bad;
      CHECK(std::isnan(cross_entropy()->sample(output, std::vector<double>{1}, diff)));
      for (const double d : diff) CHECK(std::isnan(d));
      CHECK_FALSE(std::isfinite(squared_error()->sample(output, std::vector<double>(3), diff)));
      CHECK_FALSE(std::isfinite(huber()->sample(output, std::vector<double>(3), diff)));
    }
}

TEST_CASE("losses: targets that do not fit are refused") {
  std::vector<double> diff(3);
  const std::vector<double> output(3);
  for (const double wrong : {-1.0, 3.0, 0.5, std::numeric_limits<double>::quiet_NaN()})
    CHECK_THROWS_AS(cross_entropy()->sample(output, std::vector<double>{wrong}, diff), decid::Error);
  CHECK_THROWS_AS(huber(0), decid::Error);
  CHECK_THROWS_AS(loss_named("hinge"), decid::Error);
  CHECK(loss_named("cross-entropy")->targets(10) == 1);
  CHECK(loss_named("huber")->text() == huber()->text());
  CHECK(loss_named("huber 0.25")->text() == huber(0.25)->text());
  check_error([] { loss_named("huber x"); }, decid::Code::setting_unknown);
  check_error([] { loss_named("huber 0"); }, decid::Code::setting_out_of_range);
  Batch b({3, 1, 1}, 4);
  CHECK_THROWS_AS(total_loss<double>(*squared_error(), b.output, std::vector<double>(11), b.diff), decid::Error);
  CHECK_THROWS_AS(total_loss<double>(*squared_error(), b.output, std::vector<double>(12), Batch({3, 1, 1}, 5).diff),
                  decid::Error);
}
