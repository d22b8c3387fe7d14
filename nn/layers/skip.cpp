// The beginning and the end of a residual or concat: the end adds or joins the input that the beginning kept. In
// training it gives it the derivative that bypasses the block.
#include "nn/layers/skip.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "nn/detail/forward.hpp"
#include "nn/layers/detail/layers.hpp"
#include "nn/layers/detail/training_layers.hpp"

namespace decid::nn {
namespace {

template <class T>
void add_planes(Plane<const T> a, Plane<const T> b, Plane<T> to) {
  for (int i = 0; i < a.rows; ++i)
    for (int k = 0; k < a.columns * lanes; ++k) to.data[i * to.row + k] = a.data[i * a.row + k] + b.data[i * b.row + k];
}

template <class T>
class BranchTraining final : public TrainingLayer<T> {
 public:
  BranchTraining(Layer<T>& layer, std::shared_ptr<Skip<T>> skip) : TrainingLayer<T>(layer), skip_(std::move(skip)) {}

  void forward(const TensorView<const T>& src, const TensorView<T>& dst) override {
    skip_->kept = src;
    copy_planes<T>(src, dst);
  }
  void backward(const TensorView<const T>& src, const TensorView<const T>&, const TensorView<T>& diff_dst,
                const TensorView<T>* diff_src) override {
    if (diff_src == nullptr) return;
    const TensorView<const T> past = skip_->diff(src.batch());
    for_each_plane(src.blocks(), src.shape().channels, [&](int block, int c) {
      add_planes<T>(diff_dst.plane(block, c), past.plane(block, c), diff_src->plane(block, c));
    });
  }

 private:
  std::shared_ptr<Skip<T>> skip_;
};

template <class T>
class JoinTraining final : public TrainingLayer<T> {
 public:
  JoinTraining(Layer<T>& layer, const Join& join, std::shared_ptr<Skip<T>> skip)
      : TrainingLayer<T>(layer), join_(join), skip_(std::move(skip)) {}

  void forward(const TensorView<const T>& src, const TensorView<T>& dst) override {
    const TensorView<const T>& kept = skip_->kept;
    for_each_plane(src.blocks(), dst.shape().channels, [&](int block, int c) {
      const int own = c - join_.kept.channels;
      if (!join_.concatenates)
        add_planes<T>(kept.plane(block, c), src.plane(block, c), dst.plane(block, c));
      else
        copy_plane<T>(own < 0 ? kept.plane(block, c) : src.plane(block, own), dst.plane(block, c));
    });
  }
  void backward(const TensorView<const T>& src, const TensorView<const T>&, const TensorView<T>& diff_dst,
                const TensorView<T>* diff_src) override {
    const TensorView<T> past = skip_->diff(src.batch());
    for_each_plane(src.blocks(), join_.kept.channels,
                   [&](int block, int c) { copy_plane<T>(diff_dst.plane(block, c), past.plane(block, c)); });
    if (diff_src == nullptr) return;
    const int first = join_.concatenates ? join_.kept.channels : 0;
    for_each_plane(src.blocks(), join_.shape.channels, [&](int block, int c) {
      copy_plane<T>(diff_dst.plane(block, first + c), diff_src->plane(block, c));
    });
  }

 private:
  Join join_;
  std::shared_ptr<Skip<T>> skip_;
};

}  // namespace

LayerKind parse_block(Shape src, Words& words) {
  if (!words.take_if("{")) words.fail("has no { behind " + words.name());
  return Branch{src, words.name() == "concat"};
}

LayerKind end_block(const Branch& branch, Shape src, const Words& words) {
  const Shape& kept = branch.shape;
  const auto text = [](const Shape& s) { return format("%d x %d x %d", s.channels, s.rows, s.columns); };
  if (branch.concatenates && (kept.rows != src.rows || kept.columns != src.columns))
    words.fail("ends a concat whose output of " + text(src) + " has other rows or columns than its input of " +
                   text(kept) + " (channels x rows x columns)",
               "give the block layers that keep rows and columns, such as conv with padding");
  if (!branch.concatenates && kept != src)
    words.fail("ends a residual whose output of " + text(src) + " has another shape than its input of " + text(kept) +
                   " (channels x rows x columns)",
               "give the block layers that keep the shape, such as conv with padding");
  return Join{src, kept, branch.concatenates};
}

template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Branch& branch, int max_batch,
                                                OpenSkips<T>& open) {
  open.push_back(std::make_shared<Skip<T>>(branch.shape, max_batch));
  return std::make_unique<BranchTraining<T>>(layer, open.back());
}

template <class T>
std::unique_ptr<TrainingLayer<T>> make_training(Layer<T>& layer, const Join& join, OpenSkips<T>& open) {
  auto made = std::make_unique<JoinTraining<T>>(layer, join, open.back());
  open.pop_back();
  return made;
}

template std::unique_ptr<TrainingLayer<float>> make_training(Layer<float>&, const Branch&, int, OpenSkips<float>&);
template std::unique_ptr<TrainingLayer<double>> make_training(Layer<double>&, const Branch&, int, OpenSkips<double>&);
template std::unique_ptr<TrainingLayer<float>> make_training(Layer<float>&, const Join&, OpenSkips<float>&);
template std::unique_ptr<TrainingLayer<double>> make_training(Layer<double>&, const Join&, OpenSkips<double>&);

}  // namespace decid::nn
