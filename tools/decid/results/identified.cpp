// Results of decid identify read back: see identified.hpp.
#include "tools/decid/results/identified.hpp"

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "base/warning.hpp"
#include "sim/body_model.hpp"

namespace decid::tools {

namespace {

/// Returns the controller of a result: its protocol's. Results of earlier versions have no protocol.
const sim::BodyModel& controller_in(const Json& result, const std::string& path) {
  const Json name = result.value(Json::json_pointer("/protocol/controller"), Json(sim::single_pendulum().name));
  return sim::find_body_model(name.is_string() ? name.get<std::string>() : name.dump(), path);
}

/// Returns the body of a result, or of one of its recordings. Nothing if it has none, or only the default body because
/// nobody gave one: such gains are for no body. A model's own body is the body of its protocol. Throws Error if it is
/// not a body.
std::optional<sim::Body> body_in(const Json& result, const std::string& path, const std::string& remedy) {
  const auto found = result.find("body");
  if (found == result.end()) return {};
  sim::Body body;
  bool is_assumed = false;
  try {
    is_assumed = found->value("assumed", false);
    body = {.mass_kg = found->at("mass_kg").get<double>(),
            .com_height_m = found->at("com_height_m").get<double>(),
            .inertia_kgm2 = found->at("inertia_kgm2").get<double>()};
  } catch (const Json::exception&) {
    throw Error(Code::file_damaged, path, "has a body without mass, height or inertia", remedy);
  }
  if (!(body.mass_kg > 0.0 && body.com_height_m > 0.0 && body.inertia_kgm2 > 0.0))
    throw Error(Code::file_damaged, path, "has a body whose mass, height or inertia is not above 0", remedy);
  if (is_assumed && body == sim::Body{}) return {};
  return body;
}

}  // namespace

Identified identified(const std::string& path, int recording, bool force) {
  const std::string remedy = "give a file written by decid identify -o";
  const Json json = parse_json(read_file(path), path);
  if (!json.is_object() || !json.contains("recordings") || !json["recordings"].is_array())
    throw Error(Code::file_unsupported, path, "is not a result of decid identify", remedy);
  const Json& all = json["recordings"];
  if (recording < 1 || static_cast<std::size_t>(recording) > all.size())
    throw Error(Code::setting_out_of_range, path,
                format("has %s, but no recording %d", counted(std::ssize(all), "recording").c_str(), recording),
                "choose one with --recording");
  const Json& chosen = all.at(static_cast<std::size_t>(recording) - 1);
  std::string caution;
  if (const auto trust = chosen.find("trust"); trust != chosen.end() && *trust != name(Trust::usable)) {
    const Json why = chosen.value(Json::json_pointer("/warnings/0/text"), Json("no reason is given"));
    const std::string text = why.is_string() ? why.get<std::string>() : why.dump();
    if (*trust == name(Trust::not_usable) && !force)
      throw Error(Code::value_invalid, path, format("is not usable for recording %d: ", recording) + text,
                  "correct the recording, or use its values with --force");
    caution = text;
  }
  const sim::BodyModel& controller = controller_in(json, path);
  const sim::ParameterTable& table = controller.parameters;
  const Json& owner = chosen.contains("body") ? chosen : json;  // recordings of a study have their own bodies
  Identified result{&controller, sim::Parameters(table.size()), body_in(owner, path, remedy), {}, caution};
  if (all.size() > 1) result.which = format("recording %d of %zu", recording, all.size());
  for (std::size_t i = 0; i < table.size(); ++i) {
    try {
      const Json& found = chosen.at("parameters").at(i);
      if (found.at("name") != table[i].name)
        throw Error(Code::file_unsupported, path, "has its parameters in another order", remedy);
      result.parameters[i] = found.at("value").get<double>();
    } catch (const Json::exception&) {
      throw Error(Code::file_unsupported, path, format("has no %s of recording %d", table[i].name.c_str(), recording),
                  remedy);
    }
  }
  return result;
}

}  // namespace decid::tools
