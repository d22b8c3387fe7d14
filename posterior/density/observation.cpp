// Prepares a recording for the density: block means without their line, the torque of the sine, and a first estimate of
// the measurement noise.
#include <algorithm>
#include <cmath>
#include <complex>
#include <string>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/text.hpp"
#include "posterior/density/density.hpp"
#include "posterior/density/elementary.hpp"

namespace decid::posterior {

using sim::Complex;

namespace {

/// Subtracts the least-squares line from the blocks.
void subtract_line(Observation& observation) {
  const auto count = static_cast<double>(observation.sway.size());
  const double middle = 0.5 * (count - 1.0);
  double sum = 0.0, along = 0.0;
  for (std::size_t m = 0; m < observation.sway.size(); ++m) {
    sum += observation.sway[m];
    along = std::fma(static_cast<double>(m) - middle, observation.sway[m], along);
  }
  observation.level_rad = sum / count;
  observation.slope_rad = along / (count * (count * count - 1.0) / 12.0);
  for (std::size_t m = 0; m < observation.sway.size(); ++m)
    observation.sway[m] -= observation.level_rad + observation.slope_rad * (static_cast<double>(m) - middle);
}

/// Returns sin a - a by its series: |a| stays below 0.1.
double sine_excess(double a) {
  const double z = a * a;
  return a * z * (-1.0 / 6 + z * (1.0 / 120 - z * (1.0 / 5040)));
}

}  // namespace

void require_few_gaps(std::span<const SampleRange> gaps, double rate_hz) {
  std::size_t samples = 0;
  for (const SampleRange& gap : gaps) samples += gap.size();
  const double missing_s = static_cast<double>(samples) / rate_hz;
  if (missing_s <= max_missing_s) return;
  throw Error(
      Code::value_missing, "sway",
      format("%.3g s were not measured (empty, a straight line, or still): %zu %s, the first from %.3g s after the "
             "protocol's start; a fit leaves out at most %g s",
             missing_s, gaps.size(), gaps.size() == 1 ? "stretch" : "stretches",
             static_cast<double>(gaps.front().first) / rate_hz, max_missing_s),
      "record again, or give a part without them and a protocol of that part's cycles");
}

Observation Density::observe(std::span<const float> sway_rad, std::span<const SampleRange> gaps) const {
  Observation observation = prepared(sway_rad, gaps);
  if (std::ranges::all_of(observation.sway, [](double sway) { return sway == 0.0; }))
    throw Error(Code::value_invalid, "posterior", "the recording is constant", "give a recording of sway");
  return observation;
}

Observation Density::at_rest() const {
  return prepared(std::vector<float>(static_cast<std::size_t>(protocol_.samples()), 0.0F), {});
}

Observation Density::prepared(std::span<const float> sway_rad, std::span<const SampleRange> gaps) const {
  if (sway_rad.size() != static_cast<std::size_t>(protocol_.samples())) {
    throw Error(Code::size_mismatch, "recording", "has " + std::to_string(sway_rad.size()) + " samples",
                "give the protocol's " + std::to_string(protocol_.samples()));
  }
  Observation observation;
  for (int block = 0; block < blocks_; ++block) {
    double sum = 0.0;
    for (int j = 0; j < block_samples_; ++j)
      sum += double{sway_rad[static_cast<std::size_t>(block * block_samples_ + j)]};
    observation.sway.push_back(sum / block_samples_);
  }
  std::vector<int> missing;
  for (const SampleRange& gap : gaps) {
    if (gap.first >= gap.end || gap.end > sway_rad.size())
      throw Error(Code::setting_out_of_range, "recording",
                  format("has a gap of samples %zu to %zu", gap.first, gap.end),
                  format("give ranges within its %zu samples", sway_rad.size()));
    const int last = std::min(static_cast<int>(gap.end - 1) / block_samples_, blocks_ - 1);
    for (int block = static_cast<int>(gap.first) / block_samples_; block <= last; ++block)
      if (missing.empty() || block > missing.back()) missing.push_back(block);
  }
  require_few_gaps(gaps, protocol_.experiment.sample_rate_hz);
  observation.missing = spectrum_.make_missing(std::move(missing));
  subtract_line(observation);
  observation.noise_deg = noise_of_highest(observation.sway);

  const double block_s = block_samples_ / protocol_.experiment.sample_rate_hz;
  const double middle_s = 0.5 * (block_samples_ - 1) / protocol_.experiment.sample_rate_hz;
  const double mgh = protocol_.experiment.body.mgh();
  std::vector<double> torque(static_cast<std::size_t>(padded_blocks_), 0.0);
  for (int block = 0; block < blocks_; ++block) {
    double sum = 0.0;
    int count = 0;
    for (int j = std::max(0, block - 1); j <= std::min(blocks_ - 1, block + 1); ++j, ++count)
      sum += observation.sway[static_cast<std::size_t>(j)];
    const int place = lead_blocks_ + block;
    torque[static_cast<std::size_t>(place)] =
        mgh * sine_excess(sum / count) * decid::exp(-damping_ * (block_s * place + middle_s));
  }
  std::vector<Complex> spectrum(static_cast<std::size_t>(fft_.bins()));
  std::vector<Complex> work(static_cast<std::size_t>(fft_.work_length()));
  fft_.forward(torque, spectrum, work);
  const long long middle_steps = static_cast<long long>(block_samples_ - 1) * protocol_.experiment.steps_per_sample();
  const long long padded_steps = static_cast<long long>(padded_blocks_) * bin_steps_;
  for (int k = 0; k < frequencies_; ++k) {
    const auto [sin, cos] = sincos_of_turn(k * middle_steps, 2 * padded_steps);
    put(observation.torque,
        spectrum[static_cast<std::size_t>(k)] * Complex(cos, -sin) * (block_s / sim::integration_step_s));
  }
  return observation;
}

double Density::noise_of_highest(std::span<const double> sway) const {
  NoiseWorkspace work = spectrum_.workspace();
  AlignedVector<double> none(sway.size() * lanes, 0.0), unfolded(none.size());
  kernels(isa_).unfold(blocks_, sway.data(), none.data(), undamp_.data(), unfolded.data());
  NoiseLevels levels;
  levels.white.fill(1.0);
  levels.slow.fill(0.0);
  levels.memory.fill(0.0);
  spectrum_.misfit(levels, unfolded, work, isa_);
  const auto rows = static_cast<std::size_t>(spectrum_.rows());
  const std::size_t first = rows - std::max<std::size_t>(1, rows / 5);
  double squares = 0.0;
  for (std::size_t k = first; k < rows; ++k)
    squares = std::fma(work.coefficient[k * lanes], work.coefficient[k * lanes], squares);
  const double of_block_rad = std::sqrt(squares / static_cast<double>(rows - first));
  return of_block_rad * std::sqrt(static_cast<double>(block_samples_)) / sim::rad_per_deg;
}

}  // namespace decid::posterior
