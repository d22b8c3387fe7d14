// The model inside the program: the weights that the README names, and the error that it quotes for them.
#include <doctest/doctest.h>

#include "tests/tools/run.hpp"
#include "tools/training.hpp"

namespace decid::tools {

TEST_CASE("the built-in model is the one that the README describes") {
  const std::string hash = nn::weights_sha256(built_in_model().network);
  const std::string readme = test::read_text(DECID_SOURCE_DIR "/README.md");
  CAPTURE(hash);
  CHECK(readme.find(hash) != std::string::npos);
  CHECK(std::filesystem::file_size(DECID_SOURCE_DIR "/tools/model/built_in.safetensors") < 2'000'000);
}

/// Mean over 7 z-scored parameters, exact sway.
constexpr double built_in_mse = 0.3827387383228128;

TEST_CASE("the built-in model's error on a fixed set of fresh trials") {
  dataset::DatasetRequest request;
  request.count = 100;
  request.seed = 4242;  // the model was trained on seed 1
  const dataset::Dataset data = dataset::generate(request);
  Model model = built_in_model();
  CHECK(sim::same_experiment(model.protocol, data.protocol));
  const std::vector<float> outputs =
      predict(model, data.trials(), 64, sways_in_memory([&](int i) { return data.trial(i); }));
  const Evaluation result = evaluate(model, outputs, data.parameters);
  CHECK(result.trials == 100);
  // The bits are promised: any other figure means that simulator, image, kernels or weights have changed.
  CHECK(result.mse() == doctest::Approx(built_in_mse).epsilon(1e-12));
  CHECK(result.matlab_loss() == doctest::Approx(3.5 * built_in_mse).epsilon(1e-12));
}

}  // namespace decid::tools
