// Kinds of stimulus as JSON: see stimulus_json.hpp. A new kind needs a key, a writer and a reader.
#include "sim/protocol/detail/stimulus_json.hpp"

#include <utility>

#include "base/error.hpp"
#include "base/setting.hpp"

namespace decid::sim {

namespace {

struct Context {
  const ProtocolText& source;
  double sample_rate_hz;
};

template <class Kind>
void write_rests(const Kind& kind, Json& json) {
  json["cycles"] = kind.cycles;
  json["lead_in_s"] = kind.lead_in_s;
  json["lead_out_s"] = kind.lead_out_s;
}

template <class Kind>
void read_rests(JsonObject& object, Kind& kind) {
  object.read("cycles", kind.cycles);
  object.read("lead_in_s", kind.lead_in_s);
  object.read("lead_out_s", kind.lead_out_s);
}

/// Calls read(object, entry) for every entry of the list at `key`.
template <class Entry, class Read>
void read_list(JsonObject& object, const char* key, const std::string& path, const Context& context,
               std::vector<Entry>& entries, const Read& read) {
  const Json& list = object.require(key);
  if (!list.is_array()) object.wrong_type(key, "a list [{...}, ...]");
  for (std::size_t i = 0; i < list.size(); ++i) {
    JsonObject entry(list[i], context.source.where, path + "[" + std::to_string(i) + "]");
    read(entry, entries.emplace_back());
    entry.finish();
  }
}

void read_required(JsonObject& object, const char* key, double& value) {
  object.require(key);
  object.read(key, value);
}

// ---- ternary sequences ----------------------------------------------------------------------------------------------

const char* key_of(const Sequence&) {
  return "sequence";
}

Json to_json_object(const Sequence& sequence) {
  Json json{{"feedback", sequence.feedback},
            {"start", sequence.start},
            {"state_s", sequence.state_s},
            {"amplitude_deg", sequence.amplitude_deg},
            {"offset_s", sequence.offset_s}};
  write_rests(sequence, json);
  return json;
}

void read_kind(JsonObject& object, const Context&, Sequence& sequence) {
  object.read("feedback", sequence.feedback);
  object.read("start", sequence.start);
  // A custom sequence starts at its beginning: the default's offset does not fit it.
  if (object.find("feedback") || object.find("start")) sequence.offset_s = 0.0;
  object.read("state_s", sequence.state_s);
  object.read("amplitude_deg", sequence.amplitude_deg);
  object.read("offset_s", sequence.offset_s);
  read_rests(object, sequence);
}

// ---- measured tilt --------------------------------------------------------------------------------------------------

const char* key_of(const MeasuredTilt&) {
  return "measured";
}

Json to_json_object(const MeasuredTilt& measured) {
  Json json{{"tilt_deg", measured.tilt_deg}};
  write_rests(measured, json);
  return json;
}

void read_kind(JsonObject& object, const Context& context, MeasuredTilt& measured) {
  const std::string& where = context.source.where;
  read_rests(object, measured);
  std::string unit;
  TiltFileReference tilt;
  object.read("file", tilt.file);
  object.read("column", tilt.column);
  object.read("unit", unit);
  if (object.find("rate_hz")) object.read("rate_hz", tilt.rate_hz.emplace());
  if (object.find("tilt_deg")) {
    for (const char* key : {"file", "column", "unit", "rate_hz"}) {
      if (object.find(key)) {
        throw Error(Code::setting_conflict, where,
                    std::string("'measured.") + key + "' contradicts 'measured.tilt_deg'",
                    "give either the samples or a file");
      }
    }
    object.read("tilt_deg", measured.tilt_deg);
    return;
  }
  if (!object.find("file")) {
    throw Error(Code::setting_missing, where, "'measured' has neither 'file' nor 'tilt_deg'",
                "add \"file\": \"tilt.csv\"");
  }
  if (!context.source.read_tilt) {
    throw Error(Code::not_supported, where, "'measured.file' names a file instead of giving the samples",
                "write the protocol with decid stimulus (" + setting("write_protocol") + "), which inserts them");
  }
  if (object.find("unit")) {
    if (unit != "deg" && unit != "rad") object.wrong_type("unit", "\"deg\" or \"rad\"");
    tilt.says_unit = true;
    tilt.in_degrees = unit == "deg";
  }
  // Validating the protocol reports a sample rate out of its bounds.
  if (!(context.sample_rate_hz >= 1.0 && context.sample_rate_hz <= steps_per_second)) return;
  tilt.is_cycle = measured.cycles > 1;
  try {
    measured.tilt_deg = context.source.read_tilt(tilt, context.sample_rate_hz);
  } catch (const Error& error) {
    throw Error(error.code(), where, "'measured.file': " + error.where() + ": " + error.problem(), error.remedy());
  }
}

// ---- sines ----------------------------------------------------------------------------------------------------------

const char* key_of(const Sines&) {
  return "sines";
}

Json to_json_object(const Sines& sines) {
  Json list = Json::array();
  for (const Sine& sine : sines.components) {
    list.push_back(
        {{"frequency_hz", sine.frequency_hz}, {"amplitude_deg", sine.amplitude_deg}, {"phase_deg", sine.phase_deg}});
  }
  Json json{{"components", std::move(list)}, {"cycle_s", sines.cycle_s}};
  write_rests(sines, json);
  return json;
}

void read_kind(JsonObject& object, const Context& context, Sines& sines) {
  read_list(object, "components", "sines.components", context, sines.components, [](JsonObject& entry, Sine& sine) {
    read_required(entry, "frequency_hz", sine.frequency_hz);
    read_required(entry, "amplitude_deg", sine.amplitude_deg);
    entry.read("phase_deg", sine.phase_deg);
  });
  read_required(object, "cycle_s", sines.cycle_s);
  read_rests(object, sines);
}

// ---- raised cosines -------------------------------------------------------------------------------------------------

const char* key_of(const RaisedCosines&) {
  return "raised_cosines";
}

Json to_json_object(const RaisedCosines& cosines) {
  Json list = Json::array();
  for (const Move& move : cosines.moves) {
    list.push_back({{"shape", move.shape == Move::Shape::step ? "step" : "pulse"},
                    {"start_s", move.start_s},
                    {"duration_s", move.duration_s},
                    {"amplitude_deg", move.amplitude_deg}});
  }
  Json json{{"moves", std::move(list)}, {"cycle_s", cosines.cycle_s}};
  write_rests(cosines, json);
  return json;
}

void read_kind(JsonObject& object, const Context& context, RaisedCosines& cosines) {
  read_list(object, "moves", "raised_cosines.moves", context, cosines.moves, [](JsonObject& entry, Move& move) {
    std::string shape = "pulse";
    entry.read("shape", shape);
    if (shape != "pulse" && shape != "step") entry.wrong_type("shape", "\"pulse\" or \"step\"");
    move.shape = shape == "step" ? Move::Shape::step : Move::Shape::pulse;
    read_required(entry, "start_s", move.start_s);
    read_required(entry, "duration_s", move.duration_s);
    read_required(entry, "amplitude_deg", move.amplitude_deg);
  });
  read_required(object, "cycle_s", cosines.cycle_s);
  read_rests(object, cosines);
}

// ---- any ------------------------------------------------------------------------------------------------------------

/// Tries the key of every kind.
template <class... Kinds>
void read_any(JsonObject& protocol, const Context& context, std::variant<Kinds...>& stimulus) {
  std::string found;
  const auto read_one = [&](auto kind) {
    const char* key = key_of(kind);
    const Json* json = protocol.find(key);
    if (!json) return;
    if (!found.empty()) {
      throw Error(Code::setting_conflict, context.source.where, "has two stimuli, '" + found + "' and '" + key + "'",
                  "keep one of them");
    }
    found = key;
    JsonObject object(*json, context.source.where, key);
    read_kind(object, context, kind);
    object.finish();
    stimulus = std::move(kind);
  };
  (read_one(Kinds{}), ...);
}

}  // namespace

void write_stimulus(const StimulusKind& stimulus, Json& protocol) {
  std::visit([&](const auto& kind) { protocol[key_of(kind)] = to_json_object(kind); }, stimulus);
}

void read_stimulus(JsonObject& protocol, const ProtocolText& source, double sample_rate_hz, StimulusKind& stimulus) {
  read_any(protocol, {source, sample_rate_hz}, stimulus);
}

}  // namespace decid::sim
