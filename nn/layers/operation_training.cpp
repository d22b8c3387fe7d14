// An Operation in training: the parameters it reads, and the memory that its gradients go to.
#include <optional>

#include "nn/layers/detail/training_layers.hpp"
#include "nn/operation.hpp"

namespace decid::nn {
namespace {

template <class T>
class OperationTraining final : public TrainingLayer<T> {
 public:
  OperationTraining(Layer<T>& layer, const Extension& extension, int max_batch)
      : TrainingLayer<T>(layer),
        operation_(extension.operation),
        parts_(layer.parameters().size()),
        parameters_(parts_.size()) {
    for (std::size_t k = 0; k < parts_.size(); ++k) {
      const std::vector<T>& value = layer.parameters()[k].value;
      parts_[k].reserve(TensorView<T>::count_blocks(max_batch) * value.size());
      to_.push_back(parts_[k].data());
      gradients_.push_back({parts_[k].data(), this->gradient(k)});
    }
  }

  Halo src_halo() const override { return operation_->src_halo(); }
  Halo diff_dst_halo() const override { return operation_->diff_dst_halo(); }
  bool backward_reads_dst() const override { return operation_->backward_reads_dst(); }
  bool is_random() const override { return operation_->is_random(); }
  void set_random(const Random& random) override { random_ = random; }

  void forward(const TensorView<const T>& src, const TensorView<T>& dst) override {
    operation_->forward(ForwardPass<T>{src, dst, parameters(), random()});
  }
  void backward(const TensorView<const T>& src, const TensorView<const T>& dst, const TensorView<T>& diff_dst,
                const TensorView<T>* diff_src) override {
    operation_->backward(BackwardPass<T>{src, dst, diff_dst, diff_src, parameters(), random(), to_});
    if (!gradients_.empty()) sum_gradients<T>(gradients_, src.blocks(), this->all_reduce());
  }

 private:
  StepRandom random() const {
    if (!random_) return {};
    AllReduce<T>* const ranks = this->all_reduce();
    return {&*random_, ranks != nullptr ? std::span<const int>(ranks->partition().blocks) : std::span<const int>()};
  }
  /// Reads the current values, because a program may have changed them.
  std::span<const std::span<const T>> parameters() {
    for (std::size_t k = 0; k < parameters_.size(); ++k) parameters_[k] = this->value(k);
    return parameters_;
  }

  std::shared_ptr<const Operation> operation_;
  std::vector<AlignedBuffer<T>> parts_;  // gradients of each block of samples
  std::vector<std::span<const T>> parameters_;
  std::vector<T*> to_;
  std::vector<typename AllReduce<T>::Gradient> gradients_;
  std::optional<Random> random_;
};

}  // namespace

template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Extension& extension, int max_batch) {
  return std::make_unique<OperationTraining<T>>(layer, extension, max_batch);
}

template std::unique_ptr<TrainingLayer<float>> make_training(Layer<float>&, const Extension&, int);
template std::unique_ptr<TrainingLayer<double>> make_training(Layer<double>&, const Extension&, int);

}  // namespace decid::nn
