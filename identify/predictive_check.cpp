// Posterior predictive checks: see predictive_check.hpp.
#include "identify/predictive_check.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/math/statistics.hpp"
#include "base/text.hpp"
#include "identify/detail/as_recorded.hpp"
#include "identify/detail/streams.hpp"
#include "identify/explanation.hpp"

namespace decid {
namespace {

constexpr int min_standing = 200;  // with fewer the smallest p is above PredictiveCheck::odd
/// Drift is slower than the first; above the last there is little except measurement noise.
constexpr double band_edges_hz[] = {0.05, 0.2, 0.5, 1.0, 2.5};
constexpr std::uint64_t of_sensor = std::uint64_t{1} << 63;

/// Subtracts the least-squares line: a sensor's offset and drift have no information about a controller.
std::vector<float> without_line(std::span<const float> values) {
  const auto count = static_cast<double>(values.size());
  const double middle = 0.5 * (count - 1.0), mean = decid::mean(values);
  double along = 0.0;
  for (std::size_t k = 0; k < values.size(); ++k)
    along = std::fma(static_cast<double>(k) - middle, double{values[k]} - mean, along);
  const double slope = along / std::max(1.0, count * (count * count - 1.0) / 12.0);
  std::vector<float> left;
  left.reserve(values.size());
  for (std::size_t k = 0; k < values.size(); ++k)
    left.push_back(static_cast<float>(double{values[k]} - mean - slope * (static_cast<double>(k) - middle)));
  return left;
}

/// Returns the means over blocks of this many samples, about the mean of all samples; the last block is whole.
std::vector<double> block_means(std::span<const float> sway_rad, std::size_t block_samples) {
  const double mean = decid::mean(sway_rad);
  std::vector<double> means;
  for (std::size_t k = 0; k + block_samples <= sway_rad.size(); k += block_samples)
    means.push_back(decid::mean(sway_rad.subspan(k, block_samples)) - mean);
  return means;
}

/// The sides on which a recorded value is odd: no recording is too near to a mean.
enum class Sides { both, high };

double p_value(double recorded, std::span<const double> simulated, Sides sides) {
  const auto low = std::ranges::count_if(simulated, [&](double value) { return value <= recorded; });
  const auto high = std::ranges::count_if(simulated, [&](double value) { return value >= recorded; });
  const auto fraction = [&](auto count) {
    return static_cast<double>(count + 1) / static_cast<double>(simulated.size() + 1);
  };
  return sides == Sides::high ? fraction(high) : std::min(1.0, 2.0 * fraction(std::min(low, high)));
}

CheckedFigure figure(std::string name, bool in_degrees, double recorded, std::span<const double> simulated,
                     Sides sides) {
  // A band at one time.
  const posterior::Band band = posterior::make_band(simulated, 1);
  return {std::move(name),
          in_degrees,
          recorded,
          band.low.front(),
          band.middle.front(),
          band.high.front(),
          p_value(recorded, simulated, sides)};
}

using Responses = std::vector<sim::FrfPoint>;

/// The mean over the bands of |response - mean|^2 / variance, mean and variance being those of the simulated trials.
class ResponseDistance {
 public:
  explicit ResponseDistance(std::span<const Responses* const> simulated)
      : mean_(simulated.front()->size()), variance_(mean_.size(), 0.0) {
    const auto count = static_cast<double>(simulated.size());
    for (std::size_t band = 0; band < mean_.size(); ++band) {
      for (const Responses* responses : simulated) mean_[band] += (*responses)[band].response / count;
      for (const Responses* responses : simulated)
        variance_[band] += std::norm((*responses)[band].response - mean_[band]) / (count - 1.0);
    }
  }
  double operator()(const Responses& responses) const {
    double sum = 0.0;
    for (std::size_t band = 0; band < mean_.size(); ++band)
      if (variance_[band] > 0.0) sum += std::norm(responses[band].response - mean_[band]) / variance_[band];
    return sum / static_cast<double>(mean_.size());
  }

