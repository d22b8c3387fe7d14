// Sample times: see clock.hpp.
#include "recording/detail/clock.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.hpp"
#include "base/math/statistics.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {

namespace {

/// Steps longer than this make interpolated sway a guess; docs/reference/accuracy.md has the measurement.
constexpr double long_step_s = 0.1;

/// An even grid fitted to times by least squares.
struct Grid {
  double step;   ///< in the column's unit
  double width;  ///< from the earliest to the latest time, counted from the grid
};

Grid fit_grid(const std::vector<double>& time) {
  const double n = static_cast<double>(time.size());
  const double mean_k = 0.5 * (n - 1.0);
  double mean = 0.0, product = 0.0;
  for (const double t : time) mean += (t - time.front()) / n;
  for (std::size_t k = 0; k < time.size(); ++k) {
    product += (static_cast<double>(k) - mean_k) * (time[k] - time.front() - mean);
  }
  const double step = product / (n * (n * n - 1.0) / 12.0);
  double low = 0.0, high = 0.0;
  for (std::size_t k = 0; k < time.size(); ++k) {
    const double off = time[k] - time.front() - step * static_cast<double>(k);
    low = std::min(low, off);
    high = std::max(high, off);
  }
  return {step, high - low};
}

/// Returns true if every time is a whole multiple of `resolution`.
bool are_multiples(const std::vector<double>& time, double resolution) {
  return std::ranges::all_of(time,
                             [&](double t) { return std::abs(t / resolution - std::round(t / resolution)) < 1e-3; });
}

/// Returns the step of an even grid whose rounded values are the times, in the column's unit. Rounding moves a time by
/// half a unit in either direction, so rounded times lie within one unit of a straight line.
std::optional<double> rounded_step(const std::vector<double>& time, double unit_s) {
  const Grid grid = fit_grid(time);
  for (const double resolution_s : {1e-3, 1e-4}) {
    const double resolution = resolution_s / unit_s;
    if (grid.width <= 1.05 * resolution && 3.0 * resolution <= grid.step && are_multiples(time, resolution))
      return grid.step;
  }
  return {};
}

/// Returns the largest distance between times and a straight line of this step, in both directions, in the column's
/// unit.
double width_at(const std::vector<std::pair<double, double>>& ends, double step) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& [place, time] : ends) {
    const double off = time - step * place;
    low = std::min(low, off);
    high = std::max(high, off);
  }
  return high - low;
}

/// Returns the grid that is nearest to the times in its largest distance, which is convex in the step. Least squares
/// would tilt the grid where the first or the last samples that share a time are fewer than the others.
Grid narrowest_grid(const std::vector<std::pair<double, double>>& ends, double step, double resolution) {
  constexpr int steps = 100;
  const double reach = 4.0 * resolution / std::max(1.0, ends.back().first);
  double low = step - reach, high = step + reach;
  for (int i = 0; i < steps; ++i) {
    const double third = (high - low) / 3.0;
    if (width_at(ends, low + third) < width_at(ends, high - third)) {
      high -= third;
    } else {
      low += third;
    }
  }
  step = 0.5 * (low + high);
  return {step, width_at(ends, step)};
}

/// Returns the clock of an even grid whose times are rounded so coarsely that samples share them. Returns nothing for
/// other times.
std::optional<Clock> coarse_clock(const std::vector<double>& time, double unit_s, const std::string& name) {
  if (time.size() < 100 || time.back() <= time.front() || !std::ranges::is_sorted(time) ||
      std::ranges::adjacent_find(time) == time.end())
    return {};
  // A duplicated row is a different fault.
  std::size_t shared = 0;
  for (std::size_t k = 1; k < time.size(); ++k) shared += time[k] == time[k - 1] ? 1 : 0;
  if (10 * shared < time.size()) return {};
  // Only the first and the last of the samples that share a time can be the farthest from a line.
  std::vector<std::pair<double, double>> ends;
  for (std::size_t k = 0; k < time.size(); ++k)
    if (k == 0 || k + 1 == time.size() || time[k] != time[k - 1] || time[k] != time[k + 1])
      ends.emplace_back(static_cast<double>(k), time[k] - time.front());
  const double least_squares = fit_grid(time).step;
  const double n = static_cast<double>(time.size());
  for (const double resolution_s : {1e-3, 1e-2, 1e-1, 1.0}) {
    const double resolution = resolution_s / unit_s;
    if (n * least_squares < 100.0 * resolution || !are_multiples(time, resolution)) continue;
    const auto [step, width] = narrowest_grid(ends, least_squares, resolution);
    if (width > 1.05 * resolution) continue;
    Clock clock;
    clock.rate_hz = 1.0 / (step * unit_s);
    const double nearest = std::round(clock.rate_hz);
    if (nearest > 0.0 && width_at(ends, 1.0 / (nearest * unit_s)) <= 1.05 * resolution) clock.rate_hz = nearest;
    clock.is_caution = clock.has_shared_times = true;
    clock.warning = "the times of '" + name + "' are rounded to " + six_digits(resolution_s) +
                    " s, so several samples share a time: decid assumes an even rate of " + six_digits(clock.rate_hz) +
                    " Hz";
    return clock;
  }
  return {};
}

