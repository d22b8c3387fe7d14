// Samples: see fit.hpp and detail/samples.hpp.
#include "nn/detail/samples.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "base/error.hpp"
#include "base/files/sha256.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"

namespace decid::nn {
namespace {

/// Throws Error if a value of a sample is not finite. sample: its number, from 0.
void require_finite(std::span<const float> values, const char* name, int sample) {
  const auto bad = std::ranges::find_if_not(values, [](float value) { return std::isfinite(value); });
  if (bad != values.end())
    throw Error(Code::value_invalid, "samples",
                format("have %g as value %td of the %s of sample %d, counted from 0", static_cast<double>(*bad),
                       bad - values.begin(), name, sample),
                "leave the sample out, or replace the value by a finite one");
}

}  // namespace

Samples::Samples(int count_, Load load_) : count(count_), load(std::move(load_)) {
  if (count < 1 || !load)
    throw Error(Code::setting_out_of_range, "samples", "are none", "give 1 or more, and a function that writes them");
}

Samples::Samples(int count_, LoadBatch load_batch_)
    : Samples(count_, load_batch_ ? Load([load_batch_](int sample, const Random* random, std::span<float> input,
                                                       std::span<float> target) {
                const std::span<const Random> numbers(random, random != nullptr ? 1 : 0);
                load_batch_({std::span(&sample, 1), 0, numbers, input, target});
              })
                                  : Load()) {
  load_batch = std::move(load_batch_);
}

Samples::Samples(std::span<const float> inputs_, std::span<const float> targets_, int count_)
    : count(count_), inputs(inputs_), targets(targets_) {
  const auto n = static_cast<std::size_t>(std::max(count, 1));
  if (count < 1 || inputs.empty() || inputs.size() % n != 0 || targets.size() % n != 0)
    throw Error(Code::size_mismatch, "samples",
                format("are %d where inputs have %zu values and targets %zu", count, inputs.size(), targets.size()),
                "give as many values for each sample");
  load = [inputs_, targets_, n](int sample, const Random*, std::span<float> input, std::span<float> target) {
    const auto copy = [&](std::span<const float> from, std::span<float> to, const char* name) {
      const std::size_t width = from.size() / n;
      if (to.size() != width)
        throw Error(Code::size_mismatch, "samples",
                    format("have %s of %zu values where the training needs %zu", name, width, to.size()),
                    "give those of the network and its loss");
      std::ranges::copy(from.subspan(static_cast<std::size_t>(sample) * width, width), to.begin());
    };
    copy(inputs_, input, "inputs");
    copy(targets_, target, "targets");
  };
}

void load(const Samples& samples, std::span<const int> places, std::size_t values, std::size_t width, int epoch,
          const std::function<Random(int)>& random, Loaded& loaded) {
  loaded.inputs.resize(places.size() * values);
  loaded.targets.resize(places.size() * width);
  if (samples.load_batch) {
    std::vector<Random> numbers;
    for (std::size_t i = 0; random && i < places.size(); ++i) numbers.push_back(random(places[i]));
    return samples.load_batch({places, epoch, numbers, loaded.inputs, loaded.targets});
  }
  parallel_for(static_cast<int>(places.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    const std::optional<Random> own = random ? std::optional(random(places[k])) : std::nullopt;
    samples.load(places[k], own ? &*own : nullptr, std::span(loaded.inputs).subspan(k * values, values),
                 std::span(loaded.targets).subspan(k * width, width));
  });
}

bool is_finite(std::span<const float> values) {
  return std::ranges::all_of(values, [](float value) { return std::isfinite(value); });
}

void require_finite(const Loaded& loaded, std::span<const int> places, std::size_t values, std::size_t width) {
  if (is_finite(loaded.inputs) && is_finite(loaded.targets)) return;
  for (std::size_t i = 0; i < places.size(); ++i) {
    require_finite(std::span(loaded.inputs).subspan(i * values, values), "inputs", places[i]);
    require_finite(std::span(loaded.targets).subspan(i * width, width), "targets", places[i]);
  }
}

void require_finite(const Samples& samples) {
  if (is_finite(samples.inputs) && is_finite(samples.targets)) return;
  const auto width = [&](std::span<const float> all) { return all.size() / static_cast<std::size_t>(samples.count); };
  for (int i = 0; i < samples.count; ++i) {
    const auto of = [&](std::span<const float> all) {
      return all.subspan(static_cast<std::size_t>(i) * width(all), width(all));
    };
    require_finite(of(samples.inputs), "inputs", i);
    require_finite(of(samples.targets), "targets", i);
  }
}

std::vector<int> all_of(const Samples& samples) {
  std::vector<int> places(static_cast<std::size_t>(samples.count));
  std::iota(places.begin(), places.end(), 0);
  return places;
}

std::string content_of(const Samples& samples) {
  if (samples.inputs.empty()) return "a function";
  Sha256 hash;
  hash.update(samples.inputs.data(), samples.inputs.size_bytes());
  hash.update(samples.targets.data(), samples.targets.size_bytes());
  return hash.hex();
}

}  // namespace decid::nn
