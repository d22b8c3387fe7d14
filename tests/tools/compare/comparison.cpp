// The comparison's figures from answers, and a method's answer for a trial.
#include "tools/compare/comparison.hpp"

#include <cmath>

#include "tests/helpers.hpp"
#include "tests/near.hpp"

using namespace decid;
using tools::Comparison, tools::Method, tools::MethodAnswer;

namespace {

dataset::DatasetRequest request_of(const Model& model, int trials) {
  tools::ComparisonSettings settings;
  settings.simulations = iterative::min_simulations(2) - 1;
  CHECK_THROWS_AS(Comparison(model, dataset::generate(request_of(model, 1)), settings), Error);
}
