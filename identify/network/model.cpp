// Model files: see model.hpp.
#include "identify/network/model.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/files/json_object.hpp"
#include "base/text.hpp"
#include "embedded/built_in_model.hpp"
#include "identify/training/checkpoint.hpp"
#include "nn/network_file.hpp"
#include "nn/predictor.hpp"
#include "nn/safetensors.hpp"
#include "sim/protocol/protocol_json.hpp"

namespace decid {
namespace {

constexpr const char *format_name = "decid model 1", *average_prefix = "average.";

Json to_list(const sim::Parameters& parameters) {
  return std::vector<double>(parameters.begin(), parameters.end());
}

/// Throws Json::exception unless `list` is one of numbers, as many as parameters.
sim::Parameters parameters_in(const Json& list, const sim::ParameterTable& table) {
  if (list.size() != table.size()) throw Json::other_error::create(501, "another number of parameters", &list);
  sim::Parameters parameters(table.size());
  for (std::size_t i = 0; i < table.size(); ++i) parameters[i] = list.at(i).get<double>();
  return parameters;
}

nn::Shape network_input(const dataset::ImageMaker& images) {
  const dataset::ImageShape s = images.shape();
  return {s.channels, s.rows, s.columns};
}

/// Returns the protocol if it plays the cycles that the images average.
sim::Protocol checked(sim::Protocol protocol, const dataset::ImageSettings& image) {
  image.validate();
  if (image.fold == 1) return protocol;
  const int columns =
      image.block > 0 ? 1 : std::max(protocol.samples() - image.first_sample, 0) / image.window / image.fold;
  const double cycle_samples = protocol.experiment.cycle_s() * protocol.experiment.sample_rate_hz;
  const double lead_in_samples = protocol.experiment.lead_in_s() * protocol.experiment.sample_rate_hz;
  if (image.fold == protocol.experiment.cycles() && columns * image.window == std::lround(cycle_samples) &&
      image.first_sample == std::lround(lead_in_samples))
    return protocol;
  throw Error(
      Code::setting_conflict, "image settings",
      format(
          "fold %d times %d windows of %d samples from sample %d on, but protocol '%s' plays %d cycles of %g samples "
          "after %g",
          image.fold, columns, image.window, image.first_sample, protocol.name.c_str(), protocol.experiment.cycles(),
          cycle_samples, lead_in_samples),
      "choose a preset made for this protocol, or one that does not fold");
}

constexpr const char* model_remedy = "give a model file written by decid train";

/// The parts of a model file that are read one after the other. All functions throw Error for damaged ones.
struct ModelFile {
  nn::TensorFile content;
  const std::string& where;

  bool has(const std::string& key) const { return content.metadata.contains(key); }

  const std::string& text(const std::string& key) const {
    const auto it = content.metadata.find(key);
    if (it == content.metadata.end())
      throw Error(Code::file_unsupported, where, "is not a decid model: it has no " + key, model_remedy);
    return it->second;
  }

  [[noreturn]] void refuse_damaged(const std::string& what) const {
    throw Error(Code::file_damaged, where, what, model_remedy);
  }

  Model untrained_model() const {
    dataset::ImageSettings image = dataset::image_settings_from_json(text("image"), where);
    sim::Protocol protocol = checked(sim::protocol_from_json(text("protocol"), where), image);
    nn::require_values(content, network_input(dataset::ImageMaker(image, protocol.experiment)), text("architecture"),
                       where);
    Model model(std::move(protocol), std::move(image), text("architecture"),
                has("head") ? head_named(text("head"), where) : point_head());
    model.origin = origin_from_json(text("origin"), where);
    if (has("log")) model.log = log_from_json(text("log"), where);
    return model;
  }

