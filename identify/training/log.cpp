// The log of a training: see log.hpp.
#include "identify/training/log.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"

namespace decid {

std::string log_csv(const std::vector<EpochLog>& log, std::size_t parameters) {
  const double half = 0.5 * static_cast<double>(parameters);
  std::string text = "epoch,training_mse,validation_mse,training_matlab_loss,validation_matlab_loss,learning_rate\n";
  for (const EpochLog& e : log)
    text += format("%d,%.9g,%.9g,%.9g,%.9g,%.9g\n", e.epoch, e.training_mse, e.validation_mse, half * e.training_mse,
                   half * e.validation_mse, e.learning_rate);
  return text;
}

int best_epoch(const std::vector<EpochLog>& log) {
  const auto best = std::ranges::min_element(log, {}, &EpochLog::validation_mse);
  return best == log.end() ? 0 : best->epoch;
}

const EpochLog& kept_epoch(const std::vector<EpochLog>& log, int patience) {
  return log.at(patience > 0 ? static_cast<std::size_t>(best_epoch(log)) - 1 : log.size() - 1);
}

std::string to_json(const std::vector<EpochLog>& log, const EpochPart& part) {
  Json lines = Json::array();
  for (const EpochLog& e : log) lines.push_back({e.epoch, e.training_mse, e.validation_mse, e.learning_rate});
  if (part.trials == 0) return lines.dump();
  return Json{{"epochs", lines}, {"trials", part.trials}, {"loss_sum", part.loss_sum}}.dump();
}

std::vector<EpochLog> log_from_json(const std::string& text, const std::string& where, EpochPart* part) {
  const auto unreadable = [&] {
    return Error(Code::file_damaged, where, "has a log that cannot be read", "give a file written by decid train");
  };
  std::vector<EpochLog> log;
  try {
    const Json whole = parse_json(text, where);
    if (part != nullptr && whole.is_object()) {
      *part = {whole.at("trials").get<int>(), whole.at("loss_sum").get<double>()};
      if (part->trials < 0) throw unreadable();
    }
    for (const Json& line : whole.is_object() ? whole.at("epochs") : whole) {
      log.push_back(
          {line.at(0).get<int>(), line.at(1).get<double>(), line.at(2).get<double>(), line.at(3).get<double>()});
      if (log.back().epoch != static_cast<int>(log.size())) throw unreadable();
    }
  } catch (const Json::exception&) {
    throw unreadable();
  }
  return log;
}

}  // namespace decid
