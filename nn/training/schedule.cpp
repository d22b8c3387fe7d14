// Learning-rate schedules: see schedule.hpp.
#include "nn/training/schedule.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/math/math.hpp"
#include "base/number.hpp"

namespace decid::nn {

Schedule::Schedule(const std::string& text, double base_rate, long long total_steps, long long steps_per_epoch,
                   long long warmup_steps, CosineFrom cosine_from)
    : base_rate_(base_rate),
      total_steps_(total_steps),
      steps_per_epoch_(steps_per_epoch),
      warmup_steps_(warmup_steps),
      cosine_begin_(cosine_from == CosineFrom::warmup_end ? warmup_steps : 0) {
  const auto fail = [&](const std::string& problem) {
    throw Error(Code::setting_malformed, "learning-rate schedule '" + text + "'", problem,
                "give constant, cosine or step:EPOCHS:FACTOR, such as step:10:0.5");
  };
  if (total_steps < 1 || steps_per_epoch < 1 || warmup_steps < 0) fail("spans no step");
  if (!(base_rate > 0) || !(base_rate < 1e6)) fail("has a base rate that is not a positive number");
  if (text == "constant") {
    kind_ = Kind::constant;
  } else if (text == "cosine") {
    kind_ = Kind::cosine;
  } else if (text.starts_with("step:")) {
    kind_ = Kind::step;
    const std::size_t colon = text.find(':', 5);
    drop_epochs_ =
        colon == std::string::npos ? 0 : number_from<int>(std::string_view(text).substr(5, colon - 5)).value_or(0);
    if (colon == std::string::npos) fail("has no factor behind its epochs");
    if (drop_epochs_ < 1) fail("has no whole number of epochs of at least 1");
    drop_factor_ = number_from<double>(std::string_view(text).substr(colon + 1)).value_or(0.0);
    if (!(drop_factor_ > 0 && drop_factor_ <= 1)) fail("has no factor between 0 and 1");
  } else {
    fail("is not known");
  }
}

double Schedule::rate(long long step) const {
  step = std::clamp(step, 0LL, total_steps_ - 1);
  if (step < warmup_steps_) return base_rate_ * static_cast<double>(step + 1) / static_cast<double>(warmup_steps_);
  switch (kind_) {
    case Kind::cosine:
      return base_rate_ * (0.5 + 0.5 * sincos_of_turn(step - cosine_begin_, 2 * (total_steps_ - cosine_begin_)).cos);
    case Kind::step: {
      double rate = base_rate_;
      for (long long drops = step / steps_per_epoch_ / drop_epochs_; drops > 0; --drops) rate *= drop_factor_;
      return rate;
    }
    case Kind::constant:
      break;
  }
  return base_rate_;
}

}  // namespace decid::nn
