// The feed of a training: see feed.hpp.
#include "dataset/feed.hpp"

#include <omp.h>

#include <algorithm>
#include <future>
#include <memory>
#include <mutex>
#include <numeric>
#include <string>

#include "base/error.hpp"
#include "base/math/random.hpp"
#include "base/parallel.hpp"

namespace decid::dataset {
namespace {

/// Memory holds two blocks of images.
constexpr std::size_t max_block_bytes = std::size_t{32} << 20;

}  // namespace

void Encoding::encode(const Sway& sway, std::span<float> input) const {
  images.make(sway, input);
  if (!rows.mean.empty()) rows.apply(input, images.shape().columns);
}

namespace {

/// Trials that wait for others to share lanes with.
struct Waiting {
  std::vector<std::size_t> places;
  std::vector<std::vector<float>> sways_rad;
  std::vector<double> heights;
  std::vector<float> images;
};

/// Collects trials from many threads. A thread takes a waiting set or a new one, so there are at most as many sets as
/// threads.
class Collector {
 public:
  Collector(const Encoding& encoding, std::span<float> inputs)
      : encoding_(encoding),
        inputs_(inputs),
        values_(static_cast<std::size_t>(encoding.images.shape().size())),
        together_(static_cast<std::size_t>(encoding.images.trials_together())) {}

  void take(std::size_t place, const Sway& sway) {
    if (place >= inputs_.size() / values_)
      throw Error(Code::size_mismatch, "images",
                  "got place " + std::to_string(place) + ", and space for " + std::to_string(inputs_.size() / values_),
                  "give space for all of them");
    if (together_ == 1) return encoding_.encode(sway, inputs_.subspan(place * values_, values_));
    std::unique_ptr<Waiting> waiting = pick();
    if (waiting->sways_rad.size() == waiting->places.size()) waiting->sways_rad.emplace_back();
    waiting->sways_rad[waiting->places.size()].assign(sway.rad.begin(), sway.rad.end());
    waiting->heights.push_back(sway.height);
    waiting->places.push_back(place);
    if (waiting->places.size() == together_) encode(*waiting);
    const std::lock_guard lock(mutex_);
    all_.push_back(std::move(waiting));
  }

  void finish() {
    for (const auto& waiting : all_) encode(*waiting);
  }

 private:
  std::unique_ptr<Waiting> pick() {
    const std::lock_guard lock(mutex_);
    if (all_.empty()) return std::make_unique<Waiting>();
    std::unique_ptr<Waiting> last = std::move(all_.back());
    all_.pop_back();
    return last;
  }

  void encode(Waiting& waiting) const {
    const std::size_t count = waiting.places.size();
    std::vector<Sway> sways;
    for (std::size_t i = 0; i < count; ++i) sways.emplace_back(waiting.sways_rad[i], waiting.heights[i]);
    waiting.images.resize(count * values_);
    encoding_.images.make_all(sways, waiting.images);
    for (std::size_t i = 0; i < count; ++i) {
      const auto image = std::span(waiting.images).subspan(i * values_, values_);
      if (!encoding_.rows.mean.empty()) encoding_.rows.apply(image, encoding_.images.shape().columns);
      std::ranges::copy(image, inputs_.begin() + static_cast<std::ptrdiff_t>(waiting.places[i] * values_));
    }
    waiting.places.clear();
    waiting.heights.clear();
  }

