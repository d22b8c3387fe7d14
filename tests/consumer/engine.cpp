// Uses the engine alone, with a layer and a loss of its own: a line of an architecture that decid does not know,
// trained, checked by finite differences, saved and read again.
#include <cmath>
#include <cstdio>
#include <decid/nn/fit.hpp>
#include <decid/nn/network_file.hpp>
#include <decid/nn/operation.hpp>
#include <decid/nn/training/trainer.hpp>
#include <filesystem>

namespace {

namespace nn = decid::nn;

/// softsign: x / (1 + |x|).
class Softsign final : public nn::OperationOf<Softsign> {
 public:
  explicit Softsign(nn::Shape shape) : OperationOf(shape, shape) {}
  std::string text() const override { return "softsign"; }
  template <class T>
  void forward_pass(const nn::ForwardPass<T>& pass) const {
    nn::map(pass.src, pass.dst, [](T x) { return x / (1 + std::abs(x)); });
  }
  template <class T>
  void backward_pass(const nn::BackwardPass<T>& pass) const {
    nn::map_backward(pass, [](T x, T, T dy) { return dy / ((1 + std::abs(x)) * (1 + std::abs(x))); });
  }
};

/// The mean of |error|.
class AbsoluteError final : public nn::Loss {
 public:
  double sample(std::span<const double> output, std::span<const double> target, std::span<double> diff) const override {
    const auto count = static_cast<double>(output.size());
    double sum = 0;
    for (std::size_t i = 0; i < output.size(); ++i) {
      sum += std::abs(output[i] - target[i]) / count;
      diff[i] = (output[i] > target[i] ? 1 : -1) / count;
    }
    return sum;
  }
  std::string text() const override { return "absolute-error"; }
};

/// The largest difference between the gradients of the first weights and differences of the loss.
double gradient_error() {
  nn::Network<double> network({2, 1, 1}, "fc 3; softsign; fc 1");
  network.initialise(1);
  nn::Trainer<double> trainer(network, 1);
  const std::vector<double> input{0.3, -0.8};
  const auto output = [&] {
    trainer.input().load(0, input);
    trainer.forward();
    return trainer.output().at(0, 0, 0, 0);
  };
  output();
  trainer.output_diff().at(0, 0, 0, 0) = 1;
  trainer.backward();
  double worst = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    double& weight = network.parameters()[0]->value[i];
    const double kept = weight;
    weight = kept + 1e-6;
    const double right = output();
    weight = kept - 1e-6;
    const double left = output();
    weight = kept;
    worst = std::max(worst, std::abs(trainer.gradient(0)[i] - (right - left) / 2e-6));
  }
  return worst;
}

}  // namespace

int main() {
  nn::register_layer("softsign",
                     [](nn::Shape src, nn::Words&) -> nn::OperationPointer { return std::make_shared<Softsign>(src); });
  // y = x1 x2 on a grid.
  std::vector<float> inputs, targets;
  for (int i = 0; i < 400; ++i) {
    const float a = static_cast<float>(i % 20) / 10 - 1, b = static_cast<float>(i) / 200 - 1;
    inputs.insert(inputs.end(), {a, b});
    targets.push_back(a * b);
  }
  nn::Network net({2, 1, 1}, "fc 24; softsign; fc 1");
  const nn::FitLog log =
      nn::fit(net, {inputs, targets, 400},
              {.epochs = 60, .batch = 20, .learning_rate = 0.02, .loss = std::make_shared<AbsoluteError>()});
  const std::string path = "engine.safetensors";
  nn::write_network(net, path);
  const bool same = nn::predict(nn::read_network(path), inputs) == nn::predict(net, inputs);
  std::filesystem::remove(path);
  const double error = gradient_error();
  std::printf("absolute error %.3f, then %.3f; gradients differ by %.1e; %s\n", log.epochs.front().validation_loss,
              log.epochs.back().validation_loss, error, same ? "read as written" : "read otherwise");
  return log.epochs.back().validation_loss < 0.06 && error < 1e-8 && same ? 0 : 1;
}
