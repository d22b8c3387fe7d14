// Power spectrum of a recorded sway. Not installed.
#pragma once

#include <vector>

namespace decid::recording {

struct PowerSpectrum {
  double step_hz;             ///< between frequencies, from 0 Hz on
  std::vector<double> power;  ///< squared magnitudes of the Fourier transform; unit of the signal squared
};

/// Returns the spectrum of a signal without its mean, by Hann's window. Throws Error for an empty signal.
PowerSpectrum hann_spectrum(std::vector<double> signal, double rate_hz);

}  // namespace decid::recording
