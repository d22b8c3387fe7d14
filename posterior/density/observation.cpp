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

/// Returns the gaps, ascending and apart. Throws Error for one that is not within the samples.
std::vector<SampleRange> checked_gaps(std::span<const SampleRange> gaps, std::size_t samples) {
  for (const SampleRange& gap : gaps)
    if (gap.first >= gap.end || gap.end > samples)
      throw Error(Code::setting_out_of_range, "recording",
                  format("has a gap of samples %zu to %zu", gap.first, gap.end),
                  format("give ranges within its %zu samples", samples));
  return joined_ranges({gaps.begin(), gaps.end()});
}

/// Replaces each gap by a straight line, or at an end by the nearest sample: the line through all blocks, the torque
/// and the estimate of the noise use the gaps' values too.
void bridge_gaps(std::vector<float>& sway_rad, std::span<const SampleRange> gaps) {
  const auto is_finite = [](float value) { return std::isfinite(value); };
  for (const SampleRange& gap : gaps) bridge(sway_rad, gap);
  if (const auto found = std::ranges::find_if_not(sway_rad, is_finite); found != sway_rad.end())
    throw Error(Code::value_invalid, "recording",
                format("sample %zu is not finite", static_cast<std::size_t>(found - sway_rad.begin())),
                "give finite samples, or gaps that contain the others");
}

/// Throws Error if the blocks that gaps touch last too long: the time of a fit grows with their number.
void require_few_missing(std::span<const SampleRange> gaps, double missing_s, double trial_s, double rate_hz) {
  const double max_s = std::min(max_missing_s, max_missing_fraction * trial_s);
  if (missing_s <= max_s) return;
  throw Error(
      Code::value_missing, "sway",
      format(
          "blocks of %.3g s have samples that were not measured (empty, a straight line, or still): %zu %s, the first "
          "from %.3g s after the protocol's start; a fit leaves out at most %g s",
          missing_s, gaps.size(), gaps.size() == 1 ? "stretch" : "stretches",
          static_cast<double>(gaps.front().first) / rate_hz, max_s),
      "record again, or give a part without them and a protocol of that part's cycles");
}

}  // namespace

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
  const std::vector<SampleRange> apart = checked_gaps(gaps, sway_rad.size());
  std::vector<float> sway(sway_rad.begin(), sway_rad.end());
  bridge_gaps(sway, apart);
  Observation observation;
  for (int block = 0; block < blocks_; ++block) {
    double sum = 0.0;
    for (int j = 0; j < block_samples_; ++j) sum += double{sway[static_cast<std::size_t>(block * block_samples_ + j)]};
    observation.sway.push_back(sum / block_samples_);
  }
  std::vector<int> missing;
  for (const SampleRange& gap : apart) {
    const int last = std::min(static_cast<int>(gap.end - 1) / block_samples_, blocks_ - 1);
    for (int block = static_cast<int>(gap.first) / block_samples_; block <= last; ++block)
      if (missing.empty() || block > missing.back()) missing.push_back(block);
  }
  require_few_missing(apart, static_cast<double>(missing.size()) * block_s(), blocks_ * block_s(),
                      protocol_.experiment.sample_rate_hz);
  observation.missing = spectrum_.make_missing(std::move(missing));
  subtract_line(observation);
  observation.noise_deg = noise_of_highest(observation.sway);

  const double block_length_s = block_s();
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
        mgh * sine_excess(sum / count) * decid::exp(-damping_ * (block_length_s * place + middle_s));
  }
  std::vector<Complex> spectrum(static_cast<std::size_t>(fft_.bins()));
  std::vector<Complex> work(static_cast<std::size_t>(fft_.work_length()));
  fft_.forward(torque, spectrum, work);
  const long long middle_steps = static_cast<long long>(block_samples_ - 1) * protocol_.experiment.steps_per_sample();
  const long long padded_steps = static_cast<long long>(padded_blocks_) * bin_steps_;
  for (int k = 0; k < frequencies_; ++k) {
    const auto [sin, cos] = sincos_of_turn(k * middle_steps, 2 * padded_steps);
    put(observation.torque,
        spectrum[static_cast<std::size_t>(k)] * Complex(cos, -sin) * (block_length_s / sim::integration_step_s));
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
