// Checkpoints of trainings: see checkpoint.hpp.
#include "identify/training/checkpoint.hpp"

#include "base/error.hpp"
#include "base/file.hpp"
#include "base/json_object.hpp"
#include "base/text.hpp"
#include "sim/protocol_json.hpp"

namespace decid {
namespace {

std::string progress_json(const std::vector<EpochLog>& log) {
  Json lines = Json::array();
  for (const EpochLog& e : log) lines.push_back({e.epoch, e.training_mse, e.validation_mse, e.learning_rate});
  return lines.dump();
}

}  // namespace

Origin origin_of(const TrainingSettings& settings, const dataset::TrialSource& source, const std::string& program) {
  const Preset& p = settings.preset;
  Origin origin;
  origin.program = program;
  origin.preset = p.name;
  origin.seed = settings.seed;
  origin.epochs = p.epochs;
  origin.batch = p.batch;
  origin.learning_rate = p.learning_rate;
  origin.momentum = p.sgd.momentum;
  origin.weight_decay = p.sgd.weight_decay;
  origin.schedule = p.schedule;
  origin.warmup_epochs = p.warmup_epochs;
  origin.architecture = Model(source.protocol(), p.image, p.architecture, *settings.head).network.architecture();
  origin.trials = source.identity();
  origin.training_trials = source.trials(dataset::Part::training);
  origin.validation_trials = source.trials(dataset::Part::validation);
  origin.patience = settings.patience;
  return origin;
}

std::string checkpoint_bytes(const TrainingState& state) {
  const Checkpoint checkpoint{progress_json(state.log), state.velocities};
  return to_bytes(state.model, &checkpoint);
}

TrainingState load_checkpoint(const std::string& path, const Origin& origin, const dataset::ImageSettings& image,
                              const sim::Protocol& protocol) {
  Checkpoint checkpoint;
  TrainingState state{model_from_bytes(read_file(path), path, &checkpoint), {}};
  state.velocities = std::move(checkpoint.velocities);
  const std::string remedy = "resume with the options the training began with, or train without --resume";
  if (state.model.origin != origin)
    throw Error(path, "was made with other settings: " + difference(state.model.origin, origin), remedy);
  sim::Protocol same_name = protocol;  // a file may have been renamed
  same_name.name = state.model.protocol.name;
  if (sim::to_json(state.model.protocol) != sim::to_json(same_name))
    throw Error(path, "was made for another protocol", remedy);
  if (state.model.image() != image)
    throw Error(path, "was made with another image (" + one_line(dataset::to_json(state.model.image())) + ")", remedy);
  try {
    for (const Json& line : Json::parse(checkpoint.progress))
      state.log.push_back(
          {line.at(0).get<int>(), line.at(1).get<double>(), line.at(2).get<double>(), line.at(3).get<double>()});
  } catch (const Json::exception&) {
    throw Error(path, "has a log that cannot be read", remedy);
  }
  return state;
}

}  // namespace decid
