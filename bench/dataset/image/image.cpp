// Speed of images, on one thread, for each instruction set, beside the machine's peak of fused multiply-adds in double.
#include "dataset/image/image.hpp"

#include <benchmark/benchmark.h>

#include <span>
#include <vector>

#include "bench/isas.hpp"
#include "identify/training/presets.hpp"

namespace {

using namespace decid;
using namespace decid::bench;

/// Network input of a trial, computed with `trials` others. Only operations of its FFTs (fft/110x110) count;
/// real_imaginary adds copies, the others their functions.
void bench_image(benchmark::State& state, const dataset::ImageSettings& settings, std::size_t trials, Isa isa) {
  constexpr int samples = 12100;
  const dataset::ImageMaker maker(settings, samples);
  std::vector<float> sway_rad(samples), image(trials * static_cast<std::size_t>(maker.shape().size()));
  for (std::size_t i = 0; i < sway_rad.size(); ++i) sway_rad[i] = 1e-4F * static_cast<float>(i * 7919 % 100);
  FmaPeak peak(name(isa));
  const std::vector<dataset::Sway> sways(trials, sway_rad);
  const double seconds =
      best_seconds(state, peak, [&] { maker.make_all(sways, image, isa); }) / static_cast<double>(trials);
  state.counters["us"] = seconds * 1e6;
  state.counters["images/s"] = 1 / seconds;
  state.counters["ns/value"] = seconds / maker.shape().size() * 1e9;
  count_double_flops(state, peak, samples / settings.window * fft_flops(settings.window), seconds);
}

[[maybe_unused]] const bool registered = [] {
  using dataset::Channel;
  const dataset::ImageSettings paper = preset_named("paper").image, best = preset_named("best").image;
  const dataset::ImageSettings copies{.channels = {Channel::real, Channel::imaginary}};
  add_for_each_isa("image/modulus_phase", bench_image, paper, 1U);
  add_for_each_isa("image/real_imaginary", bench_image, copies, 1U);
  add_for_each_isa("image/best", bench_image, best, 1U);
  add_for_each_isa("image/best/trials:8", bench_image, best, 8U);
  return true;
}();

}  // namespace
