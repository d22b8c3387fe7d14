// The uncertainty of recordings of a planned study: see planning.hpp.
#include "identify/cohort/planning.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/math/statistics.hpp"
#include "base/text.hpp"
#include "identify/cohort/measurement.hpp"
#include "identify/cohort/streams.hpp"
#include "identify/identify.hpp"
#include "sim/protocol/conditions.hpp"
#include "sim/streams.hpp"

namespace decid::cohort {

sim::Parameters measurement_sd(const Model& model, const sim::Protocol& protocol, const sim::Parameters& at,
                               const sim::Parameters& person_sd, int trials, std::uint64_t seed) {
  const sim::ParameterTable& table = model.parameters();
  if (!model.gives_distribution() || trials < 1)
    throw Error(model.gives_distribution() ? Code::setting_out_of_range : Code::not_supported, "power",
                model.gives_distribution() ? "no recordings are simulated" : "the model gives no distribution",
                "simulate one recording or more, with a model that has a mixture head");
  for (std::size_t p = 0; p < table.size(); ++p)
    if (!(at[p] > table[p].low && at[p] < table[p].high))
      throw Error(Code::setting_out_of_range, "power", format("the mean of %s is %g", table[p].name.c_str(), at[p]),
                  format("give one between %g and %g", table[p].low, table[p].high));

  const sim::Simulator simulator(protocol);
  std::vector<recording::Trial> read(static_cast<std::size_t>(trials));
  simulator.run_until_valid(
      trials, 1000,
      [&](int index, int attempt) {
        const auto item = static_cast<std::uint64_t>(index) * 1000 + static_cast<std::uint64_t>(attempt);
        const Random random(seed, streams::cohort, item);
        sim::Parameters person = at;
        for (std::size_t p = 0; p < table.size(); ++p)
          person[p] = std::clamp(at[p] + person_sd[p] * random.normal(p), table[p].low, table[p].high);
        return sim::TrialInput{person, Random(seed, sim::streams::vestibular_noise, item)};
      },
      [&](int index, const sim::TrialInput&, std::span<double> sway) {
        sim::record(protocol, seed, static_cast<std::uint64_t>(index), sway);
        read[static_cast<std::size_t>(index)] = recording::trial_of({sway.begin(), sway.end()});
      });
  Identifier identifier(model);
  std::vector<std::vector<double>> variances(table.size());
  for (const Estimate& estimate : identifier.estimate(read)) {
    const Measurement measurement = Measurement::of_distribution(*estimate.distribution);
    for (std::size_t p = 0; p < table.size(); ++p) variances[p].push_back(measurement.variance(p));
  }
  sim::Parameters found(table.size());
  for (std::size_t p = 0; p < table.size(); ++p) {
    const double coordinate = inverse_normal((at[p] - table[p].low) / table[p].range());
    found[p] = table[p].range() * normal_density(coordinate) * std::sqrt(median(std::move(variances[p])));
  }
  return found;
}

}  // namespace decid::cohort
