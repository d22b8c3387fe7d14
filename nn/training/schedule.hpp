// Learning-rate schedules, as functions of the step.
#pragma once

#include <string>

namespace decid::nn {

/// "constant"; "cosine": from the base rate to 0 along half a cosine; "step:EPOCHS:FACTOR": multiplied by FACTOR every
/// EPOCHS epochs. The first `warmup_steps` rise linearly to the base rate instead. Steps of a schedule count from the
/// training's first step, with a warm-up too.
class Schedule {
 public:
  /// Where a cosine begins. After a warm-up of a fraction f of all steps, one from the first step continues at 0.5 +
  /// 0.5 cos(pi f) of the base rate: 0.98 for f = 0.1. The presets of decid train have it, and trained models depend on
  /// it.
  enum class CosineFrom { first_step, warmup_end };

  /// Throws Error for a text of another form, or total_steps < 1.
  Schedule(const std::string& text, double base_rate, long long total_steps, long long steps_per_epoch,
           long long warmup_steps = 0, CosineFrom cosine_from = CosineFrom::first_step);

  /// Returns the rate of step `step`, 0 .. total_steps - 1; beyond either end the rate of the step at that end.
  double rate(long long step) const;

 private:
  enum class Kind { constant, cosine, step } kind_;
  double base_rate_;
  long long total_steps_, steps_per_epoch_, warmup_steps_;
  long long cosine_begin_;  // a step
  long long drop_epochs_ = 1;
  double drop_factor_ = 1.0;
};

}  // namespace decid::nn
