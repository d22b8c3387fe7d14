// Power spectrum of a recorded sway: see hann_spectrum.hpp.
#include "recording/quality/detail/hann_spectrum.hpp"

#include <complex>

#include "base/math/math.hpp"
#include "base/math/statistics.hpp"
#include "sim/fft.hpp"

namespace decid::recording {

PowerSpectrum hann_spectrum(std::vector<double> signal, double rate_hz) {
  const sim::RealFft fft(sim::smooth_length(static_cast<int>(signal.size())));
  const double middle = mean(signal);
  for (std::size_t k = 0; k < signal.size(); ++k) {
    const double sine = sincos_of_turn(static_cast<long long>(k), 2 * std::ssize(signal)).sin;
    signal[k] = (signal[k] - middle) * sine * sine;
  }
  signal.resize(static_cast<std::size_t>(fft.length()));
  std::vector<sim::Complex> bins(static_cast<std::size_t>(fft.bins())),
      work(static_cast<std::size_t>(fft.work_length()));
  fft.forward(signal, bins, work);
  PowerSpectrum spectrum{rate_hz / fft.length(), {}};
  spectrum.power.reserve(bins.size());
  for (const sim::Complex& bin : bins) spectrum.power.push_back(std::norm(bin));
  return spectrum;
}

}  // namespace decid::recording
