// Protocols to JSON and back. Doubles are printed with enough digits to restore their bits. protocol_json.hpp documents
// the keys.
#include "sim/protocol/protocol_json.hpp"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string>

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "sim/protocol/detail/stimulus_json.hpp"
#include "sim/protocol/protocol_object.hpp"
#include "sim/segments.hpp"

namespace decid::sim {

namespace {

/// Returns a value, or the range that it is drawn from.
Json range_json(double low, double high) {
  if (low == high) return low;
  return {low, high};
}

void read_range(const JsonObject& parent, const char* key, const Json& json, double& low, double& high) {
  if (json.is_number()) {
    low = high = json.get<double>();
  } else if (json.is_array() && json.size() == 2 && json[0].is_number() && json[1].is_number()) {
    low = json[0].get<double>();
    high = json[1].get<double>();
  } else {
    parent.wrong_type(key, "a number or [low, high]");
  }
}

constexpr std::array<const char*, 3> body_keys{"mass_kg", "com_height_m", "inertia_kgm2"};

/// Throws Error if some of the three are missing: completed from the default body they would describe no body.
void refuse_part_of_body(JsonObject& object, const std::string& where) {
  std::string given, missing;
  for (const char* key : body_keys) {
    std::string& list = object.find(key) != nullptr ? given : missing;
    list += (list.empty() ? "'body." : "', 'body.") + std::string(key);
  }
  if (given.empty() || missing.empty()) return;
  throw Error(
      Code::setting_missing, where, "has " + given + "' without " + missing + "'",
      "give mass_kg, com_height_m and inertia_kgm2, or body.participant with the mass_kg and height_m of a person");
}

void read_body(const Json& json, const std::string& where, Body& body) {
  JsonObject object(json, where, "body");
  const char* participant_key = object.find("participant") ? "participant" : "subject";  // until 0.1
  if (const Json* part = object.find(participant_key)) {
    for (const char* key : body_keys) {
      if (!object.find(key)) continue;
      throw Error(Code::setting_conflict, where,
                  std::string("'body.") + key + "' contradicts 'body." + participant_key + "', which defines it",
                  "keep one of them; body.mass_kg is the mass above the ankles");
    }
    Participant participant;
    JsonObject participant_object(*part, where, std::string("body.") + participant_key);
    participant_object.require("mass_kg");
    participant_object.require("height_m");
    participant_object.read("mass_kg", participant.mass_kg);
    participant_object.read("height_m", participant.height_m);
    participant_object.finish();
    try {
      body = make_body(make_segments(participant));
    } catch (const Error& error) {
      throw Error(error.code(), where, "body." + error.where() + ": " + error.problem(), error.remedy());
    }
  }
  refuse_part_of_body(object, where);
  object.read("mass_kg", body.mass_kg);
  object.read("com_height_m", body.com_height_m);
  object.read("inertia_kgm2", body.inertia_kgm2);
  object.finish();
}

/// `repeats_with_trial`: true if the period is the trial's length; unchanged if the object has no period.
void read_vestibular_noise(const Json& json, const std::string& where, VestibularNoise& noise,
                           bool& repeats_with_trial) {
  JsonObject object(json, where, "vestibular_noise");
  object.read("scale_deg", noise.scale_deg);
  object.read("low_hz", noise.low_hz);
  object.read("high_hz", noise.high_hz);
  object.read("exponent", noise.exponent);
  if (const Json* period = object.find("period_s")) {
    repeats_with_trial = period->is_string() && period->get_ref<const std::string&>() == "trial";
    if (period->is_number()) {
      noise.period_s = period->get<double>();
    } else if (!repeats_with_trial) {
      object.wrong_type("period_s", "a number or \"trial\"");
    }
  }
  object.finish();
}

Json conditions_json(const Conditions& conditions) {
  Json json = Json::object();
  for (std::size_t c = 0; c < condition_count; ++c) {
    const Severity& severity = conditions.severity[c];
    if (severity.fraction == 0.0) continue;
    json[info(static_cast<Condition>(c)).key] = {{"share", severity.fraction},
                                                 {"size", range_json(severity.low, severity.high)}};
  }
  return json;
}

void read_conditions(const Json& json, const std::string& where, Conditions& conditions) {
  JsonObject object(json, where, "recording");
  for (std::size_t c = 0; c < condition_count; ++c) {
    const char* key = info(static_cast<Condition>(c)).key;
    const Json* part = object.find(key);
    if (part == nullptr) continue;
    if (!part->is_object())
      object.wrong_type(key, R"({"size": )" + (part->is_number() ? part->dump() : "[low, high]") + "}");
    Severity& severity = conditions.severity[c];
    JsonObject condition(*part, where, std::string("recording.") + key);
    severity.fraction = 1.0;
    condition.read("share", severity.fraction);
    read_range(condition, "size", condition.require("size"), severity.low, severity.high);
    condition.finish();
  }
  object.finish();
}

}  // namespace

Json to_json_object(const Protocol& protocol) {
  const VestibularNoise& noise = protocol.noise.vestibular;
  Json json{{"name", protocol.name}};
  if (protocol.experiment.body_model != &single_pendulum()) json["controller"] = protocol.experiment.body_model->name;
  write_stimulus(protocol.experiment.stimulus, json);
  json["sample_rate_hz"] = protocol.experiment.sample_rate_hz;
  json["body"] = {{"mass_kg", protocol.experiment.body.mass_kg},
                  {"com_height_m", protocol.experiment.body.com_height_m},
                  {"inertia_kgm2", protocol.experiment.body.inertia_kgm2}};
  json["vestibular_noise"] = {{"scale_deg", noise.scale_deg},
                              {"low_hz", noise.low_hz},
                              {"high_hz", noise.high_hz},
                              {"exponent", noise.exponent},
                              {"period_s", protocol.noise_period_s()}};
  json["sensor_noise_deg"] = range_json(protocol.noise.sensor.low_deg, protocol.noise.sensor.high_deg);
  if (protocol.standing_s > 0.0) json["standing_s"] = protocol.standing_s;
  if (protocol.moved_before) json["moved_before"] = true;
  if (protocol.gravity_dead_band_deg > 0.0) json["gravity_dead_band_deg"] = protocol.gravity_dead_band_deg;
  if (protocol.heights.vary()) json["body_heights"] = range_json(protocol.heights.low, protocol.heights.high);
  if (Json recording = conditions_json(protocol.conditions); !recording.empty())
    json["recording"] = std::move(recording);
  return json;
}

std::string to_json(const Protocol& protocol) {
  return print_json(to_json_object(protocol));
}

namespace {

/// Returns the object to which a key of the outermost object belongs; empty if there is none.
std::string place_of(const std::string& key, const Json& json) {
  const auto is_one_of = [&](std::initializer_list<const char*> keys) {
    return std::ranges::any_of(keys, [&](const char* one) { return key == one; });
  };
  if (is_one_of({"cycles", "lead_in_s", "lead_out_s"})) {
    for (const char* kind : {"measured", "sines", "raised_cosines"})
      if (json.contains(kind)) return "'" + std::string(kind) + "'";
    return "'sequence'";
  }
  if (is_one_of({"feedback", "start", "state_s", "amplitude_deg", "offset_s"})) return "'sequence'";
  if (is_one_of({"file", "column", "tilt_deg"})) return "'measured'";
  if (key == "components") return "'sines'";
  if (key == "moves") return "'raised_cosines'";
  if (key == "cycle_s") return json.contains("raised_cosines") ? "'raised_cosines'" : "'sines'";
  if (is_one_of({"participant", "com_height_m", "inertia_kgm2"})) return "'body'";
  if (is_one_of({"mass_kg", "height_m"})) return "'body.participant'";
  if (is_one_of({"scale_deg", "low_hz", "high_hz", "exponent", "period_s"})) return "'vestibular_noise'";
  for (std::size_t c = 0; c < condition_count; ++c)
    if (key == info(static_cast<Condition>(c)).key) return "'recording'";
  return {};
}

Protocol read_protocol(const Json& json, const ProtocolText& source) {
  const std::string& where = source.where;
  const bool is_written_by_people = static_cast<bool>(source.read_tilt);
  Protocol protocol = default_protocol();
  JsonObject object(json, where);
  protocol.name = source.name;
  protocol.experiment.body_model = source.controller;
  object.read("name", protocol.name);
  if (object.find("controller") != nullptr) {
    std::string controller;
    object.read("controller", controller);
    protocol.experiment.body_model = &find_body_model(controller, where + ", controller");
    protocol.names_controller = true;
  }
  object.read("sample_rate_hz", protocol.experiment.sample_rate_hz);
  read_stimulus(object, source, protocol.experiment.sample_rate_hz, protocol.experiment.stimulus);
  if (const Json* part = object.find("body")) read_body(*part, where, protocol.experiment.body);
  // Data sets and models without a period are older than this setting.
  bool repeats_with_trial = !is_written_by_people;
  if (const Json* part = object.find("vestibular_noise"))
    read_vestibular_noise(*part, where, protocol.noise.vestibular, repeats_with_trial);
  SensorNoise& sensor = protocol.noise.sensor;
  if (const Json* part = object.find("sensor_noise_deg"))
    read_range(object, "sensor_noise_deg", *part, sensor.low_deg, sensor.high_deg);
  object.read("standing_s", protocol.standing_s);
  object.read("moved_before", protocol.moved_before);
  object.read("gravity_dead_band_deg", protocol.gravity_dead_band_deg);
  if (const Json* part = object.find("body_heights"))
    read_range(object, "body_heights", *part, protocol.heights.low, protocol.heights.high);
  if (const Json* part = object.find("recording")) read_conditions(*part, where, protocol.conditions);
  object.finish([&](const std::string& key) { return place_of(key, json); });
  try {
    protocol.experiment.validate(protocol.name);
    if (repeats_with_trial)
      protocol.noise.vestibular.period_s = protocol.samples() / protocol.experiment.sample_rate_hz;
    protocol.validate();
    if (is_written_by_people) protocol.refuse_implausible();
  } catch (const Error& error) {
    // validate() does not have the file's name.
    throw Error(error.code(), where, error.where() + ": " + error.problem(), error.remedy());
  }
  return protocol;
}

}  // namespace

Protocol protocol_from_json(const std::string& text, const std::string& where) {
  return read_protocol(parse_json(text, where), {.where = where});
}

Protocol protocol_from_object(const Json& json, const std::string& where) {
  return read_protocol(json, {.where = where});
}

Protocol protocol_from_text(const std::string& text, const ProtocolText& source) {
  return read_protocol(parse_json(text, source.where), source);
}

}  // namespace decid::sim
