// The command that gives another answer to the same recording, and what that answer adds. Figures: docs/guide/fit.md,
// "Should I use `identify` or `fit`?"
#pragma once

namespace decid::tools {

struct OtherAnswer {
  const char* command;
  const char* adds;
};

inline constexpr OtherAnswer beside_identify{
    "decid fit",
    "a third of the squared error, and intervals that allow for start, drift and noise; a few seconds per recording"};
inline constexpr OtherAnswer beside_fit{"decid identify",
                                        "a second opinion within milliseconds, with three times the squared error"};

}  // namespace decid::tools
