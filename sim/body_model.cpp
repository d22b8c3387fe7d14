// Names of the models: see body_model.hpp.
#include "sim/body_model.hpp"

#include <mutex>

#include "base/error.hpp"

namespace decid::sim {
namespace {

std::mutex registry_mutex;

std::vector<const BodyModel*>& registry() {
  static std::vector<const BodyModel*> all{&single_pendulum(), &dec2015(), &independent_channels()};
  return all;
}

}  // namespace

std::vector<const BodyModel*> body_models() {
  const std::lock_guard lock(registry_mutex);
  return registry();
}

const BodyModel& find_body_model(const std::string& name, const std::string& where) {
  std::string names;
  for (const BodyModel* model : body_models()) {
    if (model->name == name) return *model;
    names += (names.empty() ? "" : ", ") + model->name;
  }
  throw Error(Code::setting_unknown, where, "'" + name + "' is not a controller", "give one of " + names);
}

void register_body_model(const BodyModel& model) {
  const std::lock_guard lock(registry_mutex);
  for (const BodyModel* other : registry()) {
    if (other == &model) return;
    if (other->name == model.name)
      throw Error(Code::setting_conflict, "controller " + model.name, "is registered", "give it another name");
  }
  registry().push_back(&model);
}

}  // namespace decid::sim
