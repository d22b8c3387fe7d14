// Samples on an even grid: see even_samples.hpp. Cubic interpolation is Lagrange's through four points. At a hundredth
// of the sample rate it errs by less than (2 pi / 100)^4 3 / 128 = 4e-7 of the amplitude.
#include "recording/detail/even_samples.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/setting.hpp"
#include "recording/recording.hpp"
#include "recording/table/columns.hpp"

namespace decid::recording {

std::vector<double> place_evenly(const std::vector<double>& values, const Clock& clock) {
  if (clock.place.empty()) return values;
  const std::vector<double>& place = clock.place;
  const auto count = static_cast<std::size_t>(std::floor(place.back() + even_step)) + 1;
  std::vector<double> result(count, std::numeric_limits<double>::quiet_NaN());
  const auto apart = [&](std::size_t i) { return place[i + 1] - place[i] > clock.gap; };
  const auto is_close = [&](std::size_t i) { return place[i + 1] - place[i] < gross_step; };
  std::size_t i = 0;  // the samples around j are i and i + 1
  for (std::size_t j = 0; j < count; ++j) {
    const double at = static_cast<double>(j);
    while (i + 2 < place.size() && place[i + 1] <= at) ++i;
    const bool second = at - place[i] > place[i + 1] - at;
    const std::size_t nearest = second ? i + 1 : i;
    if (std::abs(place[nearest] - at) <= even_step || (apart(i) && std::abs(place[nearest] - at) <= gross_step)) {
      result[j] = values[nearest];
      continue;
    }
    if (apart(i)) continue;
    const bool inner = i > 0 && i + 2 < place.size() && !apart(i - 1) && !apart(i + 1) && !is_close(i - 1) &&
                       !is_close(i) && !is_close(i + 1) && std::isfinite(values[i - 1]) && std::isfinite(values[i + 2]);
    const std::size_t first = inner ? i - 1 : i, last = inner ? i + 2 : i + 1;
    double sum = 0.0;
    for (std::size_t a = first; a <= last; ++a) {
      double weight = 1.0;
      for (std::size_t b = first; b <= last; ++b) {
        if (a != b) weight *= (at - place[b]) / (place[a] - place[b]);
      }
      sum += weight * values[a];
    }
    result[j] = sum;  // NaN if a neighbour is missing
  }
  return result;
}

std::string fill_gaps(std::vector<double>& values, double rate_hz, double longest_s, const std::string& name,
                      const std::string& where, const std::function<std::string(std::size_t first)>& place_of,
                      std::vector<SampleRange>& gaps) {
  constexpr double pause_s = 5.0;  // a longer gap may be a pause of the platform, which no line bridges
  std::size_t count = 0, filled = 0, longest = 0, all = 0, all_gaps = 0, all_missing = 0;
  for (std::size_t k = 0, length = 0; k < values.size(); ++k) {
    length = std::isnan(values[k]) ? length + 1 : 0;
    all = std::max(all, length);
    all_gaps += length == 1 ? 1 : 0;
    all_missing += length > 0 ? 1 : 0;
  }
  const double all_s = static_cast<double>(all) / rate_hz;
  for (std::size_t begin = 0; begin < values.size(); ++begin) {
    if (!std::isnan(values[begin])) continue;
    std::size_t end = begin;
    while (end < values.size() && std::isnan(values[end])) ++end;
    const std::size_t length = end - begin;
    const double length_s = static_cast<double>(length) / rate_hz;
    if (length == values.size())
      throw Error(Code::value_missing, where, "all values of " + name + " are missing", "name another column");
    if (length_s > longest_s * (1.0 + 1e-9)) {
      throw Error(
          Code::value_missing, where,
          place_of(begin) + name + " lacks " + std::to_string(length) + (length == 1 ? " sample (" : " samples (") +
              six_digits(length_s) + " s) from " + six_digits(static_cast<double>(begin) / rate_hz) +
              " s after the first one" +
              (longest_s > 0.0 ? ", more than " + setting("fill_gaps") + " " + six_digits(longest_s) : "") +
              (all_gaps > 1 ? "; it has " + std::to_string(all_gaps) + " gaps of " + std::to_string(all_missing) +
                                  " samples in all, the longest " + std::to_string(all) +
                                  (all == 1 ? " sample (" : " samples (") + six_digits(all_s) + " s)"
                            : ""),
          all_s > longest_gap_s
              ? "its longest gap, " + six_digits(all_s) +
                    " s, is too long to interpolate: give the part before or after it"
              : setting("fill_gaps") + " " + six_digits(std::ceil(all_s * 1e4) / 1e4) + " interpolates all its gaps" +
                    (all_s > pause_s ? "; if the platform paused meanwhile, give the part before or after it" : ""));
    }
    for (std::size_t k = begin; k < end; ++k) {
      if (begin == 0) {
        values[k] = values[end];
      } else if (end == values.size()) {
        values[k] = values[begin - 1];
      } else {
        const double part = static_cast<double>(k - begin + 1) / static_cast<double>(length + 1);
        values[k] = values[begin - 1] + part * (values[end] - values[begin - 1]);
      }
    }
    gaps.push_back({begin, end});
    ++count;
    filled += length;
    longest = std::max(longest, length);
    begin = end;
  }
  if (count == 0) return {};
  return std::to_string(filled) + (filled == 1 ? " missing value of " : " missing values of ") + name + " in " +
         std::to_string(count) + (count == 1 ? " gap" : " gaps") + ", the longest " +
         six_digits(static_cast<double>(longest) / rate_hz) + " s, " + (filled == 1 ? "is" : "are") +
         " interpolated (" + three_digits(100.0 * static_cast<double>(filled) / static_cast<double>(values.size())) +
         "% of the recording)";
}

}  // namespace decid::recording
