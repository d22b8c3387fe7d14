// The posterior that a planned recording leaves: see expected_posterior.hpp.
#include "posterior/planning/expected_posterior.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/math/cholesky.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "posterior/planning/bounded_normal.hpp"
#include "posterior/planning/detail/noise_power.hpp"
#include "posterior/streams.hpp"
#include "sim/simulate.hpp"
#include "sim/streams.hpp"

namespace decid::posterior {
namespace {

constexpr int max_falls = 1000;
constexpr double margin = 0.01;  // of a range: as Density::set
constexpr double no_slow_noise_deg = 1e-9;
// The numbers of a person's vestibular noise and of the estimate.
constexpr std::uint64_t noise_item = std::uint64_t{1} << 62U, estimate_item = std::uint64_t{1} << 63U;

void check_plan(const Density& density, const PlannedRecordings& planned) {
  if (planned.draws < 1)
    throw Error(Code::setting_out_of_range, "design, draws", format("is %d", planned.draws), "give 1 or more");
  if (!(planned.sensor_noise_deg > 0.0 && std::isfinite(planned.sensor_noise_deg)))
    throw Error(Code::setting_out_of_range, "design, sensor_noise_deg", format("is %g", planned.sensor_noise_deg),
                "give degrees above 0");
  const sim::ParameterTable& table = density.ranges();
  for (const std::optional<sim::Parameters>* given : {&planned.at, &planned.participant_sd})
    if (*given && (*given)->size() != table.size())
      throw Error(Code::size_mismatch, "design", format("has %zu values", (*given)->size()),
                  format("give the %zu parameters of the controller", table.size()));
  bool some = false;
  for (std::size_t p = 0; p < table.size(); ++p) {
    if (!density.infers(static_cast<int>(p))) continue;
    some = true;
    if (planned.at && !((*planned.at)[p] > table[p].low && (*planned.at)[p] < table[p].high))
      throw Error(Code::setting_out_of_range, "design, " + table[p].name,
                  format("is %g", (*planned.at)[p]) + table[p].unit_after(),
                  format("give a value above %g and below %g", table[p].low, table[p].high) + table[p].unit_after() +
                      table[p].unit_hint() + mgh_hint(table[p], (*planned.at)[p]));
  }
  if (!some)
    throw Error(Code::setting_conflict, "design", "the priors fix every parameter", "leave one to be inferred");
}

/// Returns a parameter's value, at least the margin within its range; a fixed one has no range.
double within_margin(const Quantile& q, double value) {
  return std::clamp(value, q.low + margin * q.range, q.low + (1.0 - margin) * q.range);
}

/// Returns the parameters of participants who stand through the protocol.
std::vector<sim::Parameters> participants_of(const Density& density, const PlannedRecordings& planned) {
  sim::Protocol protocol = density.protocol().ideal();
  if (protocol.standing_s == 0.0) protocol.standing_s = density.priors().standing_s;
  std::vector<sim::Parameters> participants(static_cast<std::size_t>(planned.draws));
  sim::Simulator(protocol).run_until_valid(
      planned.draws, max_falls,
      [&](int index, int attempt) {
        const auto item = static_cast<std::uint64_t>(index) * max_falls + static_cast<std::uint64_t>(attempt);
        const Random random(planned.seed, streams::design, item);
        sim::Parameters participant(static_cast<std::size_t>(density.parameters()));
        for (std::size_t p = 0; p < participant.size(); ++p) {
          const Quantile& q = density.quantile(p);
          const double off = planned.participant_sd ? (*planned.participant_sd)[p] * random.normal(p) : 0.0;
          participant[p] = planned.at && q.range > 0.0 ? (*planned.at)[p] + off : q.value(random.normal(p));
          participant[p] = within_margin(q, participant[p]);
        }
        return sim::TrialInput{participant, Random(planned.seed, sim::streams::vestibular_noise, item)};
      },
      [&](int index, const sim::TrialInput& trial, std::span<double>) {
        participants[static_cast<std::size_t>(index)] = trial.parameters;
      });
  return participants;
}

/// Sets a person's coordinates, with vestibular noise.
void place_participant(const Density& density, const PlannedRecordings& planned, const sim::Parameters& participant,
                       std::uint64_t number, int lane, std::span<double> x) {
  State state;
  state.parameters = participant;
  state.sensor_noise_deg = planned.sensor_noise_deg;
  state.slow_noise_deg = no_slow_noise_deg;
  density.set(state, x, lane);
  std::vector<double> noise(static_cast<std::size_t>(density.noise_size()));
  Random(planned.seed, streams::design, noise_item + number).fill_normal(noise);
  for (std::size_t i = 0; i < noise.size(); ++i)
    x[i * lanes + static_cast<std::size_t>(lane)] = density.noise_radius(participant) * noise[i];
}

[[noreturn]] void refuse_information() {
  throw Error(Code::value_invalid, "design", "the information about the parameters is not finite",
              "use another protocol, or more measurement noise");
}

/// Returns the information about some of the last coordinates, all other ones eliminated. inverse_factor: of the
/// information about all; `first` is the first of the last coordinates, to which `chosen` are relative.
std::vector<double> information_about(std::size_t size, std::size_t first, std::span<const std::size_t> chosen,
                                      std::span<const double> inverse_factor) {
  const std::size_t count = chosen.size();
  std::vector<double> matrix(triangle(count), 0.0);  // the covariance, then its inverse
  for (std::size_t i = first; i < size; ++i) {
    const auto of = [&](std::size_t a) {
      const std::size_t column = first + chosen[a];
      return column <= i ? inverse_factor[triangle(i) + column] : 0.0;
    };
    for (std::size_t a = 0; a < count; ++a)
      for (std::size_t b = 0; b <= a; ++b) matrix[triangle(a) + b] += of(a) * of(b);
  }
  if (!factorize(count, matrix)) refuse_information();
  invert_lower(count, matrix);
  std::vector<double> information(triangle(count), 0.0);
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t a = 0; a <= i; ++a)
      for (std::size_t b = 0; b <= a; ++b)
        information[triangle(a) + b] += matrix[triangle(i) + a] * matrix[triangle(i) + b];
  return information;
}

/// Adds as much of `more` as leaves the information positive definite: all of it, or a half, a quarter...
void add_while_positive(std::size_t count, std::span<const double> more, std::vector<double>& information) {
  for (double fraction = 1.0; fraction > 0.01; fraction *= 0.5) {
    std::vector<double> sum = information;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += fraction * more[i];
    std::vector<double> factor = sum;
    if (!factorize(count, factor)) continue;
    information = std::move(sum);
    return;
  }
}

/// Plans for one density; all threads share it.
class Planner {
 public:
  Planner(const Density& density, const PlannedRecordings& planned)
      : density_(density),
        planned_(planned),
        participants_(participants_of(density, planned)),
        observation_(density.at_rest()),
        size_(static_cast<std::size_t>(density.size())),
        noises_(static_cast<std::size_t>(density.noise_size())) {
    for (std::size_t p = 0; p < static_cast<std::size_t>(density.parameters()); ++p) {
      if (!density.infers(static_cast<int>(p))) continue;
      inferred_.push_back(p);
      const Quantile& q = density.quantile(p);
      const double sd = q.sd / q.range;
      priors_.push_back(q.sd > 0.0 ? FractionPrior{(q.mean - q.low) / q.range, 1.0 / (sd * sd)} : FractionPrior{});
    }
  }

