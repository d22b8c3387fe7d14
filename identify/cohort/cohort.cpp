// Analysis of a study: see cohort.hpp.
#include "identify/cohort/cohort.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string_view>

#include "base/math/math.hpp"
#include "base/math/statistics.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "identify/cohort/detail/sampler.hpp"
#include "posterior/sampling/diagnostics.hpp"

namespace decid::cohort {
namespace {

/// Every draw of one quantity, chain after chain.
using Series = std::vector<double>;

double rhat_of(const Series& series, int chains) {
  posterior::ChainDraws parts;
  const std::ptrdiff_t length = std::ssize(series) / chains;
  for (int chain = 0; chain < chains; ++chain)
    parts.emplace_back(series.begin() + chain * length, series.begin() + (chain + 1) * length);
  return posterior::rhat(parts);
}

Quantity quantity_of(Series series, int chains) {
  Quantity quantity{mean(series), stddev(series), {}, rhat_of(series, chains)};
  std::ranges::sort(series);
  quantity.interval95 = {quantile_of_sorted(series, 0.025), quantile_of_sorted(series, 0.975)};
  return quantity;
}

/// All draws, and the study they are of.
struct Drawn {
  const Design& design;
  std::span<const sim::ParameterInfo> ranges;
  int chains;
  std::vector<Draw> draws;  // chain after chain

  Series series(const std::function<double(const Draw&)>& value) const {
    Series result;
    result.reserve(draws.size());
    for (const Draw& draw : draws) result.push_back(value(draw));
    return result;
  }
  Quantity quantity(const std::function<double(const Draw&)>& value) const {
    return quantity_of(series(value), chains);
  }
  double squared_sd(const std::vector<double>& sd, std::size_t p) const { return sd.empty() ? 0.0 : sd[p] * sd[p]; }
  double participant_variance(const Draw& draw, std::size_t cell, std::size_t p) const {
    const double sd = draw.participant_sd[design.group_of_cell[cell] * design.parameters + p];
    return sd * sd;
  }
  /// Returns the value in SI units of a coordinate that still varies by `variance`: the mean of Phi.
  double value(double x, double variance, std::size_t p) const {
    return ranges[p].low + ranges[p].range() * normal_distribution(x / std::sqrt(1.0 + variance));
  }
};

struct CellSeries {
  Series mean, sd;
};

/// The mean of a cell, and the standard deviation of its participants, by the trapezoidal rule over a normal deviate.
CellSeries cell_series(const Drawn& drawn, std::size_t cell, std::size_t p) {
  constexpr int grid = 17;
  constexpr double farthest = 4.8, apart = 2.0 * farthest / (grid - 1);
  std::array<double, grid> weights{};
  double whole = 0.0;
  for (int i = 0; i < grid; ++i) whole += weights[static_cast<std::size_t>(i)] = normal_density(-farthest + apart * i);
  CellSeries series;
  for (const Draw& draw : drawn.draws) {
    const double x = draw.cell_mean[cell * drawn.design.parameters + p];
    const double trial = drawn.squared_sd(draw.trial_sd, p);
    const double participants = drawn.participant_variance(draw, cell, p) + drawn.squared_sd(draw.visit_sd, p);
    const double middle = drawn.value(x, participants + trial, p);
    double squares = 0.0;
    for (int i = 0; i < grid; ++i) {
      const double off = drawn.value(x + std::sqrt(participants) * (-farthest + apart * i), trial, p) - middle;
      squares += weights[static_cast<std::size_t>(i)] / whole * off * off;
    }
    series.mean.push_back(middle);
    series.sd.push_back(std::sqrt(squares));
  }
  return series;
}

/// Sets intervals that hold all quantities together in 95% of the draws, whatever their dependence: each is the
/// interval of the same ranks (J. Besag, P. Green, D. Higdon, K. Mengersen, Statistical Science 10 (1995) 3-41, 6.3).
std::vector<std::array<double, 2>> simultaneous_intervals(const std::vector<Series>& all) {
  const std::size_t draws = all.front().size();
  std::vector<std::size_t> order(draws), extremes(draws, 0);
  for (const Series& series : all) {
    for (std::size_t i = 0; i < draws; ++i) order[i] = i;
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return series[i]; });
    for (std::size_t rank = 0; rank < draws; ++rank)
      extremes[order[rank]] = std::max({extremes[order[rank]], rank, draws - 1 - rank});
  }
  std::ranges::sort(extremes);
  const std::size_t high = extremes[std::min(draws - 1, (draws * 95 + 99) / 100 - 1)];
  std::vector<std::array<double, 2>> intervals;
  for (Series series : all) {
    std::ranges::sort(series);
    intervals.push_back({series[draws - 1 - high], series[high]});
  }
  return intervals;
}

