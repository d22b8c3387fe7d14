// CMA-ES: see cmaes.hpp. Names and equations are those of the tutorial's appendix A.
#include "tools/compare/cmaes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "base/error.hpp"
#include "base/math/random.hpp"

namespace decid::iterative {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;
constexpr const char* where = "CMA-ES";

}  // namespace

double mirrored(double x) noexcept {
  const double turn = x - 2 * std::floor(x / 2);  // [0, 2)
  return turn > 1 ? 2 - turn : turn;
}

struct CmaEs::State {
  Random random;
  int n, lambda, mu;
  VectorXd weights;
  double mu_eff, c_sigma, d_sigma, c_c, c_1, c_mu, chi_n;

  VectorXd mean, path_sigma, path_c;
  double sigma;
  MatrixXd covariance, axes;  // covariance = axes diag(lengths^2) axes^T
  VectorXd lengths;
  MatrixXd steps;  // of the current generation, one column per point: (x - mean) / sigma
  std::vector<double> points;
  bool asked = false;
  int generation = 0;

  State(std::span<const double> start, double sigma_, int population, std::uint64_t seed, std::uint64_t item)
      : random(seed, search_stream, item), n(static_cast<int>(start.size())), sigma(sigma_) {
    const double dimensions = n;
    lambda = population == 0 ? 4 + static_cast<int>(3 * std::log(dimensions)) : population;
    mu = lambda / 2;
    weights = VectorXd(mu);
    for (int i = 0; i < mu; ++i) weights[i] = std::log(0.5 * (lambda + 1)) - std::log(i + 1.0);
    weights /= weights.sum();
    mu_eff = 1 / weights.squaredNorm();
    c_sigma = (mu_eff + 2) / (dimensions + mu_eff + 5);
    d_sigma = 1 + 2 * std::max(0.0, std::sqrt((mu_eff - 1) / (dimensions + 1)) - 1) + c_sigma;
    c_c = (4 + mu_eff / dimensions) / (dimensions + 4 + 2 * mu_eff / dimensions);
    c_1 = 2 / ((dimensions + 1.3) * (dimensions + 1.3) + mu_eff);
    c_mu = std::min(1 - c_1, 2 * (mu_eff - 2 + 1 / mu_eff) / ((dimensions + 2) * (dimensions + 2) + mu_eff));
    // The mean length of a standard normal vector.
    chi_n = std::sqrt(dimensions) * (1 - 1 / (4 * dimensions) + 1 / (21 * dimensions * dimensions));
    mean = Eigen::Map<const VectorXd>(start.data(), n);
    path_sigma = path_c = VectorXd::Zero(n);
    covariance = axes = MatrixXd::Identity(n, n);
    lengths = VectorXd::Ones(n);
    steps = MatrixXd(n, lambda);
    points.resize(static_cast<std::size_t>(n) * static_cast<std::size_t>(lambda));
  }

  void sample() {
    const auto first = static_cast<std::uint64_t>(generation) * points.size();
    std::vector<double> normals(points.size());
    random.fill_normal(normals, first);
    steps = axes * lengths.asDiagonal() * Eigen::Map<const MatrixXd>(normals.data(), n, lambda);
    for (int k = 0; k < lambda; ++k)
      for (int i = 0; i < n; ++i)
        points[static_cast<std::size_t>(k) * static_cast<std::size_t>(n) + static_cast<std::size_t>(i)] =
            mirrored(mean[i] + sigma * steps(i, k));
  }

  void update(std::span<const double> values) {
    std::vector<int> order(static_cast<std::size_t>(lambda));
    std::iota(order.begin(), order.end(), 0);
    const auto value = [&](int k) {
      const double v = values[static_cast<std::size_t>(k)];
      return std::isnan(v) ? std::numeric_limits<double>::infinity() : v;
    };
    std::ranges::stable_sort(order, [&](int a, int b) { return value(a) < value(b); });
    MatrixXd chosen(n, mu);
    for (int i = 0; i < mu; ++i) chosen.col(i) = steps.col(order[static_cast<std::size_t>(i)]);
    const VectorXd step = chosen * weights;
    mean += sigma * step;
    const VectorXd whitened = axes * lengths.cwiseInverse().asDiagonal() * axes.transpose() * step;
    path_sigma = (1 - c_sigma) * path_sigma + std::sqrt(c_sigma * (2 - c_sigma) * mu_eff) * whitened;
    ++generation;
    const double settled = 1 - std::pow(1 - c_sigma, 2.0 * generation);
    const bool steady = path_sigma.norm() / std::sqrt(settled) < (1.4 + 2 / (n + 1.0)) * chi_n;
    path_c *= 1 - c_c;
    if (steady) path_c += std::sqrt(c_c * (2 - c_c) * mu_eff) * step;
    const double lost = steady ? 0 : c_1 * c_c * (2 - c_c);
    covariance = (1 - c_1 - c_mu + lost) * covariance + c_1 * path_c * path_c.transpose() +
                 c_mu * chosen * weights.asDiagonal() * chosen.transpose();
    sigma *= std::exp(std::min(1.0, c_sigma / d_sigma * (path_sigma.norm() / chi_n - 1)));
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(covariance);
    axes = solver.eigenvectors();
    // Rounding may leave a length that is not positive: bounded to 1e7 times the longest.
    const double longest = solver.eigenvalues().maxCoeff();
    lengths = solver.eigenvalues().cwiseMax(1e-14 * longest).cwiseSqrt();
  }
};

CmaEs::CmaEs(std::span<const double> start, double sigma, int population, std::uint64_t seed, std::uint64_t item) {
  if (start.empty()) throw Error(Code::setting_out_of_range, where, "no dimension", "give a start");
  for (const double x : start)
    if (!(x >= 0 && x <= 1))
      throw Error(Code::setting_out_of_range, where, "starts at " + std::to_string(x), "start between 0 and 1");
  if (!(sigma > 0 && std::isfinite(sigma)))
    throw Error(Code::setting_out_of_range, where, "first step of " + std::to_string(sigma), "give one above 0");
  if (population != 0 && population < 4)
    throw Error(Code::setting_out_of_range, where, "population of " + std::to_string(population), "give at least 4");
  state_ = std::make_unique<State>(start, sigma, population, seed, item);
}
CmaEs::~CmaEs() = default;
CmaEs::CmaEs(CmaEs&&) noexcept = default;

const std::vector<double>& CmaEs::ask() {
  if (!state_->asked) state_->sample();
  state_->asked = true;
  return state_->points;
}

void CmaEs::tell(std::span<const double> values) {
  if (!state_->asked || values.size() != static_cast<std::size_t>(state_->lambda))
    throw Error(Code::size_mismatch, where, "tell() got " + std::to_string(values.size()) + " values",
                "pass one value for each point of ask()");
  state_->update(values);
  state_->asked = false;
}

std::vector<double> CmaEs::mean() const {
  std::vector<double> mean(state_->mean.begin(), state_->mean.end());
  for (double& x : mean) x = mirrored(x);
  return mean;
}
double CmaEs::longest_axis() const noexcept {
  return state_->sigma * state_->lengths.maxCoeff();
}

}  // namespace decid::iterative
