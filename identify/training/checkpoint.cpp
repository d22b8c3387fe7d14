// Checkpoints of trainings: see checkpoint.hpp.
#include "identify/training/checkpoint.hpp"

#include <utility>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/setting.hpp"
#include "base/text.hpp"
#include "sim/protocol/protocol_json.hpp"

namespace decid {
namespace {

/// Returns true if the origins differ at most in the number of epochs and their extensions.
bool same_but_epochs(Origin there, const Origin& here) {
  there.epochs = here.epochs;
  there.extensions = here.extensions;
  return there == here;
}

/// Describes the difference between model and request; empty: the model fits the request, or more epochs make it fit.
std::string what_differs(const Model& model, const TrainingRequest& request) {
  Origin here = request.origin;
  here.extensions = model.origin.extensions;
  const bool more = request.more_epochs && here.epochs > model.origin.epochs;
  if (model.origin != here && !(more && same_but_epochs(model.origin, here)))
    return "of other settings: " + difference(model.origin, here);
  sim::Protocol same_name = request.protocol;  // a file may have been renamed
  same_name.name = model.protocol.name;
  if (sim::to_json(model.protocol) != sim::to_json(same_name)) return "for another protocol";
  if (model.image() != request.image) return "with another image (" + one_line(dataset::to_json(model.image())) + ")";
  return {};
}

/// "add resume to continue ..., " where that would help.
std::string resume_hint(const Model& model, const TrainingRequest& request) {
  const bool more = !request.more_epochs && request.origin.epochs > model.origin.epochs;
  return more && same_but_epochs(model.origin, request.origin)
             ? "add " + setting("resume") + " to continue for more epochs, "
             : "";
}

void extend(TrainingState& state, const TrainingRequest& request) {
  Origin& origin = state.model.origin;
  if (origin.epochs == request.origin.epochs) return;
  origin.extensions.push_back({static_cast<int>(state.log.size()), origin.epochs});
  origin.epochs = request.origin.epochs;
}

}  // namespace

Origin make_origin(const TrainingSettings& settings, const dataset::TrialSource& source, const std::string& program,
                   std::optional<Origin::Start> from) {
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
  origin.average = settings.average;
  origin.from = std::move(from);
  return origin;
}

std::string checkpoint_bytes(const TrainingState& state) {
  const nn::OptimiserState begun =
      state.optimiser.memory.empty() ? nn::begin(*nn::sgd(), state.model.network) : state.optimiser;
  const Checkpoint checkpoint{to_json(state.log, state.part), begun.memory.front(), state.average};
  return to_bytes(state.model, &checkpoint);
}

TrainingState state_from_bytes(const std::string& bytes, const std::string& name) {
  Checkpoint checkpoint;
  TrainingState state{model_from_bytes(bytes, name, &checkpoint), {}};
  state.optimiser.memory = {std::move(checkpoint.momentum_buffers)};
  state.average = std::move(checkpoint.average);
  state.log = log_from_json(checkpoint.progress, name, &state.part);
  return state;
}

TrainingState load_checkpoint(const std::string& path, const TrainingRequest& request) {
  TrainingState state = state_from_bytes(read_file(path, max_own_file_bytes), path);
  if (const std::string differs = what_differs(state.model, request); !differs.empty())
    throw Error(Code::file_differs, path, "is of an unfinished training " + differs,
                "give the options it was begun with, " + resume_hint(state.model, request) + "choose another " +
                    setting("output") + ", or delete it to begin again");
  if (state.part.trials > 0 && state.model.origin.epochs != request.origin.epochs)
    throw Error(Code::file_differs, path,
                "is of a training that was stopped in the middle of an epoch, with another schedule",
                "finish it with its " + setting("epochs") + " first, then continue with " + setting("resume"));
  extend(state, request);
  return state;
}

FinishedTraining load_finished(const std::string& path, const TrainingRequest& request) {
  const std::string remedy = "choose another " + setting("output") + ", or delete it to train again";
  const auto model_there = [&] {
    try {
      return load_model(path);
    } catch (const Error& error) {
      throw Error(Code::file_exists, path,
                  "is there already and would be overwritten, and is not a model (" + error.problem() + ")", remedy);
    }
  };
  FinishedTraining finished{{model_there(), {}}, true};
  TrainingState& state = finished.state;
  if (const std::string differs = what_differs(state.model, request); !differs.empty())
    throw Error(Code::file_exists, path, "would be overwritten: it is a finished model " + differs,
                resume_hint(state.model, request) + remedy);
  state.log = std::exchange(state.model.log, {});
  finished.done = state.model.origin.epochs == request.origin.epochs;
  if (finished.done) return finished;
  if (state.log.empty())
    throw Error(Code::file_unsupported, path, "does not say how its training went, so no training can continue from it",
                remedy);
  if (state.model.origin.patience > 0) state.log.resize(static_cast<std::size_t>(best_epoch(state.log)));
  extend(state, request);
  return finished;
}

}  // namespace decid
