// Feeding: see feed.hpp.
#include "tools/feed.hpp"

#include <omp.h>

#include <algorithm>
#include <numeric>

#include "base/parallel.hpp"
#include "base/random.hpp"

namespace decid::tools {
namespace {

/// Two blocks of images are in memory.
constexpr std::size_t most_block_bytes = std::size_t{32} << 20;

/// The epoch's order of trials: Fisher and Yates, from (seed, epoch).
std::vector<int> shuffled(int count, std::uint64_t seed, int epoch) {
  std::vector<int> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), 0);
  const Random random(seed, Stream::shuffle, static_cast<std::uint64_t>(epoch));
  for (std::size_t i = order.size(); i-- > 1;) std::swap(order[i], order[random.below(i, i + 1)]);
  return order;
}

}  // namespace

Feed::Feed(const TrialSource& source, const Model& model, int batch, std::uint64_t seed, int first_epoch,
           int last_epoch)
    : source_(source), model_(model), batch_(batch), seed_(seed), epoch_(first_epoch), last_epoch_(last_epoch) {
  const std::size_t image_bytes = static_cast<std::size_t>(model.images().shape().size()) * sizeof(float);
  const auto fitting = static_cast<int>(std::min<std::size_t>(most_block_bytes / image_bytes, 1 << 20));
  block_trials_ = std::max(std::min(source.trials_at_once(), fitting) / batch, 1) * batch;
  start();
}

Feed::~Feed() {
  if (making_.valid()) making_.wait();
}

Feed::Batch Feed::next() {
  if (taken_ == current_.trials) {
    making_.get();
    std::swap(current_, coming_);
    taken_ = 0;
    start();
  }
  const int trials = std::min(batch_, current_.trials - taken_);
  const auto first = static_cast<std::size_t>(taken_), count = static_cast<std::size_t>(trials);
  const auto values = static_cast<std::size_t>(model_.images().shape().size());
  taken_ += trials;
  return {trials, std::span(current_.images).subspan(first * values, count * values),
          std::span(current_.targets).subspan(first * sim::parameter_count, count * sim::parameter_count)};
}

void Feed::start() {
  if (epoch_ == last_epoch_) return;
  if (first_ == 0) order_ = shuffled(source_.training_trials(), seed_, epoch_);
  const int count = std::min(block_trials_, static_cast<int>(order_.size()) - first_);
  std::vector<int> indices(order_.begin() + first_, order_.begin() + first_ + count);
  // A thread of its own has OpenMP's threads of its own, as many as the caller's.
  making_ = std::async(std::launch::async,
                       [this, epoch = epoch_, threads = thread_count(), indices = std::move(indices)]() mutable {
                         omp_set_num_threads(threads);
                         fill(coming_, epoch, std::move(indices));
                       });
  first_ += count;
  if (first_ == static_cast<int>(order_.size())) {
    first_ = 0;
    ++epoch_;
  }
}

void Feed::fill(Block& block, int epoch, std::vector<int> indices) const {
  const auto values = static_cast<std::size_t>(model_.images().shape().size());
  block.trials = static_cast<int>(indices.size());
  block.images.resize(indices.size() * values);
  block.targets.resize(indices.size() * sim::parameter_count);
  source_.training(
      epoch, indices, [&](std::size_t place, const sim::Parameters& parameters, std::span<const float> sway_rad) {
        const auto target = model_.targets.scale(parameters);
        std::ranges::copy(target, block.targets.begin() + static_cast<std::ptrdiff_t>(place * sim::parameter_count));
        model_.make_input(sway_rad, std::span(block.images).subspan(place * values, values));
      });
}

}  // namespace decid::tools