std::size_t participants_in_both(const Design& design, std::size_t first, std::size_t second) {
  return static_cast<std::size_t>(
      std::ranges::count_if(design.participants, [&](const Design::Participant& participant) {
        const auto in = [&](std::size_t cell) {
          return std::ranges::any_of(participant.visits, [&](std::size_t v) { return design.visits[v].cell == cell; });
        };
        return in(first) && in(second);
      }));
}

double direction_of(const Series& series) {
  const auto above = static_cast<double>(std::ranges::count_if(series, [](double value) { return value > 0.0; }));
  const double fraction = above / static_cast<double>(series.size());
  return std::max(fraction, 1.0 - fraction);
}

/// Returns the effect of a difference whose participants have these variances, draw by draw.
Effect effect_of(const Series& difference, const Series& variance, int chains) {
  Series standardised;
  for (std::size_t i = 0; i < difference.size(); ++i) standardised.push_back(difference[i] / std::sqrt(variance[i]));
  // The posterior of a standard deviation may reach 0, and then no mean of this ratio exists: its median does.
  const double middle = median(standardised);
  Effect effect{
      quantity_of(difference, chains), {}, quantity_of(std::move(standardised), chains), direction_of(difference)};
  effect.standardised.mean = middle;
  return effect;
}

/// A difference of two cells in one parameter, and the mean variance between their participants.
struct Contrast {
  Series difference, variance;
};

/// Returns the place of what two cells differ in: 0 the group, 1 the session, 2 the condition.
int factor_of(const Cell& a, const Cell& b) {
  return a.group != b.group ? 0 : a.session != b.session ? 1 : 2;
}

/// Adds the differences of differences, and their draws to `contrasts`.
void add_interactions(const Drawn& drawn, std::vector<Contrast>& contrasts, Result& result) {
  const Design& design = drawn.design;
  const std::size_t count = result.comparisons.size();
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = a + 1; b < count; ++b) {
      const Comparison &first = result.comparisons[a], &second = result.comparisons[b];
      const auto cell = [&](std::size_t c) -> const Cell& { return result.cells[c]; };
      const auto linked = [&](std::size_t c, std::size_t d) { return differ_in_one(design.cells[c], design.cells[d]); };
      const int factor = factor_of(cell(first.first), cell(first.second));
      // Changes within groups, or within sessions: the differences between groups that change are the same numbers.
      if (!linked(first.first, second.first) || !linked(first.second, second.second) ||
          factor != factor_of(cell(second.first), cell(second.second)) ||
          factor_of(cell(first.first), cell(second.first)) >= factor ||
          factor_of(cell(first.second), cell(second.second)) >= factor)
        continue;
      Interaction interaction{a, b, {}};
      if (second_is_minuend(cell(first.first), cell(second.first))) std::swap(interaction.first, interaction.second);
      for (std::size_t p = 0; p < design.parameters; ++p) {
        Contrast made = contrasts[interaction.first * design.parameters + p];
        const Contrast& other = contrasts[interaction.second * design.parameters + p];
        for (std::size_t i = 0; i < made.difference.size(); ++i) {
          made.difference[i] -= other.difference[i];
          made.variance[i] = 0.5 * (made.variance[i] + other.variance[i]);
        }
        interaction.effects.push_back(effect_of(made.difference, made.variance, drawn.chains));
        contrasts.push_back(std::move(made));
      }
      result.interactions.push_back(std::move(interaction));
    }
}