  const std::vector<std::size_t>& inferred() const { return inferred_; }
  const std::vector<FractionPrior>& priors() const { return priors_; }

  /// Returns the expected variances of the fractions of each person.
  std::vector<std::vector<double>> variances() const {
    constexpr auto at_once = static_cast<std::size_t>(lanes);
    std::vector<std::vector<double>> all(participants_.size());
    parallel_for(static_cast<int>((participants_.size() + at_once - 1) / at_once), [&](int number) {
      const std::size_t first = static_cast<std::size_t>(number) * at_once;
      Density::Workspace work(density_);
      AlignedVector<double> x(size_ * at_once);
      for (std::size_t l = 0; l < at_once; ++l) {
        const std::size_t participant = std::min(first + l, participants_.size() - 1);
        place_participant(density_, planned_, participants_[participant], participant, static_cast<int>(l), x);
      }
      std::vector<double> matrices(triangle(size_) * at_once), matrix(triangle(size_)), room(inverse_work(size_));
      density_.information(observation_, x, matrices, work);
      for (std::size_t l = 0; l < at_once && first + l < participants_.size(); ++l) {
        for (std::size_t i = 0; i < matrix.size(); ++i) matrix[i] = matrices[i * at_once + l];
        if (!kernels(density_.isa()).inverse_factor(static_cast<int>(size_), matrix.data(), room.data()))
          refuse_information();
        all[first + l] = variances_of(first + l, l, x, matrix);
      }
    });
    return all;
  }

