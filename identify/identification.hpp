// What identifying one recording yields: the parameters, how well they explain the recording, and what the report
// and the JSON show.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "dataset/image/image.hpp"
#include "dataset/recording/trial.hpp"
#include "sim/frf.hpp"
#include "sim/parameters.hpp"
#include "sim/protocol.hpp"

namespace decid {

/// Frequency response of sway to tilt: the recording's, and that of the identified controller, band by band.
struct FrequencyResponses {
  int cycles = 0;  ///< of the stimulus, that were analysed
  std::vector<sim::FrfPoint> recorded;
  std::vector<sim::FrfPoint> model;  ///< of the noise-free trial simulated from `parameters`; empty if it fell over
  std::vector<sim::Complex> linear;  ///< of the closed loop at theta = 0
};

struct Identification {
  std::string file;
  std::optional<Error> error;            ///< why the recording could not be used; if set, nothing below is
  std::string column;                    ///< the sway column that was read
  sim::Protocol protocol;                ///< the model's
  sim::Parameters parameters{};          ///< identified, SI units
  std::optional<sim::Parameters> truth;  ///< when known (a simulated recording)

  std::vector<float> sway_rad;          ///< the recording at the protocol's rate
  std::vector<float> fitted_rad;        ///< simulated from `parameters`, noise-free; shorter if it fell over
  std::vector<float> tilt_rad;          ///< the platform, same instants
  double rms_residual_deg = 0.0;        ///< over fitted_rad, means removed; NaN if the fitted trial fell over
  double variance_accounted_for = 0.0;  ///< 1 - var(residual) / var(sway), can be negative; NaN likewise
  double peak_to_peak_deg = 0.0;
  /// How much of the identified controller's response to the tilt is in the recording (following.hpp): 1 all, 0 none.
  double following = std::numeric_limits<double>::quiet_NaN();
  /// How little it is like what the model was trained on (following.hpp); 96 of 100 simulated trials are below 1. NaN
  /// where the model cannot tell.
  double unfamiliarity = std::numeric_limits<double>::quiet_NaN();
  std::optional<dataset::TiltMatch> tilt;  ///< how the measured tilt, if there is one, lies over the protocol's
  std::string tilt_column;
  std::optional<FrequencyResponses> frf;  ///< empty if the stimulus has none; a warning says why

  dataset::ImageSettings image_settings;
  dataset::ImageShape image_shape{};
  std::vector<float> image;  ///< the network's input before row scaling, channel-major
  std::vector<std::string> warnings;
};

}  // namespace decid
