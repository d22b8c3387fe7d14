// The least misfit within ranges: see optimum.hpp.
#include "posterior/frf/optimum.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/math/cholesky.hpp"
#include "base/math/random.hpp"
#include "base/parallel.hpp"
#include "base/text.hpp"
#include "posterior/streams.hpp"

namespace decid::frf {
namespace {

constexpr int max_attempts = 1000;
constexpr double first_damping = 1e-2, max_damping = 1e10, min_damping = 1e-12;
constexpr double min_information = 1e-9;  // of a coordinate without effect
constexpr double settled = 1e-14;         // relative decrease of the misfit
constexpr double alike = 1e-6;
constexpr std::uint64_t of_starts = std::uint64_t{1} << 33;  // the particle number of these random numbers

struct End {
  std::vector<double> x;
  Local local;
};

class Descent {
 public:
  Descent(std::size_t uniform, const Evaluate& evaluate) : uniform_(uniform), evaluate_(evaluate) {}

  End end_at(std::vector<double> x) const {
    End end{std::move(x), {}};
    const std::size_t size = end.x.size();
    end.local.gradient.resize(size);
    end.local.information.resize(triangle(size));
    evaluate_(end.x, end.local);
    for (std::size_t i = uniform_; i < size && std::isfinite(end.local.misfit); ++i) {
      end.local.misfit += 0.5 * end.x[i] * end.x[i];
      end.local.gradient[i] += end.x[i];
      end.local.information[triangle(i) + i] += 1.0;
    }
    return end;
  }

  End operator()(End end, int max_steps) const {
    double damping = first_damping;
    for (int step = 0; step < max_steps && damping < max_damping; ++step) {
      End next = end_at(stepped(end, damping));
      if (!(next.local.misfit < end.local.misfit)) {
        damping *= 4.0;
        continue;
      }
      const double decrease = end.local.misfit - next.local.misfit;
      end = std::move(next);
      damping = std::max(0.2 * damping, min_damping);
      if (decrease <= settled * std::abs(end.local.misfit)) break;
    }
    return end;
  }

 private:
  /// Returns the coordinates after a step in those that do not push against their bounds.
  std::vector<double> stepped(const End& end, double damping) const {
    std::vector<std::size_t> free;
    for (std::size_t i = 0; i < end.x.size(); ++i) {
      const bool pushes = i < uniform_ && ((end.x[i] <= 0.0 && end.local.gradient[i] > 0.0) ||
                                           (end.x[i] >= 1.0 && end.local.gradient[i] < 0.0));
      if (!pushes) free.push_back(i);
    }
    std::vector<double> factor(triangle(free.size())), step(free.size());
    for (std::size_t i = 0; i < free.size(); ++i) {
      for (std::size_t j = 0; j <= i; ++j) factor[triangle(i) + j] = end.local.information[triangle(free[i]) + free[j]];
      factor[triangle(i) + i] += damping * factor[triangle(i) + i] + min_information;
      step[i] = end.local.gradient[free[i]];
    }
    std::vector<double> x = end.x;
    if (!factorize(free.size(), factor)) return x;  // no decrease: the damping rises
    for (std::size_t i = 0; i < free.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) step[i] -= factor[triangle(i) + k] * step[k];
      step[i] /= factor[triangle(i) + i];
    }
    for (std::size_t i = free.size(); i-- > 0;) {
      step[i] /= factor[triangle(i) + i];
      for (std::size_t k = 0; k < i; ++k) step[k] -= factor[triangle(i) + k] * step[i];
      const double moved = x[free[i]] - step[i];
      x[free[i]] = free[i] < uniform_ ? std::clamp(moved, 0.0, 1.0) : moved;
    }
    return x;
  }

  std::size_t uniform_;
  const Evaluate& evaluate_;
};

}  // namespace

Optimum minimise(std::size_t size, std::size_t uniform, const Evaluate& evaluate, const OptimumSettings& settings) {
  if (settings.starts < 1 || settings.max_steps < 1)
    throw Error(Code::setting_out_of_range, "optimum",
                format("has %d starts of %d steps", settings.starts, settings.max_steps), "give 1 or more of each");
  const Descent descent(uniform, evaluate);
  std::vector<End> ends(static_cast<std::size_t>(settings.starts));
  parallel_for(settings.starts, [&](int i) {
    const auto start = static_cast<std::size_t>(i);
    const Random random(settings.seed, posterior::streams::particles, of_starts + start);
    for (int attempt = 0; attempt < max_attempts; ++attempt) {
      std::vector<double> x(size);
      const std::uint64_t first = static_cast<std::uint64_t>(attempt) * size;
      for (std::size_t k = 0; k < size; ++k) x[k] = k < uniform ? random.uniform(first + k) : random.normal(first + k);
      End end = descent.end_at(std::move(x));
      if (!std::isfinite(end.local.misfit)) continue;
      ends[start] = descent(std::move(end), settings.max_steps);
      return;
    }
    throw Error(Code::setting_out_of_range, "optimum", "the misfit is infinite at all draws from the prior",
                "widen the prior");
  });
  const End& best = *std::ranges::min_element(ends, {}, [](const End& end) { return end.local.misfit; });
  const auto agreeing = std::ranges::count_if(ends, [&](const End& end) {
    return end.local.misfit - best.local.misfit <= alike * std::max(1.0, std::abs(best.local.misfit));
  });
  return {best.x, best.local.misfit, static_cast<int>(agreeing)};
}

}  // namespace decid::frf
