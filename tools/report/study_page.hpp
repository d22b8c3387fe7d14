// The report of `decid study` beside the paper's numbers: as JSON, as a table for people, and as a page.
#pragma once

#include <string>
#include <vector>

#include "base/files/json.hpp"
#include "identify/result.hpp"
#include "tools/report/figures/study_figures.hpp"

namespace decid::tools {

/// Figures printed in the paper. Its section 3.1 does not define its losses; MATLAB's regression layer, which it used,
/// reports half the sum over the 7.
namespace paper {
inline constexpr int trials = 12766, half = 6383, max_epochs = 100;
inline constexpr double validation_loss = 0.2851, training_loss = 0.2250;
inline constexpr double double_pendulum_squared_error = 10.4783, human_peak_to_peak_deg = 2.8533;
/// Its table 1, after enrichment.
inline constexpr sim::Parameters mean{811.2951, 284.5640, 312.2075, 174.3144, 0.4695, 0.0003, 0.1210};
inline constexpr sim::Parameters stddev{338.0956, 122.7999, 102.1054, 68.5447, 0.2928, 0.0124, 0.0672};
}  // namespace paper

/// Keys: model, weights_sha256, version, origin, architecture, network_parameters; data_set (null without), training
/// (epochs, kept_epoch; null without a log), errors (training, validation, fresh: each mse, matlab_loss,
/// mse_per_parameter, trials, or null), double_pendulum, recording (null without), sample, worth (for each level
/// sensor_noise_deg, mse, .., by_amplitude_deg and by_nv: low, high, trials, mse, mse_per_parameter, mean_guess_mse),
/// learning_curve, comparisons (as in comparison_page.hpp), mse_by_paper_sd, seconds, notes, paper: the numbers
/// it prints.
Json study_json(const ModelStudy& study);

/// Returns this program's numbers beside the paper's.
std::string study_text(const ModelStudy& study);

std::string study_html(const ModelStudy& study, const std::vector<Figure>& figures, const Call& call);

}  // namespace decid::tools