void add_comparisons(const Drawn& drawn, const std::vector<std::vector<CellSeries>>& cells, Result& result) {
  const Design& design = drawn.design;
  std::vector<Contrast> contrasts;
  for (std::size_t a = 0; a < cells.size(); ++a)
    for (std::size_t b = a + 1; b < cells.size(); ++b) {
      if (!differ_in_one(design.cells[a], design.cells[b])) continue;
      Comparison comparison{a, b, participants_in_both(design, a, b), {}};
      if (second_is_minuend(design.cells[a], design.cells[b])) std::swap(comparison.first, comparison.second);
      for (std::size_t p = 0; p < design.parameters; ++p) {
        const CellSeries &first = cells[comparison.first][p], &second = cells[comparison.second][p];
        Contrast made;
        for (std::size_t i = 0; i < first.mean.size(); ++i) {
          made.difference.push_back(first.mean[i] - second.mean[i]);
          made.variance.push_back(0.5 * (first.sd[i] * first.sd[i] + second.sd[i] * second.sd[i]));
        }
        comparison.effects.push_back(effect_of(made.difference, made.variance, drawn.chains));
        contrasts.push_back(std::move(made));
      }
      result.comparisons.push_back(std::move(comparison));
    }
  if (contrasts.empty()) return;
  add_interactions(drawn, contrasts, result);
  std::vector<Series> differences;
  for (Contrast& contrast : contrasts) differences.push_back(std::move(contrast.difference));
  const std::vector<std::array<double, 2>> intervals = simultaneous_intervals(differences);
  std::size_t place = 0;
  const auto set = [&](std::vector<Effect>& effects) {
    for (Effect& effect : effects) effect.simultaneous95 = intervals[place++];
  };
  for (Comparison& comparison : result.comparisons) set(comparison.effects);
  for (Interaction& interaction : result.interactions) set(interaction.effects);
}

/// Mean of the cells' means, a coordinate.
double middle_of(const Drawn& drawn, const Draw& draw, std::size_t p) {
  double sum = 0.0;
  for (std::size_t c = 0; c < drawn.design.cells.size(); ++c) sum += draw.cell_mean[c * drawn.design.parameters + p];
  return sum / static_cast<double>(drawn.design.cells.size());
}

void add_variances(const Drawn& drawn, std::span<const Recording> recordings, Result& result) {
  const Design& design = drawn.design;
  for (std::size_t p = 0; p < design.parameters; ++p) {
    const auto slope = [&](const Draw& draw) {
      return drawn.ranges[p].range() * normal_density(middle_of(drawn, draw, p));
    };
    const auto part = [&](std::vector<double> Draw::*sd) {
      return drawn.quantity([&](const Draw& draw) { return slope(draw) * std::sqrt(drawn.squared_sd(draw.*sd, p)); });
    };
    VarianceParts parts;
    parts.participant = drawn.quantity([&](const Draw& draw) {
      double sum = 0.0;
      for (std::size_t g = 0; g < design.groups; ++g)
        sum += drawn.squared_sd(draw.participant_sd, g * design.parameters + p);
      return slope(draw) * std::sqrt(sum / static_cast<double>(design.groups));
    });
    parts.visit = part(&Draw::visit_sd);
    parts.trial = part(&Draw::trial_sd);
    std::vector<double> variances;
    for (const Recording& one : recordings) variances.push_back(one.measurement.variance(p));
    parts.measurement = mean(drawn.series(slope)) * std::sqrt(quantile(std::move(variances), 0.5));
    result.variances.push_back(parts);
  }
}

