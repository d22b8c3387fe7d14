// Models of body and controller on the platform, with the parameters that are identified. sim/models has one file per
// model.
#pragma once

#include <string>
#include <vector>

#include "sim/family.hpp"
#include "sim/parameters.hpp"

namespace decid::sim {

struct BodyModel {
  std::string name;  ///< as on the command line and in protocols: "dec"
  ParameterTable parameters;
  std::string description{};  ///< for users
  /// Without terms the model has only a table, and cannot be simulated.
  Family family{};
  std::string source{};  ///< of equations and ranges, for users
};

/// The parameters of `dec`, in the order used everywhere. Models that have these parameters too begin with them.
enum Index : std::size_t { Kp, Kd, Kp_pass, Kd_pass, Nv, Theta, Delay };

/// Returns `dec`, the single inverted pendulum under the DEC controller of the paper (simulate.hpp).
const BodyModel& single_pendulum();
/// Returns `dec2015`: the same laboratory's controller for people, with free gains and slow feedback.
const BodyModel& dec2015();
/// Returns `ic`: independent channels of proprioception and vestibular sense, with torque feedback.
const BodyModel& independent_channels();

/// Returns all models that have a name in files and on the command line: those above, and registered ones.
std::vector<const BodyModel*> body_models();
/// Returns the model of a name. Throws Error, with the names, if there is none; `where` names the text.
const BodyModel& find_body_model(const std::string& name, const std::string& where);
/// Gives a model of another program its name; the model must outlive all uses. Any thread may call it. Throws Error for
/// a name that another model has.
void register_body_model(const BodyModel& model);

}  // namespace decid::sim
