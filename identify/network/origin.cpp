// The origin of a model: see origin.hpp.
#include "identify/network/origin.hpp"

#include "base/error.hpp"
#include "base/files/json_object.hpp"
#include "base/setting.hpp"
#include "identify/network/origin_object.hpp"

namespace decid {
namespace {

using Kind = dataset::TrialIdentity::Kind;

const std::string stream_sentence = "simulated for each epoch from seed ", stored_sentence = "data set ";

Json trials_json(const dataset::TrialIdentity& trials, int version) {
  const bool stream = trials.kind == Kind::stream, stored = trials.kind == Kind::stored;
  if (version == 1)
    return stream ? stream_sentence + std::to_string(trials.seed.value_or(0)) : stored_sentence + trials.sha256;
  Json json{{"kind", stream ? "stream" : stored ? "stored" : "unknown"}};
  if (trials.seed) json["seed"] = *trials.seed;
  if (stored) json["sha256"] = trials.sha256;
  return json;
}

/// The sentence of version 1. It does not have a data set's seed.
dataset::TrialIdentity trials_from_sentence(const std::string& text) {
  if (text.starts_with(stream_sentence)) {
    try {
      return {Kind::stream, std::stoull(text.substr(stream_sentence.size())), {}};
    } catch (const std::exception&) {
      return {};
    }
  }
  if (text.starts_with(stored_sentence)) return {Kind::stored, {}, text.substr(stored_sentence.size())};
  return {};
}

template <class T>
void read(const Json& json, const char* key, T& value) {
  const auto at = json.find(key);
  if (at == json.end()) return;
  try {
    value = at->get<T>();
  } catch (const Json::exception&) {  // another type counts as left out
  }
}

dataset::TrialIdentity trials_from(const Json& json) {
  if (json.is_string()) return trials_from_sentence(json.get<std::string>());
  dataset::TrialIdentity trials;
  if (!json.is_object()) return trials;
  std::string kind;
  read(json, "kind", kind);
  if (kind == "stream") trials.kind = Kind::stream;
  if (kind == "stored") trials.kind = Kind::stored;
  std::uint64_t seed = 0;
  read(json, "seed", seed);
  if (json.contains("seed")) trials.seed = seed;
  read(json, "sha256", trials.sha256);
  return trials;
}

}  // namespace

Json to_json_object(const Origin& origin) {
  Json json = Json::object();
  if (origin.version > 1) json["version"] = origin.version;
  json.update(Json{{"program", origin.program},
                   {"preset", origin.preset},
                   {"seed", origin.seed},
                   {"epochs", origin.epochs},
                   {"batch", origin.batch},
                   {"learning_rate", origin.learning_rate},
                   {"momentum", origin.momentum},
                   {"weight_decay", origin.weight_decay},
                   {"schedule", origin.schedule},
                   {"warmup_epochs", origin.warmup_epochs},
                   {"architecture", origin.architecture},
                   {"trials", trials_json(origin.trials, origin.version)},
                   {"training_trials", origin.training_trials},
                   {"validation_trials", origin.validation_trials}});
  if (origin.patience > 0) json["patience"] = origin.patience;
  if (origin.from) {
    Json trials = Json::array();
    for (const dataset::TrialIdentity& each : origin.from->trials) trials.push_back(trials_json(each, 2));
    json["from"] = Json{{"weights_sha256", origin.from->weights_sha256}, {"trials", trials}};
  }
  for (const Origin::Extension& each : origin.extensions)
    json["extensions"].push_back(Json{{"after", each.after}, {"planned", each.planned}});
  return json;
}

std::string to_json(const Origin& origin) {
  return to_json_object(origin).dump();
}

Origin origin_from_json(const std::string& text, const std::string& where) {
  const Json json = parse_json(text, where);
  if (!json.is_object())
    throw Error(Code::file_damaged, where, "has an origin that is not a JSON object",
                "give a file written by decid train");
  Origin origin;
  origin.version = 1;
  read(json, "version", origin.version);
  read(json, "program", origin.program);
  read(json, "preset", origin.preset);
  read(json, "seed", origin.seed);
  read(json, "epochs", origin.epochs);
  read(json, "batch", origin.batch);
  read(json, "learning_rate", origin.learning_rate);
  read(json, "momentum", origin.momentum);
  read(json, "weight_decay", origin.weight_decay);
  read(json, "schedule", origin.schedule);
  read(json, "warmup_epochs", origin.warmup_epochs);
  read(json, "architecture", origin.architecture);
  read(json, "training_trials", origin.training_trials);
  read(json, "validation_trials", origin.validation_trials);
  read(json, "patience", origin.patience);
  if (const auto trials = json.find("trials"); trials != json.end()) origin.trials = trials_from(*trials);
  if (const auto from = json.find("from"); from != json.end() && from->is_object()) {
    origin.from.emplace();
    read(*from, "weights_sha256", origin.from->weights_sha256);
    for (const Json& each : from->value("trials", Json::array())) origin.from->trials.push_back(trials_from(each));
  }
  if (const auto extensions = json.find("extensions"); extensions != json.end() && extensions->is_array())
    for (const Json& each : *extensions) {
      Origin::Extension extension{0, 0};
      read(each, "after", extension.after);
      read(each, "planned", extension.planned);
      origin.extensions.push_back(extension);
    }
  return origin;
}

Origin::Start start_from(const Origin& origin, const std::string& weights_sha256) {
  Origin::Start start{weights_sha256, {origin.trials}};
  if (origin.from) start.trials.insert(start.trials.end(), origin.from->trials.begin(), origin.from->trials.end());
  return start;
}

std::string difference(const Origin& there, const Origin& here) {
  const Json a = to_json_object(there), b = to_json_object(here);
  std::string text;
  const auto value = [](const Json& object, const std::string& key) {
    return object.contains(key) ? object[key].dump() : "nothing";
  };
  const auto add = [&](const std::string& key) {
    text += (text.empty() ? "" : "; ") + key + " " + value(a, key) + " there, " + value(b, key) + " here";
  };
  for (const auto& [key, unused] : a.items())
    if (value(a, key) != value(b, key)) add(key);
  for (const auto& [key, unused] : b.items())
    if (!a.contains(key)) add(key);
  return text;
}

bool trained_on(const Origin& origin, const dataset::TrialIdentity& data) {
  return origin.trials.kind == Kind::stored && data.kind == Kind::stored && origin.trials.sha256 == data.sha256;
}

void require_not_trained_on(const Origin& origin, const dataset::TrialIdentity& data, Measured part,
                            const std::string& name) {
  if (trained_on(origin, data)) {
    if (part == Measured::all)
      throw Error(Code::data_reused, name,
                  "is the data set that the model was trained on: half of its trials were its training",
                  "choose its validation or training half (" + setting("split") + "), or a data set of another seed");
    return;
  }
  for (const dataset::TrialIdentity& trained : start_from(origin, {}).trials) {
    if (trained.seed && data.seed && *trained.seed == *data.seed)
      throw Error(Code::data_reused, name, "the model was trained with seed " + std::to_string(*data.seed),
                  (data.kind == Kind::stream ? "give another " : "make the data set with another ") + setting("seed"));
    if (trained.kind == Kind::stored && data.kind == Kind::stored && trained.sha256 == data.sha256)
      throw Error(Code::data_reused, name, "is the data set that the model before the fine tuning was trained on",
                  "take a data set of another seed");
  }
}

}  // namespace decid
