// Tests of sim/fft.hpp against the definition of the transform, summed in long double.
// Tolerance: the rounding errors of a sum of p terms add like a random walk, eps sqrt(p) of its norm, and each prime
// factor p of the length adds such sums once.
#include "sim/fft.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/math/random.hpp"

using decid::sim::Complex;
using decid::sim::Fft;
using decid::sim::RealFft;

namespace {

using LongComplex = std::complex<long double>;
using Signal = std::vector<Complex>;

double tolerance(int length) {
  double sum = 1.0;
  for (int p = 2; length > 1; ++p) {
    for (; length % p == 0; length /= p) sum += std::sqrt(p);
  }
  return std::numeric_limits<double>::epsilon() * sum;
}

Signal random_signal(int length, std::uint64_t item) {
  Signal signal;
  const decid::Random random(1, decid::Stream::weights, item);
  for (int n = 0; n < length; ++n) {
    const auto index = 2 * static_cast<std::uint64_t>(n);
    signal.emplace_back(random.normal(index), random.normal(index + 1));
  }
  return signal;
}

std::vector<double> real_parts(const Signal& signal) {
  std::vector<double> real;
  for (const Complex x : signal) real.push_back(x.real());
  return real;
}

// Bin k of the transform, by definition.
LongComplex definition(const Signal& x, int k, const std::vector<LongComplex>& roots) {
  LongComplex sum = 0.0L;
  std::size_t power = 0;
  for (const Complex value : x) {
    sum += LongComplex(value) * roots[power];
    power = (power + static_cast<std::size_t>(k)) % roots.size();
  }
  return sum;
}

std::vector<LongComplex> roots_of_unity(int length) {
  std::vector<LongComplex> roots;
  for (int n = 0; n < length; ++n) {
    const long double angle = -2.0L * 3.14159265358979323846264338327950288L * n / length;
    roots.emplace_back(std::cos(angle), std::sin(angle));
  }
  return roots;
}

Signal forward(const Signal& x) {
  const Fft fft(static_cast<int>(x.size()));
  Signal out(x.size()), work(static_cast<std::size_t>(fft.work_length()));
  fft.forward(x, out, work);
  return out;
}

Signal inverse(const Signal& x) {
  const Fft fft(static_cast<int>(x.size()));
  Signal out(x.size()), work(static_cast<std::size_t>(fft.work_length()));
  fft.inverse(x, out, work);
  return out;
}

Signal real_forward(const std::vector<double>& x) {
  const RealFft fft(static_cast<int>(x.size()));
  Signal out(static_cast<std::size_t>(fft.bins())), work(static_cast<std::size_t>(fft.work_length()));
  fft.forward(x, out, work);
  return out;
}

std::vector<double> real_inverse(const Signal& spectrum, int length) {
  const RealFft fft(length);
  std::vector<double> out(static_cast<std::size_t>(length));
  Signal work(static_cast<std::size_t>(fft.work_length()));
  fft.inverse(spectrum, out, work);
  return out;
}

// In long double: a sum of 121000 squares would bring rounding errors of its own.
double norm(const auto& x) {
  long double sum = 0.0L;
  for (const auto value : x) sum += std::norm(LongComplex(value));
  return static_cast<double>(std::sqrt(sum));
}

// |a - b| / |b| in the 2-norm.
double distance(const auto& a, const auto& b) {
  REQUIRE(a.size() == b.size());
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += std::norm(a[i] - b[i]);
  return std::sqrt(sum) / norm(b);
}

}  // namespace

// Every length up to 200 with all its bins, and lengths of trials with a sample of them.
TEST_CASE("Fft, RealFft: equal the definition") {
#ifdef DECID_EMULATED
  constexpr int all_until = 80, bins_apart = 549;  // the definition takes long double, which is slow there
#else
  constexpr int all_until = 200, bins_apart = 61;
#endif
  std::vector<int> lengths{6370, 12100};
  for (int length = 1; length <= all_until; ++length) lengths.push_back(length);
  for (const int length : {121, 127, 128, 143, 169, 200})
    if (length > all_until) lengths.push_back(length);
  for (const int length : lengths) {
    CAPTURE(length);
    const Signal x = random_signal(length, 1);
    const std::vector<double> real = real_parts(random_signal(length, 2));
    const Signal real_as_complex(real.begin(), real.end());
    const std::vector<LongComplex> roots = roots_of_unity(length);
    const Signal spectrum = forward(x), real_spectrum = real_forward(real);
    Signal some, exact, real_some, real_exact;
    for (int k = 0; k < length; k += length <= 200 || k < 20 ? 1 : bins_apart) {
      some.push_back(spectrum[static_cast<std::size_t>(k)]);
      exact.emplace_back(definition(x, k, roots));
      if (k > length / 2) continue;
      real_some.push_back(real_spectrum[static_cast<std::size_t>(k)]);
      real_exact.emplace_back(definition(real_as_complex, k, roots));
    }
    CHECK(distance(some, exact) < tolerance(length));
    CHECK(distance(real_some, real_exact) < tolerance(length));
    CHECK(real_spectrum[0].imag() == 0.0);
    if (length % 2 == 0) CHECK(real_spectrum.back().imag() == 0.0);
    if (length > 200) continue;
    CHECK(distance(inverse(exact), x) < tolerance(length));
    CHECK(distance(real_inverse(real_exact, length), real) < tolerance(length));
  }
}