void add_visits(const Drawn& drawn, Result& result) {
  const Design& design = drawn.design;
  std::vector<std::vector<Series>> all(design.visits.size());
  result.visits.resize(design.visits.size());
  parallel_for(static_cast<int>(design.visits.size()), [&](int place) {
    const auto v = static_cast<std::size_t>(place);
    const Design::Visit& visit = design.visits[v];
    result.visits[v] = {design.participants[visit.participant].name, visit.cell, visit.recordings.size(), {}};
    for (std::size_t p = 0; p < design.parameters; ++p) {
      all[v].push_back(drawn.series([&](const Draw& draw) {
        return drawn.value(draw.visits[v * design.parameters + p], drawn.squared_sd(draw.trial_sd, p), p);
      }));
      result.visits[v].value.push_back(quantity_of(all[v].back(), drawn.chains));
    }
  });
  for (const Design::Participant& participant : design.participants)
    for (std::size_t c = 0; c < result.comparisons.size(); ++c) {
      const auto visit_in = [&](std::size_t cell) {
        return std::ranges::find_if(participant.visits, [&](std::size_t v) { return design.visits[v].cell == cell; });
      };
      const auto first = visit_in(result.comparisons[c].first), second = visit_in(result.comparisons[c].second);
      if (first == participant.visits.end() || second == participant.visits.end()) continue;
      result.changes.push_back({c, *first, *second, {}});
    }
  parallel_for(static_cast<int>(result.changes.size()), [&](int place) {
    Change& change = result.changes[static_cast<std::size_t>(place)];
    for (std::size_t p = 0; p < design.parameters; ++p) {
      Series difference = all[change.first][p];
      for (std::size_t i = 0; i < difference.size(); ++i) difference[i] -= all[change.second][p][i];
      change.difference.push_back(quantity_of(std::move(difference), drawn.chains));
    }
  });
}

void add_covariates(const Drawn& drawn, std::span<const Recording> recordings, const std::vector<std::string>& names,
                    Result& result) {
  const Design& design = drawn.design;
  for (std::size_t k = 0; k < names.size(); ++k) {
    Covariate& one = result.covariates.emplace_back(Covariate{names[k], design.covariate_mean[k], 0, {}});
    for (const Recording& recording : recordings) one.unknown += std::isnan(recording.covariates[k]) ? 1U : 0U;
    for (std::size_t p = 0; p < design.parameters; ++p) {
      const Series series = drawn.series([&](const Draw& draw) {
        // The derivative of the population's mean: value() by x.
        double participants = 0.0;
        for (std::size_t c = 0; c < design.cells.size(); ++c) participants += drawn.participant_variance(draw, c, p);
        const double wider = std::sqrt(1.0 + participants / static_cast<double>(design.cells.size()) +
                                       drawn.squared_sd(draw.visit_sd, p) + drawn.squared_sd(draw.trial_sd, p));
        return drawn.ranges[p].range() * normal_density(middle_of(drawn, draw, p) / wider) / wider *
               draw.slopes[k * design.parameters + p] / design.covariate_sd[k];
      });
      one.slopes.push_back({quantity_of(series, drawn.chains), direction_of(series)});
    }
  }
}

/// Returns the largest R-hat of all quantities.
double max_rhat_of(const Result& result) {
  double largest = 1.0;
  const auto add = [&](const Quantity& quantity) { largest = std::max(largest, quantity.rhat); };
  const auto add_effects = [&](const std::vector<Effect>& effects) {
    for (const Effect& effect : effects) {
      add(effect.difference);
      add(effect.standardised);
    }
  };
  for (const Cell& cell : result.cells) {
    std::ranges::for_each(cell.mean, add);
    std::ranges::for_each(cell.between_sd, add);
  }
  for (const Comparison& comparison : result.comparisons) add_effects(comparison.effects);
  for (const Interaction& interaction : result.interactions) add_effects(interaction.effects);
  for (const VarianceParts& parts : result.variances)
    for (const Quantity& part : {parts.participant, parts.visit, parts.trial}) add(part);
  for (const Covariate& covariate : result.covariates) std::ranges::for_each(covariate.slopes, add);
  for (const Visit& visit : result.visits) std::ranges::for_each(visit.value, add);
  for (const Change& change : result.changes) std::ranges::for_each(change.difference, add);
  return largest;
}