/// Adds a warning about uneven times. `largest`: the largest distance of a step from its place, in samples.
void warn_of_uneven_times(Clock& clock, double largest, double longest_step_s, const std::string& name,
                          const std::string& setting_name) {
  clock.is_caution = longest_step_s > long_step_s;
  clock.warning = "the times of '" + name + "' are uneven, steps differ by up to " + three_digits(100.0 * largest) +
                  "% of a sample: interpolated to " + six_digits(clock.rate_hz) + " Hz" +
                  (clock.is_caution ? ", over up to " + three_digits(longest_step_s) + " s" : "") + "; give " +
                  setting_name + " if the samples are evenly spaced";
}

/// Returns true if the steps follow no grid, as those of headsets and webcams: a few uneven steps are a fault.
bool follow_no_grid(const std::vector<double>& steps, double usual) {
  constexpr std::size_t min_steps = 100, uneven_divisor = 10;  // one in ten
  const auto is_uneven = [&](double step) {
    return std::abs(step - std::max(1.0, std::round(step / usual)) * usual) > even_step * usual;
  };
  return steps.size() >= min_steps &&
         uneven_divisor * static_cast<std::size_t>(std::ranges::count_if(steps, is_uneven)) >= steps.size();
}

/// Returns the clock of times that follow no grid and never go backwards. Returns nothing for other times.
std::optional<Clock> clock_without_grid(const std::vector<double>& time, const std::vector<double>& steps, double usual,
                                        double unit_s) {
  constexpr double gap_steps = 2.5;
  if (std::ranges::any_of(steps, [](double step) { return !(step > 0.0); }) || !follow_no_grid(steps, usual)) return {};
  double sum = 0.0, count = 0.0;
  for (const double step : steps) {
    if (step > gap_steps * usual) continue;
    sum += step;
    count += 1.0;
  }
  const double per_unit = count / sum;
  if (!((time.back() - time.front()) * per_unit < static_cast<double>(max_rows))) return {};
  Clock clock;
  clock.rate_hz = near_whole(per_unit / unit_s);
  clock.gap = gap_steps * usual * per_unit;
  for (const double t : time) clock.place.push_back((t - time.front()) * per_unit);
  return clock;
}