  void read_scalings(Model& model) const {
    try {
      const Json targets = parse_json(text("targets"), where);
      model.targets.mean = parameters_in(targets.at("mean"), model.parameters());
      model.targets.stddev = parameters_in(targets.at("deviation"), model.parameters());
    } catch (const Json::exception&) {
      refuse_damaged("has a target scaling that cannot be read");
    }
    for (const double stddev : model.targets.stddev)
      if (!(stddev > 0)) refuse_damaged("has a target scaling that is not positive");
    if (!model.image().standardize_rows) return;
    const auto rows = static_cast<std::size_t>(model.images().shape().channels * model.images().shape().rows);
    model.rows.mean = content.find("image.row_mean", rows, where).values;
    model.rows.stddev = content.find("image.row_deviation", rows, where).values;
    for (std::size_t i = 0; i < rows; ++i)
      if (!std::isfinite(model.rows.mean[i]) || !(model.rows.stddev[i] > 0) || !std::isnormal(model.rows.stddev[i]))
        refuse_damaged("has an image scaling that is not positive, finite and normal");
  }

  void read_ood_detector(Model& model) {
    const auto n = static_cast<std::size_t>(feature_count(model.network));
    if (n == 0) refuse_damaged("has a familiarity of features that its network does not have");
    model.ood_detector.mean = std::move(content.find("familiarity.mean", n, where).values);
    model.ood_detector.whitening = std::move(content.find("familiarity.whitening", n * (n + 1) / 2, where).values);
    try {
      model.ood_detector.usual = parse_json(text("familiarity"), where).at("usual").get<double>();
    } catch (const Json::exception&) {
      refuse_damaged("has a familiarity that cannot be read");
    }
    if (!(model.ood_detector.usual > 0)) refuse_damaged("has a familiarity that is not positive");
  }

