// The Gibbs sampler of cohort.hpp: one chain. A sweep draws
//   1. for each recording the component of its evidence, with the recording's own deviation integrated out;
//   2. given the components, which are Gaussian, all means, slopes, participants, visits and trials together, exactly;
//   3. the levels' standard deviations, given the deviations, and again given deviations over standard deviations
//      (Y. Yu, X.-L. Meng, J. Comput. Graph. Stat. 20 (2011) 531-570: one of both moves far whatever the recordings
//      tell), each by a slice (R. Neal, Ann. Stat. 31 (2003) 705-767).
#pragma once

#include <functional>

#include "base/math/random.hpp"
#include "identify/cohort/detail/design.hpp"
#include "identify/cohort/detail/gaussian.hpp"

namespace decid::cohort {

/// One draw of everything, in coordinates x.
struct Draw {
  std::vector<double> cell_mean;       ///< cell by cell, each all parameters
  std::vector<double> slopes;          ///< covariate by covariate, per standard deviation
  std::vector<double> participant_sd;  ///< group by group
  std::vector<double> visit_sd;        ///< per parameter; empty without this level
  std::vector<double> trial_sd;        ///< per parameter; empty without this level
  std::vector<double> visits;          ///< visit by visit: b + u + v
};

class Sampler {
 public:
  /// The design and the recordings must outlive it.
  Sampler(const Design& design, std::span<const Recording> recordings, std::uint64_t seed, std::size_t chain);

  void sweep();
  Draw draw() const;

 private:
  /// One of the levels: its deviations and how large they are.
  struct Level {
    std::vector<double> log_sd;              ///< per parameter
    std::vector<double> log_factor;          ///< group by group, of participants; 0 elsewhere
    std::vector<double> effects;             ///< entity by entity
    std::vector<std::size_t> entity, group;  ///< of each recording; of each entity
    bool active = false;
  };
  enum LevelIndex : std::size_t { participants, visits, trials };

  std::span<double> of(std::vector<double>& values, std::size_t i) const {
    return std::span(values).subspan(i * size_, size_);
  }
  double sd(const Level& level, std::size_t group, std::size_t parameter) const;
  void set_sd(const Level& level, std::size_t group);
  void set_location_above(std::size_t recording);
  void set_precision(const Measurement& measurement, std::size_t component, Evidence& evidence) const;
  double weigh(const Measurement& measurement, std::size_t component, const Deviation& node);
  void draw_component(std::size_t recording);
  void draw_locations();
  void absorb_participant(std::size_t participant);
  void draw_coefficients();
  void draw_effects();
  void set_residuals();
  void scale_centred(Level& level, std::size_t parameter);
  void scale_noncentred(Level& level, std::size_t parameter);
  void rescale(Level& level, std::size_t parameter, double factor, std::size_t group);
  double log_prior(std::size_t parameter) const;
  double slice(double at, double low, double high, const std::function<double(double)>& log_density);
  double uniform() { return random_.uniform(used_++); }
  std::span<const double> normals();

  const Design& design_;
  std::span<const Recording> recordings_;
  std::uint64_t seed_, chain_, sweep_ = 0, used_ = 0;
  Random random_;
  std::size_t size_, coefficients_;
  std::array<Level, 3> levels_;
  std::vector<double> noise_variance_;  ///< of the recordings' evidence, per parameter
  std::vector<double> base_;            ///< of visits: b + g z
  std::vector<double> coefficient_, matrix_, right_;
  std::vector<double> x_, residual_;  ///< of recordings: their parameters, and the gradient of their evidence there
  std::vector<Evidence> of_recording_, of_visit_, about_base_;
  std::vector<Deviation> recording_node_, visit_node_, participant_node_;
  std::vector<double> sd_, location_, work_, normal_, log_weights_;
  Evidence scratch_;
};

}  // namespace decid::cohort