std::vector<double> steps_between(const std::vector<double>& time) {
  std::vector<double> steps(time.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = time[i + 1] - time[i];
  return steps;
}

/// Returns true if step i goes far back, to the first time: the times begin again.
bool begins_again(const std::vector<double>& time, const std::vector<double>& steps, double usual, std::size_t i) {
  return steps[i] < -10.0 * usual && time[i + 1] <= time.front() + usual;
}

/// A time column, and where messages say that it is.
struct Times {
  const Table& table;
  const std::string &name, &where, &setting_name;
  std::vector<double> time;
  double unit_s;
  std::vector<double> steps = steps_between(time);
  double usual = median(steps);

  bool is_even(double step) const { return step > 0.0 && std::abs(step - usual) <= even_step * usual; }
  double length() const { return time.back() - time.front(); }

  std::string describe_step(std::size_t i) const {
    const std::string here = table.locate(i + 1) + ": '" + name + "' ";
    if (steps[i] == 0.0) return here + "repeats";
    if (steps[i] < 0.0) return here + "goes backwards, by " + six_digits(-steps[i]);
    return here + "steps by " + six_digits(steps[i]) + ", elsewhere by " + six_digits(usual);
  }
  std::string first_uneven() const {
    const auto uneven = std::ranges::find_if_not(steps, [&](double step) { return is_even(step); });
    return describe_step(static_cast<std::size_t>(uneven - steps.begin()));
  }
};

/// Adds the unevenness of times without a grid.
Clock with_unevenness(Clock clock, const Times& times) {
  clock.first_uneven = times.first_uneven();
  double largest = 0.0, longest = 0.0;
  for (std::size_t i = 1; i < clock.place.size(); ++i) {
    const double step = clock.place[i] - clock.place[i - 1];
    if (step > clock.gap) continue;
    largest = std::max(largest, std::abs(step - 1.0));
    longest = std::max(longest, step);
  }
  warn_of_uneven_times(clock, largest, longest / clock.rate_hz, times.name, times.setting_name);
  return clock;
}

/// Returns the place of the last sample on a grid of the usual step. Throws Error for a step that is not a multiple of
/// it.
double count_places(const Times& times) {
  double places = 0.0;
  for (std::size_t i = 0; i < times.steps.size(); ++i) {
    const double step = times.steps[i], multiple = std::round(step / times.usual);
    if (times.usual <= 0.0 && step > 0.0) continue;  // a later step is the one to report
    // The condition is written so that a NaN step fails. No gap is as long as the longest recording.
    if (step > 0.0 && multiple >= 1.0 && std::abs(step - multiple * times.usual) <= gross_step * times.usual &&
        places + multiple < static_cast<double>(max_rows)) {
      places += multiple;
      continue;
    }
    // Among times without a grid only steps that do not go on are faults.
    const auto backwards = std::ranges::find_if(times.steps, [](double other) { return !(other > 0.0); });
    const bool is_free = backwards != times.steps.end() && follow_no_grid(times.steps, times.usual);
    throw Error(Code::times_uneven, times.where,
                times.describe_step(is_free ? static_cast<std::size_t>(backwards - times.steps.begin()) : i),
                "correct the times, or give " + times.setting_name + " if the samples are evenly spaced");
  }
  return places;
}

/// Returns the clock of times on a grid with gaps.
Clock clock_with_gaps(const Times& times) {
  const double places = count_places(times);
  Clock clock;
  clock.first_uneven = times.first_uneven();
  clock.rate_hz = near_whole(places / (times.length() * times.unit_s));
  const double per_unit = places / times.length();
  double largest = 0.0;
  for (std::size_t i = 0; i < times.time.size(); ++i) {
    clock.place.push_back((times.time[i] - times.time.front()) * per_unit);
    if (i > 0) {
      const double step = clock.place[i] - clock.place[i - 1];
      largest = std::max(largest, std::abs(step - std::max(1.0, std::round(step))));
    }
  }
  if (largest > even_step)
    warn_of_uneven_times(clock, largest, (1.0 + largest) / clock.rate_hz, times.name, times.setting_name);
  return clock;
}

Clock clock_of(const Times& times) {
  const std::vector<double>&time = times.time, &steps = times.steps;
  const double unit_s = times.unit_s, last = static_cast<double>(steps.size());
  if (const std::optional<Clock> rounded = coarse_clock(time, unit_s, times.name)) return *rounded;
  if (times.usual < 0.0)
    throw Error(Code::times_uneven, times.where, "'" + times.name + "' runs backwards",
                "reverse the rows, or give " + times.setting_name + " if the samples are in order");
  Clock clock;
  if (std::ranges::all_of(steps, [&](double step) { return times.is_even(step); })) {
    // Steps agree with the median to 1%; their mean is exact where the times were rounded.
    clock.rate_hz = near_whole(1.0 / (times.length() / last * unit_s));
    return clock;
  }
  for (std::size_t i = 0; i < steps.size(); ++i)
    if (times.usual > 0.0 && begins_again(time, steps, times.usual, i))
      throw Error(Code::recording_ambiguous, times.where,
                  times.table.locate(i + 1) + ": '" + times.name + "' starts again: the file holds several recordings",
                  "save each recording as its own file");
  if (const std::optional<double> step = rounded_step(time, unit_s)) {
    clock.rate_hz = near_whole(1.0 / (*step * unit_s));
    // A whole number of samples per second is likelier than a rate slightly off; rounded times fit both.
    const double whole = std::round(clock.rate_hz);
    if (std::abs(whole / clock.rate_hz - 1.0) * last < 0.5 * 1e-3 * clock.rate_hz) clock.rate_hz = whole;
    return clock;
  }
  if (std::optional<Clock> free = clock_without_grid(time, steps, times.usual, unit_s))
    return with_unevenness(std::move(*free), times);
  return clock_with_gaps(times);
}

/// Returns the unit of times: their name's, or the one in which the first is a Unix time from 2001 to 2096.
double unit_of_times_s(const std::string& name, double first) {
  if (const double named = time_unit_s(name); named != 1.0) return named;
  constexpr double year_2001_s = 1e9, year_2096_s = 4e9;
  for (const double unit_s : {1e-3, 1e-6, 1e-9})
    if (first * unit_s >= year_2001_s && first * unit_s < year_2096_s) return unit_s;
  return 1.0;
}

}  // namespace

Clock read_clock(const Table& table, int column, const std::string& where, const std::string& setting_name) {
  const std::string& name = table.name(column);
  std::vector<double> read = table.times(column);
  const double unit_s = unit_of_times_s(name, read.front());
  const Times times{table, name, where, setting_name, std::move(read), unit_s};
  Clock clock = clock_of(times);
  clock.unit_s = unit_s;
  clock.first_s = times.time.front() * unit_s;
  return clock;
}

std::vector<std::size_t> restarts(const Table& table, int column) {
  constexpr std::size_t min_times = 20;
  std::vector<double> time;
  try {
    time = table.times(column);
  } catch (const Error&) {  // the file has no times
  }
  if (time.size() < min_times) return {};
  const std::vector<double> steps = steps_between(time);
  const auto [first, last] = std::ranges::minmax(time);
  const double usual = median(steps), far = 0.1 * (last - first);
  std::vector<std::size_t> rows;
  for (std::size_t i = 1; i < steps.size(); ++i) {
    const bool at_front = begins_again(time, steps, usual, i);
    if (!(-steps[i] > far || (usual > 0.0 && at_front))) continue;
    const bool is_single = steps[i - 1] >= far || (i + 1 < steps.size() && steps[i + 1] >= far);
    if (!is_single) rows.push_back(i + 1);
  }
  return rows;
}

}  // namespace decid::recording
