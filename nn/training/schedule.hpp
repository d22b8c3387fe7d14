// Learning-rate schedules, as functions of the step.
#pragma once

#include <string>

namespace decid::nn {

/// "constant"; "cosine": from the base rate to 0 along half a cosine; "step:EPOCHS:FACTOR": multiplied by FACTOR every
/// EPOCHS epochs. This applies to all steps except the first `warmup_steps`, which rise linearly to the base rate.
class Schedule {
 public:
  /// Throws Error for a text of another form, or total_steps < 1.
  Schedule(const std::string& text, double base_rate, long long total_steps, long long steps_per_epoch,
           long long warmup_steps = 0);

  /// Returns the rate of step `step`, 0 .. total_steps - 1; beyond either end the rate of the step at that end.
  double rate(long long step) const;

 private:
  enum class Kind { constant, cosine, step } kind_;
  double base_rate_;
  long long total_steps_, steps_per_epoch_, warmup_steps_;
  long long drop_epochs_ = 1;
  double drop_factor_ = 1.0;
};

}  // namespace decid::nn
