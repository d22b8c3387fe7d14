// The noise as unknowns: columns, synthesis and gradient are one linear map; its power is that of the spectrum.
#include "posterior/density/noise_basis.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "base/aligned.hpp"
#include "base/math/random.hpp"
#include "posterior/streams.hpp"
#include "tests/near.hpp"

using namespace decid;
using namespace decid::posterior;
using namespace decid::test;

namespace {

constexpr int edges = 400, bin_steps = 50;
constexpr double epsilon = std::numeric_limits<double>::epsilon();

struct Fixture {
  NoiseBasis basis{sim::default_protocol(), bin_steps, edges, edges, 5.0};
  AlignedVector<double> work = AlignedVector<double>(basis.work_size());
  AlignedVector<double> coefficients = AlignedVector<double>(static_cast<std::size_t>(basis.size()) * lanes);
  AlignedVector<double> velocity = AlignedVector<double>(static_cast<std::size_t>(edges) * lanes);
};

}  // namespace

TEST_CASE_FIXTURE(Fixture, "NoiseBasis: synthesis is the sum of the columns, for every instruction set") {
  Random(2, posterior::streams::chains, 0).fill_normal(coefficients);
  AlignedVector<double> expected(velocity.size(), 0.0), first;
  std::vector<double> column(edges);
  double scale = 0.0;
  for (int i = 0; i < basis.size(); ++i) {
    basis.column(i, column);
    for (std::size_t edge = 0; edge < edges; ++edge) {
      scale = std::max(scale, std::abs(column[edge]));
      for (std::size_t l = 0; l < lanes; ++l)
        expected[edge * lanes + l] += coefficients[static_cast<std::size_t>(i) * lanes + l] * column[edge];
    }
  }
  for (const Isa isa : available_isas()) {
    basis.synthesize(coefficients.data(), velocity.data(), work.data(), isa);
    double worst = 0.0;
    for (std::size_t i = 0; i < velocity.size(); ++i) worst = std::max(worst, std::abs(velocity[i] - expected[i]));
    CHECK(within(worst, 0.0, epsilon * basis.size() * 5.0 * scale));
    if (first.empty()) first = velocity;
    CHECK(first == velocity);
  }
}

TEST_CASE_FIXTURE(Fixture, "NoiseBasis: the gradient is the synthesis transposed") {
  AlignedVector<double> by_velocity(velocity.size()), by_coefficient(coefficients.size());
  Random(2, posterior::streams::chains, 1).fill_normal(by_velocity);
  basis.gradient(by_velocity.data(), by_coefficient.data(), work.data(), chosen_isa());
  std::vector<double> column(edges);
  double worst = 0.0, scale = 0.0;
  for (int i = 0; i < basis.size(); ++i) {
    basis.column(i, column);
    for (std::size_t l = 0; l < lanes; ++l) {
      double sum = 0.0;
      for (std::size_t edge = 0; edge < edges; ++edge) sum += by_velocity[edge * lanes + l] * column[edge];
      worst = std::max(worst, std::abs(by_coefficient[static_cast<std::size_t>(i) * lanes + l] - sum));
    }
    for (const double value : column) scale = std::max(scale, std::abs(value));
  }
  CHECK(within(worst, 0.0, epsilon * edges * 5.0 * scale));
}

TEST_CASE("NoiseBasis: the power of the velocity is the spectrum's") {
  // f from 1/121 to 1 Hz: the integral of (0.2 deg 2 pi f)^2 / f.
  const NoiseBasis basis(sim::default_protocol(), bin_steps, 2430, 2430, 5.0);
  CHECK(basis.period_s() >= 1.2 * 121.0);
  CHECK(basis.period_s() < 1.3 * 121.0);
  std::vector<double> column(2430);
  double power = 0.0;
  for (int i = 0; i < basis.size(); ++i) {
    basis.column(i, column);
    power += column[100] * column[100];
  }
  const double scale = 0.2 * sim::rad_per_deg * 2.0 * sim::pi, low = 1.0 / 121.0;
  double integral = 0.0;
  constexpr int parts = 10'000;
  for (int i = 0; i < parts; ++i) {
    const double f = low + (1.0 - low) * (i + 0.5) / parts;
    integral += scale * scale * f * (1.0 - low) / parts;
  }
  CHECK(near(power, integral, 2e-3));  // the mean of a band's power stands for its middle's
}

TEST_CASE("NoiseBasis: the period is that of the trial, or as long as all edges") {
  const sim::Protocol protocol = sim::default_protocol();
  CHECK(NoiseBasis(protocol, bin_steps, edges + 20, edges, 5.0).period_s() ==
        NoiseBasis(protocol, bin_steps, edges, edges, 5.0).period_s());
  const NoiseBasis basis(protocol, bin_steps, 3 * edges, edges, 5.0);
  CHECK(basis.period_s() > 3 * edges * 0.05);
  CHECK(basis.period_s() < 1.1 * 3 * edges * 0.05);
  CHECK(basis.edges() == 3 * edges);
}

TEST_CASE("NoiseBasis: a silent protocol has no unknowns") {
  sim::Protocol protocol = sim::default_protocol();
  protocol.noise.vestibular.scale_deg = 0.0;
  CHECK(NoiseBasis(protocol, bin_steps, edges, edges, 5.0).size() == 0);
}