 private:
  std::vector<double> variances_of(std::size_t participant, std::size_t lane, std::span<const double> x,
                                   std::span<const double> inverse_factor) const {
    const std::size_t count = inferred_.size();
    std::vector<double> information = information_about(size_, noises_, inferred_, inverse_factor), truth, slopes;
    for (const std::size_t p : inferred_) {
      const Quantile& q = density_.quantile(p);
      const double coordinate = x[(noises_ + p) * lanes + lane];
      truth.push_back((q.value(coordinate) - q.low) / q.range);
      slopes.push_back(q.slope(coordinate) / q.range);
    }
    for (std::size_t a = 0; a < count; ++a) {
      information[triangle(a) + a] -= 1.0;  // the prior's
      for (std::size_t b = 0; b <= a; ++b) information[triangle(a) + b] /= slopes[a] * slopes[b];
    }
    add_noise_power(participant, inverse_factor, information);
    const Random random(planned_.seed, streams::design, estimate_item + participant);
    return variances_in_range(truth, information, priors_, random);
  }

  /// The noise's coordinates hold its gain Nv, so the information counts all of them as known: 2 n / Nv^2 for large Nv.
  /// The second and third terms replace that.
  void add_noise_power(std::size_t participant, std::span<const double> inverse_factor,
                       std::vector<double>& information) const {
    const std::size_t count = inferred_.size();
    const sim::Parameters& parameters = participants_[participant];
    const double radius = density_.noise_radius(parameters), variance = radius * radius;
    const KnownNoise known(noises_, variance, inverse_factor);
    const std::vector<std::vector<sim::Complex>> changes = relative_changes(density_, parameters, inferred_);
    std::vector<double> more = known.third_term(changes);
    const std::optional<std::size_t> nv = density_.protocol().family().find_parameter(sim::Coefficient::nv);
    const auto place = std::ranges::find(inferred_, nv.value_or(parameters.size()));
    if (place != inferred_.end()) {
      const auto n = static_cast<std::size_t>(place - inferred_.begin());
      const double value = parameters[*nv], range = density_.quantile(*nv).range, relative = range / value;
      const double centred = value * value / variance;  // this part of Nv is in the coordinates
      for (std::size_t a = 0; a < count; ++a)
        more[triangle(std::max(a, n)) + std::min(a, n)] +=
            relative * known.second_term(changes[a]) * (a == n ? centred * (2.0 - centred) : centred);
      more[triangle(n) + n] -= 2.0 * static_cast<double>(noises_) * centred * centred * relative * relative;
    }
    add_while_positive(count, more, information);
  }

  const Density& density_;
  const PlannedRecordings& planned_;
  std::vector<sim::Parameters> participants_;
  Observation observation_;  // at rest: the information depends on a recording only through the sine of its angle
  std::size_t size_, noises_;
  std::vector<std::size_t> inferred_;
  std::vector<FractionPrior> priors_;
};

}  // namespace

ExpectedPosterior expected_posterior(const Density& density, const PlannedRecordings& planned) {
  check_plan(density, planned);
  const Planner planner(density, planned);
  const std::vector<std::vector<double>> variances = planner.variances();
  const std::vector<double> before = prior_variances(planner.priors());
  const auto parameters = static_cast<std::size_t>(density.parameters());
  const auto participants = static_cast<double>(variances.size()), inferred = static_cast<double>(before.size());
  ExpectedPosterior result{std::vector<double>(parameters, 0.0), std::vector<double>(parameters, 0.0),
                           std::vector<double>(parameters, 0.0)};
  if (planned.at) {
    result.at = planned.at;
    for (std::size_t p = 0; p < parameters; ++p) (*result.at)[p] = within_margin(density.quantile(p), (*planned.at)[p]);
  }
  std::vector<double> figures(variances.size(), 0.0);
  for (std::size_t a = 0; a < before.size(); ++a) {
    const std::size_t p = planner.inferred()[a];
    double mean = 0.0;
    for (std::size_t i = 0; i < variances.size(); ++i) {
      mean += variances[i][a] / participants;
      figures[i] += variances[i][a] / before[a] / inferred;
    }
    const double range = density.quantile(p).range;
    result.sd[p] = range * std::sqrt(mean);
    result.prior_sd[p] = range * std::sqrt(before[a]);
    result.relative_variance[p] = mean / before[a];
  }
  for (const double figure : figures) result.figure_of_merit += figure / participants;
  double squares = 0.0;
  for (const double figure : figures) squares += (figure - result.figure_of_merit) * (figure - result.figure_of_merit);
  if (figures.size() > 1) result.figure_error = std::sqrt(squares / participants / (participants - 1.0));
  return result;
}

}  // namespace decid::posterior