std::vector<Draw> sample(const Design& design, std::span<const Recording> recordings, const Settings& settings) {
  std::vector<std::vector<Draw>> chains(static_cast<std::size_t>(settings.chains));
  parallel_for(settings.chains, [&](int chain) {
    const auto number = static_cast<std::size_t>(chain);
    Sampler sampler(design, recordings, settings.seed, number);
    for (int i = 0; i < settings.warm_up; ++i) sampler.sweep();
    for (int i = 0; i < settings.draws; ++i) {
      sampler.sweep();
      chains[number].push_back(sampler.draw());
    }
  });
  std::vector<Draw> all;
  for (std::vector<Draw>& chain : chains)
    for (Draw& draw : chain) all.push_back(std::move(draw));
  return all;
}

/// Returns 0 for a session before a treatment by its first word, 2 for one after it, else 1.
int stage_of(const std::string& session) {
  constexpr auto before =
      std::to_array<std::string_view>({"pre", "before", "baseline", "base", "initial", "test", "entry", "admission",
                                       "vor", "vorher", "prae", "pr\u00e4", "eingang", "aufnahme", "avant"});
  constexpr auto after =
      std::to_array<std::string_view>({"post", "after", "follow", "followup", "fu", "final", "retention", "retest",
                                       "exit", "discharge", "nach", "nachher", "ausgang", "entlassung", "apr\u00e8s"});
  const std::string text = lower_case(session);
  const auto end = std::ranges::find_if_not(
      text, [](char c) { return (c >= 'a' && c <= 'z') || static_cast<unsigned char>(c) > 127; });
  const std::string_view word(text.data(), static_cast<std::size_t>(end - text.begin()));
  if (std::ranges::find(before, word) != before.end()) return 0;
  return std::ranges::find(after, word) != after.end() ? 2 : 1;
}

}  // namespace

bool second_is_later(const std::string& first, const std::string& second) {
  return stage_of(first) <= stage_of(second);
}

std::string cell_name(const std::string& group, const std::string& session, const std::string& condition) {
  std::string text;
  const bool has_more = !session.empty() || !condition.empty();
  for (const std::string& part : {has_more && group == everyone ? std::string() : group, session, condition})
    if (!part.empty()) text += (text.empty() ? "" : ", ") + part;
  return text;
}

Result analyse(std::span<const Recording> recordings, std::span<const sim::ParameterInfo> ranges,
               const Settings& settings) {
  const Design design = make_design(recordings, ranges.size(), settings);
  const Drawn drawn{design, ranges, settings.chains, sample(design, recordings, settings)};
  Result result;
  result.draws = static_cast<int>(drawn.draws.size());
  std::vector<std::vector<CellSeries>> cells(design.cells.size());
  for (std::size_t c = 0; c < design.cells.size(); ++c) {
    Cell cell{design.cells[c].group, design.cells[c].session, design.cells[c].condition, 0, 0, {}, {}};
    for (const Design::Visit& visit : design.visits) {
      if (visit.cell != c) continue;
      ++cell.participants;
      cell.recordings += visit.recordings.size();
    }
    for (std::size_t p = 0; p < design.parameters; ++p) {
      cells[c].push_back(cell_series(drawn, c, p));
      cell.mean.push_back(quantity_of(cells[c][p].mean, drawn.chains));
      cell.between_sd.push_back(quantity_of(cells[c][p].sd, drawn.chains));
    }
    result.cells.push_back(std::move(cell));
  }
  add_comparisons(drawn, cells, result);
  add_variances(drawn, recordings, result);
  add_covariates(drawn, recordings, settings.covariates, result);
  add_visits(drawn, result);
  result.max_rhat = max_rhat_of(result);
  return result;
}

}  // namespace decid::cohort
