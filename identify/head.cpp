// Heads: see head.hpp.
#include "identify/head.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include "base/error.hpp"
#include "nn/loss.hpp"

namespace decid {
namespace {

class PointHead final : public Head {
 public:
  std::string name() const override { return "point"; }
  std::size_t outputs(std::size_t parameters) const override { return parameters; }
  double loss(const nn::TensorView<const float>& outputs, std::span<const float> targets,
              const nn::TensorView<float>& diff) const override {
    std::vector<double> squares(static_cast<std::size_t>(outputs.shape().channels));
    nn::mean_squared_error(outputs, targets, squares, diff);
    return std::accumulate(squares.begin(), squares.end(), 0.0);
  }
  void scores(std::span<const float> outputs, std::span<float> scores) const override {
    if (outputs.size() != scores.size())
      throw Error("point head",
                  std::to_string(outputs.size()) + " outputs for " + std::to_string(scores.size()) + " parameters",
                  "give one for each");
    std::ranges::copy(outputs, scores.begin());
  }
};

}  // namespace

const Head& point_head() {
  static const PointHead head;
  return head;
}

const Head& head_named(const std::string& name, const std::string& where) {
  if (name == point_head().name()) return point_head();
  throw Error(where, "has outputs of the kind '" + name + "', which this program does not know",
              "use the decid that wrote it");
}

}  // namespace decid
