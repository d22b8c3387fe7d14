// Tables that a study of a model reads.
#include "identify/evaluation/model_study.hpp"

#include "tests/helpers.hpp"

using namespace decid;
using namespace decid::test;

TEST_CASE("a learning curve has all lines of its file") {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    return read_learning_curve(write_text(folder / "c.csv", text).string());
  };
  // The last line has fewer decimals than the others, and no end.
  const auto curve = read("trials,mse\n1000,0.55\n2000,0.42\n4000,0.31\n8000,0.2");
  REQUIRE(curve.size() == 4);
  CHECK(curve.back().trials == 8000.0);
  CHECK(curve.back().mse == 0.2);
  check_error([&] { read("trials,mse\n1000,0.55\n2000,0.42\n4000,0.31\n8000"); }, Code::file_damaged, "line 5");
}
