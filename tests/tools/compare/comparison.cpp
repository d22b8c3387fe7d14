// The comparison's figures from answers, and a method's answer for a trial.
#include "tools/compare/comparison.hpp"

#include "tests/helpers.hpp"
#include "tests/near.hpp"

using namespace decid;
using decid::test::near;
using tools::Comparison, tools::Method, tools::MethodAnswer;

namespace {

dataset::Dataset some_trials(const Model& model, int count) {
  dataset::DatasetRequest request;
  request.protocol = model.protocol.ideal();
  request.count = count;
  request.seed = 5;
  return dataset::generate(request);
}

}  // namespace

TEST_CASE("Comparison: figures of answers, and answers that stop") {
  const Model model = built_in_model();
  const dataset::Dataset data = some_trials(model, 2);
  tools::ComparisonSettings settings;
  settings.starts = 1;
  settings.simulations = iterative::min_simulations(1);
  Comparison comparison(model, data, settings);
  REQUIRE(comparison.trials() == 2);
  const MethodFigures network = comparison.network();
  CHECK(network.mse > 0.0);
  CHECK(network.mse < 1.0);
  CHECK_FALSE(network.error_per_standard_error.has_value());

  std::vector<MethodAnswer> answers;
  for (const sim::Parameters& truth : data.parameters) answers.push_back({truth, truth, 10.0, 4.0 * 7.0});
  answers.front().likeliest[0] += 100.0;
  const std::vector<MethodFigures> figures = comparison.figures(Method::fit, answers, 6.0);
  REQUIRE(figures.size() == 2);
  CHECK(figures[0].name == "iterative fit, likeliest");
  CHECK(figures[0].mse_per_parameter[0] > 0.0);
  CHECK(figures[0].mse_per_parameter[1] == 0.0);
  CHECK(figures[1].mse == 0.0);
  CHECK(figures[1].simulations == 10.0);
  CHECK(figures[1].seconds == 3.0);
  REQUIRE(figures[1].error_per_standard_error.has_value());
  CHECK(near(*figures[1].error_per_standard_error, 2.0, 1e-15));
  CHECK(comparison.figures(Method::posterior, answers, 6.0).size() == 1);

  CHECK_FALSE(comparison.answer(Method::posterior, 0, [] { return true; }).has_value());
}

TEST_CASE("Comparison: too few simulations are refused") {
  const Model model = built_in_model();
  tools::ComparisonSettings settings;
  settings.simulations = iterative::min_simulations(2) - 1;
  test::check_error([&] { Comparison(model, some_trials(model, 1), settings); }, Code::setting_out_of_range,
                    "simulations");
}