TEST_CASE("Fft: round trip, Parseval's theorem") {
  for (const int length : {1, 2, 30, 97, 1001, 4096, 12100, 121000}) {
    CAPTURE(length);
    const Signal x = random_signal(length, 4);
    const Signal spectrum = forward(x);
    CHECK(distance(inverse(spectrum), x) < 2.0 * tolerance(length));
    CHECK(std::abs(norm(spectrum) / std::sqrt(length) / norm(x) - 1.0) < tolerance(length));
    const std::vector<double> real = real_parts(x);
    CHECK(distance(real_inverse(real_forward(real), length), real) < 2.0 * tolerance(length));
  }
}

TEST_CASE("Fft: in place has the same bits") {
  for (const int length : {1, 2, 5, 8, 7, 49, 64, 110, 210, 12100}) {  // odd and even numbers of passes
    const Signal x = random_signal(length, 7);
    const Fft fft(length);
    Signal work(static_cast<std::size_t>(fft.work_length()));
    Signal in_place = x;
    fft.forward(in_place, in_place, work);
    CHECK((in_place == forward(x)));
    in_place = x;
    fft.inverse(in_place, in_place, work);
    CHECK((in_place == inverse(x)));
  }
}

TEST_CASE("RealFft: the inverse takes the imaginary parts at both ends as zero") {
  for (const int length : {1, 7, 2, 8, 110}) {
    Signal spectrum = random_signal(length / 2 + 1, 8);
    Signal clean = spectrum;
    clean.front() = clean.front().real();
    if (length % 2 == 0) clean.back() = clean.back().real();
    CHECK(real_inverse(spectrum, length) == real_inverse(clean, length));
  }
}

TEST_CASE("Fft: errors") {
  for (const int length : {0, -1, (1 << 26) + 1, std::numeric_limits<int>::max()}) {
    CHECK_THROWS_AS(Fft{length}, decid::Error);
  }
  CHECK_THROWS_AS(RealFft{0}, decid::Error);
  CHECK_THROWS_AS(Fft{2 * 10'007}, decid::Error);  // a prime that would make the transform crawl
  const Fft fft(8);
  const RealFft real(8);
  Signal eight(8), seven(7), work(static_cast<std::size_t>(real.work_length()));
  std::vector<double> short_real(7), real_signal(8);
  CHECK_THROWS_AS(fft.forward(seven, eight, work), decid::Error);
  CHECK_THROWS_AS(fft.forward(eight, seven, work), decid::Error);
  CHECK_THROWS_AS(fft.inverse(eight, eight, seven), decid::Error);
  CHECK_THROWS_AS(real.forward(short_real, eight, work), decid::Error);
  CHECK_THROWS_AS(real.inverse(eight, short_real, work), decid::Error);
  CHECK_THROWS_AS(real.inverse(eight, real_signal, seven), decid::Error);
}

TEST_CASE("RealFft: eight signals side by side have the bits that each has alone, with every instruction set") {
  constexpr auto lanes = static_cast<std::size_t>(decid::sim::fft_lanes);
  // All hand-written radices, the fixed odd ones (7, 11), general ones (13, 17), odd lengths, one prime.
  for (const int length : {1, 2, 3, 30, 77, 110, 121, 484, 13 * 34, 997}) {
    CAPTURE(length);
    const RealFft fft(length);
    const auto n = static_cast<std::size_t>(length), bins = static_cast<std::size_t>(fft.bins());
    std::vector<std::vector<double>> signals;
    std::vector<double> in(n * lanes);
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      signals.push_back(real_parts(random_signal(length, lane)));
      for (std::size_t k = 0; k < n; ++k) in[k * lanes + lane] = signals[lane][k];
    }
    for (const decid::Isa isa : decid::available_isas()) {
      CAPTURE(name(isa));
      std::vector<double> spectra(2 * bins * lanes), back(n * lanes);
      std::vector<double> work(2 * static_cast<std::size_t>(fft.work_length()) * lanes);
      fft.forward_lanes(in, spectra, work, isa);
      fft.inverse_lanes(spectra, back, work, isa);
      bool equal = true;
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        Signal spectrum(bins), plain_work(static_cast<std::size_t>(fft.work_length()));
        std::vector<double> plain_back(n);
        fft.forward(signals[lane], spectrum, plain_work);
        for (std::size_t k = 0; k < bins; ++k) {
          equal = equal && spectra[2 * k * lanes + lane] == spectrum[k].real() &&
                  spectra[(2 * k + 1) * lanes + lane] == spectrum[k].imag();
        }
        fft.inverse(spectrum, plain_back, plain_work);
        for (std::size_t k = 0; k < n; ++k) equal = equal && back[k * lanes + lane] == plain_back[k];
      }
      CHECK(equal);
    }
    std::vector<double> nothing;
    CHECK_THROWS_AS(fft.forward_lanes(in, nothing, nothing), decid::Error);
    CHECK_THROWS_AS(fft.inverse_lanes(nothing, in, nothing), decid::Error);
  }
}