  void read_recalibration(Model& model) const {
    if (!model.gives_distribution()) refuse_damaged("has a recalibration of distributions that its head does not give");
    model.recalibration = recalibration_from_json(text("recalibration"), model.parameters().size(), where);
  }
};

}  // namespace

Model::Model(sim::Protocol protocol_, dataset::ImageSettings image_, const std::string& architecture, const Head& head_)
    : protocol(checked(std::move(protocol_), image_)),
      targets{sim::Parameters(protocol.parameters().size()), sim::Parameters(protocol.parameters().size())},
      network(network_input(dataset::ImageMaker(image_, protocol.experiment)), architecture),
      head(&head_),
      ranges_(protocol.ranges()),
      images_(std::move(image_), protocol.experiment) {
  const auto outputs = static_cast<int>(head->outputs(parameters().size()));
  if (network.output_shape() != nn::Shape{outputs, 1, 1})
    throw Error(Code::setting_conflict, "network architecture",
                format("does not end with the %d outputs of the head '%s'", outputs, head->name().c_str()),
                format("end it with fc %d", outputs));
}

void Model::require_outputs(std::span<const float> outputs) const {
  const std::size_t needed = head->outputs(parameters().size());
  if (outputs.size() != needed)
    throw Error(Code::size_mismatch, "model", format("%zu outputs of a trial to be decoded", outputs.size()),
                format("give the network's %zu", needed));
}

sim::Parameters Model::decode(std::span<const float> outputs) const {
  require_outputs(outputs);
  std::vector<float> scores(parameters().size());
  head->scores(outputs, scores);
  return targets.unscale(scores);
}

std::optional<ParameterDistribution> Model::distribution(std::span<const float> outputs,
                                                         const sim::ParameterTable& ranges) const {
  require_outputs(outputs);
  std::optional<Mixture> mixture = head->distribution(outputs, parameters().size());
  if (!mixture) return std::nullopt;
  return ParameterDistribution(std::move(*mixture), ranges, recalibration);
}

std::optional<double> Model::validation_mse() const {
  if (log.empty()) return std::nullopt;
  return kept_epoch(log, origin.patience).validation_mse;
}

std::string to_bytes(const Model& model, const Checkpoint* checkpoint) {
  nn::TensorFile file;
  file.metadata = {
      {"format", format_name},
      {"architecture", model.network.architecture()},
      {"protocol", sim::to_json(model.protocol)},
      {"image", dataset::to_json(model.image())},
      {"targets", Json{{"mean", to_list(model.targets.mean)}, {"deviation", to_list(model.targets.stddev)}}.dump()},
      {"origin", to_json(model.origin)},
  };
  if (model.head != &point_head()) file.metadata["head"] = model.head->name();
  if (!model.log.empty()) file.metadata["log"] = to_json(model.log);
  if (checkpoint != nullptr) file.metadata["progress"] = checkpoint->progress;
  if (model.image().standardize_rows) {
    const std::vector<long long> shape{model.images().shape().channels, model.images().shape().rows};
    file.tensors.push_back({"image.row_mean", shape, model.rows.mean});
    file.tensors.push_back({"image.row_deviation", shape, model.rows.stddev});
  }
  if (model.ood_detector.known()) {
    const auto n = static_cast<long long>(model.ood_detector.mean.size());
    file.metadata["familiarity"] = Json{{"usual", model.ood_detector.usual}}.dump();
    file.tensors.push_back({"familiarity.mean", {n}, model.ood_detector.mean});
    file.tensors.push_back({"familiarity.whitening", {n * (n + 1) / 2}, model.ood_detector.whitening});
  }
  if (model.recalibration.known()) file.metadata["recalibration"] = to_json(model.recalibration);
  nn::save_network(model.network, file, checkpoint != nullptr ? &checkpoint->momentum_buffers : nullptr);
  if (checkpoint != nullptr && checkpoint->average) nn::add_network(*checkpoint->average, average_prefix, file);
  file.metadata[nn::content_hash_key] = nn::content_sha256(file);
  return nn::to_safetensors(file);
}

Model model_from_bytes(std::string_view bytes, const std::string& where, Checkpoint* checkpoint) {
  ModelFile file{nn::from_safetensors(bytes, where), where};
  if (file.text("format") != format_name)
    throw Error(Code::file_unsupported, where, "is of format '" + file.text("format") + "', not '" + format_name + "'",
                model_remedy);
  if (file.has(nn::content_hash_key) && file.text(nn::content_hash_key) != nn::content_sha256(file.content))
    throw Error(Code::file_damaged, where, "is damaged: its content is not what its SHA-256 says",
                "take an undamaged copy of the file");
  if (checkpoint != nullptr) checkpoint->progress = file.text("progress");
  Model model = file.untrained_model();
  file.read_scalings(model);
  if (file.has("familiarity")) file.read_ood_detector(model);
  if (file.has("recalibration")) file.read_recalibration(model);
  const auto averages = [](const nn::NamedTensor& t) { return t.name.starts_with(average_prefix); };
  if (checkpoint != nullptr && std::ranges::any_of(file.content.tensors, averages))
    checkpoint->average = nn::added_network(average_prefix, model.network, file.content, where);
  nn::load_network(model.network, std::move(file.content), where,
                   checkpoint != nullptr ? &checkpoint->momentum_buffers : nullptr);
  return model;
}

Model load_model(const std::filesystem::path& path) {
  return model_from_bytes(read_file(path, max_own_file_bytes), path.string());
}

Model built_in_model() {
  return model_from_bytes(embedded::built_in_model(), "built-in model");
}

Model model_or_built_in(const std::string& path) {
  return path.empty() ? built_in_model() : load_model(path);
}

std::string model_name(const std::string& path) {
  return path.empty() ? "built-in model" : path;
}

void require_same_experiment(const Model& model, const std::string& name, const sim::Protocol& data,
                             const std::string& file) {
  if (model.protocol.experiment == data.experiment) return;
  const auto described = [](const sim::Protocol& p) {
    return format("'%s' (%g s at %g Hz)", p.name.c_str(), p.duration_s(), p.experiment.sample_rate_hz);
  };
  throw Error(Code::file_differs, file,
              "was made with protocol " + described(data) + ", another experiment than " + described(model.protocol) +
                  " of " + name,
              "make a data set with the model's protocol, or train a model on this one");
}

std::string noise_difference(const sim::Protocol& model, const sim::Protocol& data) {
  const auto described = [](const sim::VestibularNoise& noise) {
    return format("%g degrees from %g to %g Hz, exponent %g", noise.scale_deg, noise.low_hz, noise.high_hz,
                  noise.exponent);
  };
  const std::string ours = described(model.noise.vestibular), theirs = described(data.noise.vestibular);
  if (ours == theirs) return {};
  return "its vestibular noise (" + theirs + ") is not that of the model's training (" + ours +
         "), so Nv means something else";
}

}  // namespace decid