  const Encoding& encoding_;
  std::span<float> inputs_;
  std::size_t values_, together_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Waiting>> all_;
};

}  // namespace

void encode_all(const Encoding& encoding, const std::function<void(const SwaySink& take)>& produce,
                std::span<float> inputs) {
  Collector collector(encoding, inputs);
  produce([&](std::size_t place, const Sway& sway) { collector.take(place, sway); });
  collector.finish();
}

Scaling measure_scaling(const TrialSource& source, const ImageMaker& images, int trials) {
  if (trials < 1)
    throw Error(Code::setting_out_of_range, "scaling", "is measured on " + std::to_string(trials) + " trials",
                "give one trial or more");
  const ImageShape shape = images.shape();
  const bool standardize = images.settings().standardize_rows;
  const auto values = static_cast<std::size_t>(shape.size());
  trials = std::min(trials, source.trials(Part::training));
  RowStatistics rows(shape);
  std::vector<sim::Parameters> parameters(static_cast<std::size_t>(trials));
  std::vector<float> drawn;
  const RowScaling as_they_are;
  for (int first = 0; first < trials; first += source.trials_at_once()) {
    std::vector<int> indices(static_cast<std::size_t>(std::min(source.trials_at_once(), trials - first)));
    std::iota(indices.begin(), indices.end(), first);
    const auto produce = [&](const SwaySink& take) {
      source.take(Part::training, 0, indices, [&](std::size_t place, const sim::Parameters& truth, const Sway& sway) {
        parameters[static_cast<std::size_t>(first) + place] = truth;
        take(place, sway);
      });
    };
    if (standardize) {
      drawn.resize(indices.size() * values);
      encode_all({images, as_they_are}, produce, drawn);
      for (std::size_t place = 0; place < indices.size(); ++place)
        rows.add(std::span(drawn).subspan(place * values, values));
    } else {
      produce([](std::size_t, const Sway&) {});
    }
  }
  return {standardize ? rows.finish() : RowScaling{}, target_scaling(source.protocol().ranges(), parameters)};
}

namespace {

/// Returns the batches of a block: as many as the source's preferred request and the memory allow.
int block_batches(const TrialSource& source, const ImageMaker& images, int batch, int processes) {
  const std::size_t image_bytes = static_cast<std::size_t>(images.shape().size()) * sizeof(float);
  const auto fitting = static_cast<int>(std::min<std::size_t>(max_block_bytes / image_bytes, 1 << 20));
  const long long trials = static_cast<long long>(std::min(source.trials_at_once(), fitting)) * processes;
  return static_cast<int>(std::max<long long>(std::min<long long>(trials, 1 << 20) / batch, 1));
}

}  // namespace

struct Feed::Making {
  std::shared_future<void> done;
};

Feed::Feed(const TrialSource& source, Encoding encoding, const TargetScaling& targets, int batch, std::uint64_t seed,
           int first_epoch, int last_epoch, BatchSharing sharing, int first_trial)
    : source_(source),
      encoding_(encoding),
      targets_(targets),
      batches_(source.trials(Part::training), batch),
      block_batches_(block_batches(source, encoding.images, batch, sharing.processes)),
      seed_(seed),
      sharing_(std::move(sharing)),
      epoch_(first_epoch),
      last_epoch_(last_epoch),
      next_(batches_.beginning_at(first_trial)),
      making_(std::make_unique<Making>()) {
  start();
}

Feed::~Feed() {
  if (making_->done.valid()) making_->done.wait();
}

Feed::Batch Feed::next() {
  if (taken_ == current_.last_batch) {
    if (!making_->done.valid())
      throw Error(Code::setting_out_of_range, "feed", "has no batch left", "request only batches of its epochs");
    making_->done.get();  // throws at every call if it ended with an exception
    making_->done = {};
    std::swap(current_, coming_);
    taken_ = current_.first_batch;
    own_taken_ = 0;
    start();
  }
  const int trials = batches_.size(taken_);
  const std::size_t first = own_taken_, count = own_trials(trials).size();
  const auto values = static_cast<std::size_t>(encoding_.images.shape().size());
  ++taken_;
  own_taken_ += count;
  return {trials, static_cast<int>(count), std::span(current_.images).subspan(first * values, count * values),
          std::span(current_.targets).subspan(first * targets_.mean.size(), count * targets_.mean.size())};
}

std::vector<int> Feed::own_trials(int trials) const {
  if (sharing_.own) return sharing_.own(trials);
  std::vector<int> all(static_cast<std::size_t>(trials));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

void Feed::start() {
  if (epoch_ >= last_epoch_) return;
  if (next_ == 0 || order_.empty()) order_ = shuffled(source_.trials(Part::training), seed_, epoch_);
  coming_.first_batch = next_;
  coming_.last_batch = next_ = std::min(next_ + block_batches_, batches_.count());
  std::vector<int> indices;
  for (int batch = coming_.first_batch; batch < coming_.last_batch; ++batch)
    for (const int place : own_trials(batches_.size(batch)))
      indices.push_back(order_[static_cast<std::size_t>(batches_.first(batch) + place)]);
  // A new thread has its own OpenMP team: it gets as many threads as the caller's.
  making_->done = std::async(std::launch::async,
                             [this, epoch = epoch_, threads = thread_count(), indices = std::move(indices)]() mutable {
                               omp_set_num_threads(threads);
                               fill(coming_, epoch, std::move(indices));
                             });
  if (next_ < batches_.count()) return;
  next_ = 0;
  ++epoch_;
}

void Feed::fill(Block& block, int epoch, std::vector<int> indices) const {
  const auto values = static_cast<std::size_t>(encoding_.images.shape().size());
  block.images.resize(indices.size() * values);
  block.targets.resize(indices.size() * targets_.mean.size());
  encode_all(
      encoding_,
      [&](const SwaySink& take) {
        source_.take(Part::training, epoch, indices,
                     [&](std::size_t place, const sim::Parameters& parameters, const Sway& sway) {
                       const auto target = targets_.scale(parameters);
                       std::ranges::copy(target,
                                         block.targets.begin() + static_cast<std::ptrdiff_t>(place * target.size()));
                       take(place, sway);
                     });
      },
      block.images);
}

}  // namespace decid::dataset
