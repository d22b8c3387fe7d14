// The page of a training: see training_page.hpp. training.js draws it.
#include "tools/report/training_page.hpp"

#include "base/files/json_object.hpp"
#include "embedded/training_js.hpp"
#include "tools/report/json/recording_json.hpp"
#include "tools/report/page.hpp"

namespace decid::tools {

std::string training_html(const TrainingFigures& figures) {
  Json log = Json::array();
  for (const EpochLog& e : figures.log)
    log.push_back({{"epoch", e.epoch},
                   {"training", page_number(e.training_mse)},
                   {"validation", page_number(e.validation_mse)},
                   {"rate", page_number(e.learning_rate)}});
  const Origin& origin = figures.origin;
  Json data{{"model", figures.model},
            {"version", figures.version},
            {"protocol", protocol_figures(figures.protocol)},
            {"preset", origin.preset},
            {"epochs", origin.epochs},
            {"batch", origin.batch},
            {"training_trials", origin.training_trials},
            {"validation_trials", origin.validation_trials},
            {"best", best_epoch(figures.log)},
            {"keeps_best", origin.patience > 0},
            {"distribution", figures.distribution},
            {"finished", figures.finished},
            {"call", call_json(figures.call, figures.protocol.name)},
            {"log", std::move(log)}};
  return page_html({.title = "Training report",
                    .lead = "How well a network reads the parameters of simulated trials, epoch by epoch.",
                    .script = embedded::training_js()},
                   data);
}

}  // namespace decid::tools
