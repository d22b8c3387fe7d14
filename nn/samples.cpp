// Samples: see fit.hpp and detail/samples.hpp.
#include "nn/detail/samples.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
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

Samples::Samples(int count, Load load) : count_(count), load_(std::move(load)) {
  if (count_ < 1 || !load_)
    throw Error(Code::setting_out_of_range, "samples", "are none", "give 1 or more, and a function that writes them");
}

Samples::Samples(int count, LoadBatch load_batch)
    : Samples(count, load_batch ? Load([load_batch](int sample, const Random* random, std::span<float> input,
                                                    std::span<float> target) {
                const std::span<const Random> numbers(random, random != nullptr ? 1 : 0);
                load_batch({std::span(&sample, 1), 0, numbers, input, target});
              })
                                : Load()) {
  load_batch_ = std::move(load_batch);
}

Samples::Samples(std::span<const float> inputs, std::span<const float> targets, int count)
    : count_(count), inputs_(inputs), targets_(targets) {
  const auto n = static_cast<std::size_t>(std::max(count, 1));
  if (count < 1 || inputs.empty() || inputs.size() % n != 0 || targets.size() % n != 0)
    throw Error(Code::size_mismatch, "samples",
                format("are %d where inputs have %zu values and targets %zu", count, inputs.size(), targets.size()),
                "give as many values for each sample");
  load_ = [inputs, targets, n](int sample, const Random*, std::span<float> input, std::span<float> target) {
    const auto copy = [&](std::span<const float> from, std::span<float> to, const char* name) {
      const std::size_t width = from.size() / n;
      if (to.size() != width)
        throw Error(Code::size_mismatch, "samples",
                    format("have %s of %zu values where the training needs %zu", name, width, to.size()),
                    "give those of the network and its loss");
      std::ranges::copy(from.subspan(static_cast<std::size_t>(sample) * width, width), to.begin());
    };
    copy(inputs, input, "inputs");
    copy(targets, target, "targets");
  };
}

void load(const Samples& samples, std::span<const int> places, std::size_t values, std::size_t width, int epoch,
          const std::function<Random(int)>& random, Loaded& loaded) {
  loaded.inputs.resize(places.size() * values);
  loaded.targets.resize(places.size() * width);
  if (samples.inputs().empty())  // values of the samples before would pass for values that the function wrote
    for (std::vector<float>* const all : {&loaded.inputs, &loaded.targets})
      std::ranges::fill(*all, std::numeric_limits<float>::quiet_NaN());
  if (samples.load_batch()) {
    std::vector<Random> numbers;
    for (std::size_t i = 0; random && i < places.size(); ++i) numbers.push_back(random(places[i]));
    return samples.load_batch()({places, epoch, numbers, loaded.inputs, loaded.targets});
  }
  parallel_for(static_cast<int>(places.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    const std::optional<Random> own = random ? std::optional(random(places[k])) : std::nullopt;
    samples.load()(places[k], own ? &*own : nullptr, std::span(loaded.inputs).subspan(k * values, values),
                   std::span(loaded.targets).subspan(k * width, width));
  });
}

void require_finite(const Loaded& loaded, std::span<const int> places, std::size_t values, std::size_t width) {
  if (is_finite(loaded.inputs) && is_finite(loaded.targets)) return;
  for (std::size_t i = 0; i < places.size(); ++i) {
    require_finite(std::span(loaded.inputs).subspan(i * values, values), "inputs", places[i]);
    require_finite(std::span(loaded.targets).subspan(i * width, width), "targets", places[i]);
  }
}

void require_finite(const Samples& samples) {
  if (is_finite(samples.inputs()) && is_finite(samples.targets())) return;
  const auto width = [&](std::span<const float> all) { return all.size() / static_cast<std::size_t>(samples.count()); };
  for (int i = 0; i < samples.count(); ++i) {
    const auto of = [&](std::span<const float> all) {
      return all.subspan(static_cast<std::size_t>(i) * width(all), width(all));
    };
    require_finite(of(samples.inputs()), "inputs", i);
    require_finite(of(samples.targets()), "targets", i);
  }
}

void require_targets(const Samples& samples, const Loss& loss, int outputs) {
  const auto width = static_cast<std::size_t>(loss.targets(outputs)), count = static_cast<std::size_t>(samples.count());
  if (samples.inputs().empty() || samples.targets().size() != width * count) return;  // load() refuses another size
  for (std::size_t i = 0; i < count; ++i)
    loss.require_target(samples.targets().subspan(i * width, width), outputs, static_cast<int>(i));
}

std::vector<int> all_of(const Samples& samples) {
  std::vector<int> places(static_cast<std::size_t>(samples.count()));
  std::iota(places.begin(), places.end(), 0);
  return places;
}

std::string content_of(const Samples& samples) {
  if (samples.inputs().empty()) return "a function";
  Sha256 hash;
  hash.update(samples.inputs().data(), samples.inputs().size_bytes());
  hash.update(samples.targets().data(), samples.targets().size_bytes());
  return hash.hex();
}

}  // namespace decid::nn