 private:
  std::vector<sim::Complex> mean_;
  std::vector<double> variance_;
};

double angle_of(sim::Complex value) {
  return decid::atan2(value.imag(), value.real());
}

CheckedResponses checked_responses(Responses recorded, std::span<const Responses* const> simulated) {
  const std::size_t bands = recorded.size();
  std::vector<double> gains, phases_rad;
  std::vector<sim::Complex> sums(bands);
  for (const Responses* responses : simulated)
    for (std::size_t band = 0; band < bands; ++band) sums[band] += (*responses)[band].response;
  for (const Responses* responses : simulated)
    for (std::size_t band = 0; band < bands; ++band) {
      const sim::Complex response = (*responses)[band].response;
      gains.push_back(std::sqrt(std::norm(response)));
      phases_rad.push_back(angle_of(sums[band]) + angle_of(response * std::conj(sums[band])));
    }
  return {std::move(recorded), posterior::make_band(gains, static_cast<int>(bands)),
          posterior::make_band(phases_rad, static_cast<int>(bands))};
}

}  // namespace

struct PredictiveChecker::Shown {
  std::vector<double> bands_deg;
  Responses responses;
  double level_deg = 0.0, max_deg = 0.0, between_cycles_deg = 0.0;
  std::vector<double> blocks_rad;
};

PredictiveChecker::PredictiveChecker(const sim::Simulator& simulator, double block_s)
    : simulator_(simulator), fft_(sim::smooth_length(simulator.samples())) {
  const sim::Experiment& experiment = simulator_.protocol().experiment;
  const double rate_hz = experiment.sample_rate_hz;
  const int samples = simulator_.samples();
  block_samples_ = static_cast<std::size_t>(std::max(1L, std::lround(block_s * rate_hz)));
  const std::vector<double> tilt_rad = sim::tilt_at_samples(experiment, simulator_.stimulus());
  tilt_rad_.assign(tilt_rad.begin(), tilt_rad.end());
  for (int k = 0; k < samples; ++k) window_.push_back(0.5 - 0.5 * sincos_of_turn(2 * k + 1, 2 * samples).cos);  // Hann
  for (std::size_t i = 0; i + 1 < std::size(band_edges_hz); ++i) {
    const auto line = [&](double hz) {
      return std::min(static_cast<std::size_t>(std::ceil(hz * fft_.length() / rate_hz)),
                      static_cast<std::size_t>(fft_.bins()));
    };
    const double low = band_edges_hz[i], high = band_edges_hz[i + 1];
    if (low < 0.5 * rate_hz && line(high) > line(low))
      bands_.push_back({format("%g to %g Hz", low, high), line(low), line(high)});
  }
  try {
    frf_.emplace(frequency_analysis(experiment));
  } catch (const Error&) {  // the explanation says why
  }
  const int count = experiment.cycles(), skipped = count > 2 ? 1 : 0;
  for (int cycle = skipped; count > 1 && cycle <= count; ++cycle) {
    const double begin_s = experiment.lead_in_s() + cycle * experiment.cycle_s();
    cycles_.push_back(static_cast<std::size_t>(std::lround(begin_s * rate_hz)));
  }
}

double PredictiveChecker::between_cycles_deg(std::span<const float> sway_rad) const {
  if (cycles_.size() < 3) return 0.0;
  const std::size_t count = cycles_.size() - 1;
  std::size_t length = cycles_[1] - cycles_[0];
  for (std::size_t i = 0; i < count; ++i)
    length = std::min(length, std::min(cycles_[i + 1], sway_rad.size()) - cycles_[i]);
  std::vector<std::vector<double>> cycles;  // block means, each about its mean
  for (std::size_t i = 0; i < count; ++i)
    cycles.push_back(block_means(sway_rad.subspan(cycles_[i], length), block_samples_));
  if (cycles.front().empty()) return 0.0;
  double squares = 0.0;
  for (std::size_t block = 0; block < cycles.front().size(); ++block) {
    double middle = 0.0;
    for (const std::vector<double>& cycle : cycles) middle += cycle[block] / static_cast<double>(count);
    for (const std::vector<double>& cycle : cycles) squares += (cycle[block] - middle) * (cycle[block] - middle);
  }
  return std::sqrt(squares / static_cast<double>(cycles.front().size() * (count - 1))) / sim::rad_per_deg;
}

PredictiveChecker::Shown PredictiveChecker::show(std::span<const float> as_recorded,
                                                 std::span<const float> tilt_rad) const {
  Shown shown;
  const std::vector<float> sway_rad = without_line(as_recorded);
  const double mean = decid::mean(sway_rad);
  std::vector<double> windowed(static_cast<std::size_t>(fft_.length()), 0.0);
  double window_squares = 0.0;
  for (std::size_t k = 0; k < sway_rad.size(); ++k) {
    const double value_deg = (static_cast<double>(sway_rad[k]) - mean) / sim::rad_per_deg;
    windowed[k] = window_[k] * value_deg;
    window_squares += window_[k] * window_[k];
  }
  std::vector<sim::Complex> spectrum(static_cast<std::size_t>(fft_.bins()));
  std::vector<sim::Complex> work(static_cast<std::size_t>(fft_.work_length()));
  fft_.forward(windowed, spectrum, work);
  for (const Frequencies& band : bands_) {
    double power = 0.0;
    for (std::size_t k = band.first; k < band.end; ++k) power += std::norm(spectrum[k]);
    shown.bands_deg.push_back(std::sqrt(2.0 * power / (window_squares * fft_.length())));
  }
  if (frf_) shown.responses = frf_->measure(sway_rad, tilt_rad);
  shown.between_cycles_deg = between_cycles_deg(sway_rad);
  shown.blocks_rad = block_means(sway_rad, block_samples_);
  double squares = 0.0;
  for (const double block_rad : shown.blocks_rad) {
    squares += block_rad * block_rad;
    shown.max_deg = std::max(shown.max_deg, std::abs(block_rad) / sim::rad_per_deg);
  }
  shown.level_deg =
      std::sqrt(squares / static_cast<double>(std::max<std::size_t>(1, shown.blocks_rad.size()))) / sim::rad_per_deg;
  return shown;
}

std::vector<float> PredictiveChecker::record(std::span<const double> sway_rad, const posterior::State& draw,
                                             const Random& noise) const {
  std::vector<double> normals(sway_rad.size());
  noise.fill_normal(normals);
  const double shift = draw.start_s * simulator_.protocol().experiment.sample_rate_hz;
  // Slow noise: an Ornstein-Uhlenbeck process, whose normals follow those of the white noise.
  std::vector<double> slow_normals(sway_rad.size());
  noise.fill_normal(slow_normals, slow_normals.size());
  const double kept = decid::exp(-1.0 / (draw.slow_memory_s * simulator_.protocol().experiment.sample_rate_hz));
  const double slow_rad = draw.slow_noise_deg * sim::rad_per_deg, fresh = std::sqrt(1.0 - kept * kept);
  double slow = slow_normals.front();
  std::vector<float> recorded;
  recorded.reserve(sway_rad.size());
  for (std::size_t k = 0; k < sway_rad.size(); ++k) {
    const double sway = value_at(sway_rad, static_cast<double>(k) + shift);
    if (k > 0) slow = std::fma(kept, slow, fresh * slow_normals[k]);
    recorded.push_back(
        static_cast<float>(draw.gain * sway + draw.sensor_noise_deg * sim::rad_per_deg * normals[k] + slow_rad * slow));
  }
  return recorded;
}

std::vector<CheckedFigure> PredictiveChecker::compare(const Shown& recorded, std::span<const Shown> simulated) const {
  std::vector<CheckedFigure> figures;
  const auto add = [&](std::string name, bool in_degrees, const auto& value_of, Sides sides = Sides::both) {
    std::vector<double> values;
    for (const Shown& shown : simulated) values.push_back(value_of(shown));
    figures.push_back(figure(std::move(name), in_degrees, value_of(recorded), values, sides));
  };
  for (std::size_t band = 0; band < bands_.size(); ++band)
    add(bands_[band].name, true, [&](const Shown& shown) { return shown.bands_deg[band]; });
  if (!recorded.responses.empty()) {
    std::vector<const Responses*> all;
    for (const Shown& shown : simulated) all.push_back(&shown.responses);
    const ResponseDistance distance(all);
    add(
        "frequency response", false, [&](const Shown& shown) { return distance(shown.responses); }, Sides::high);
  }
  add("level", true, [](const Shown& shown) { return shown.level_deg; });
  add("largest sway", true, [](const Shown& shown) { return shown.max_deg; });
  if (cycles_.size() > 2) add("between cycles", true, [](const Shown& shown) { return shown.between_cycles_deg; });
  return figures;
}

PredictiveCheck PredictiveChecker::check(std::span<const posterior::State> draws, const recording::Trial& trial,
                                         std::uint64_t seed) const {
  if (draws.empty() || trial.sway_rad().size() != tilt_rad_.size())
    throw Error(Code::size_mismatch, "predictive check",
                format("%zu draws, %zu samples", draws.size(), trial.sway_rad().size()),
                format("give draws, and the protocol's %zu samples", tilt_rad_.size()));
  constexpr auto count = static_cast<std::size_t>(PredictiveCheck::trials);
  const auto draw_of = [&](int i) -> const posterior::State& {
    return draws[(2 * static_cast<std::size_t>(i) + 1) * draws.size() / (2 * count)];
  };
  const sim::ParameterTable& table = simulator_.protocol().parameters();
  std::vector<std::optional<Shown>> all(count);
  simulator_.run_all(
      PredictiveCheck::trials,
      [&](int i) {
        return sim::TrialInput{table.simulable(draw_of(i).parameters),
                               Random(seed, streams::predictive, static_cast<std::uint64_t>(i))};
      },
      [&](int i, const sim::Outcome& outcome, std::span<double> sway_rad) {
        if (!outcome.valid) return;
        const Random noise(seed, streams::predictive, of_sensor | static_cast<std::uint64_t>(i));
        all[static_cast<std::size_t>(i)] =
            show(with_bridged_gaps(record(sway_rad, draw_of(i), noise), trial.gaps), tilt_rad_);
      });
  PredictiveCheck check;
  std::vector<Shown> standing;
  for (std::optional<Shown>& shown : all)
    if (shown) standing.push_back(std::move(*shown));
  check.standing = static_cast<int>(standing.size());
  if (check.standing < min_standing) return check;
  const auto* measured = trial.signals.find(recording::platform_tilt);
  Shown recorded = show(with_bridged_gaps(trial.sway_rad(), trial.gaps), measured ? measured->rad : tilt_rad_);
  check.figures = compare(recorded, standing);
  if (!recorded.responses.empty()) {
    std::vector<const Responses*> simulated;
    for (const Shown& shown : standing) simulated.push_back(&shown.responses);
    check.responses = checked_responses(std::move(recorded.responses), simulated);
  }
  std::vector<double> blocks;
  for (const Shown& shown : standing) blocks.insert(blocks.end(), shown.blocks_rad.begin(), shown.blocks_rad.end());
  check.sway_rad = posterior::make_band(blocks, static_cast<int>(standing.front().blocks_rad.size()));
  return check;
}

std::string PredictiveCheck::warning() const {
  if (figures.empty())
    return format(
        "of %d trials simulated from the draws the body stands in %d: whether they look like the recording "
        "cannot be said",
        trials, standing);
  std::string list;
  for (const CheckedFigure& one : figures) {
    if (one.p >= odd) continue;
    const bool band = one.name.ends_with("Hz");
    list += format("%s%s%s %.3g%s, simulated %.3g to %.3g (p %.3f)", list.empty() ? "" : "; ", band ? "rms at " : "",
                   one.name.c_str(), one.recorded, one.in_degrees ? " degrees" : "", one.low, one.high, one.p);
  }
  return list.empty() ? list : "sway simulated from the draws does not look like the recording: " + list;
}

}  // namespace decid
