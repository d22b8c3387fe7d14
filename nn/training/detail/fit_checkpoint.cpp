// The file of an unfinished fit: see fit_checkpoint.hpp. Doubles are written with 17 digits, which read back to their
// bits.
#include "nn/training/detail/fit_checkpoint.hpp"

#include <charconv>
#include <string_view>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/text.hpp"
#include "nn/network_file.hpp"

namespace decid::nn {
namespace {

constexpr const char *settings_key = "fit", *progress_key = "progress";

/// "optimiser.<kept value>.<parameter>", both counted from 0.
std::string memory_name(std::size_t kept, std::size_t parameter) {
  return "optimiser." + std::to_string(kept) + "." + std::to_string(parameter);
}

std::string progress(const FitState& s) {
  std::string text =
      format("%lld %d %d %d %.17g", s.optimiser.steps, s.best_epoch, s.at.epoch, s.at.batch, s.at.loss_sum);
  for (const FitEpoch& e : s.log)
    text += format(" %.17g %.17g %.17g", e.training_loss, e.validation_loss, e.learning_rate);
  return text;
}

/// Reads progress() numbers one by one.
class Numbers {
 public:
  Numbers(const std::string& text, std::string where) : text_(text), where_(std::move(where)) {}

  bool done() const { return text_.empty(); }
  template <class N>
  N take() {
    N number{};
    const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), number);
    if (error != std::errc())
      throw Error(Code::file_damaged, where_, "has progress that is not numbers",
                  "delete it to train from the beginning");
    text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
    if (text_.starts_with(' ')) text_.remove_prefix(1);
    return number;
  }

 private:
  std::string_view text_;
  std::string where_;
};

void read_progress(const std::string& text, const std::string& where, FitState& state) {
  Numbers numbers(text, where);
  state.optimiser.steps = numbers.take<long long>();
  state.best_epoch = numbers.take<int>();
  state.at.epoch = numbers.take<int>();
  state.at.batch = numbers.take<int>();
  state.at.loss_sum = numbers.take<double>();
  state.log.clear();
  while (!numbers.done()) {
    FitEpoch epoch;
    epoch.epoch = static_cast<int>(state.log.size()) + 1;
    epoch.training_loss = numbers.take<double>();
    epoch.validation_loss = numbers.take<double>();
    epoch.learning_rate = numbers.take<double>();
    state.log.push_back(epoch);
  }
  if (state.at.epoch != static_cast<int>(state.log.size()) || state.at.batch < 0 || state.best_epoch < 0 ||
      state.best_epoch > state.at.epoch)
    throw Error(Code::file_damaged, where, "has progress that does not fit together",
                "delete it to train from the beginning");
}

}  // namespace

void save_checkpoint(const Network<float>& network, const FitState& state, const std::string& description,
                     const std::string& path) {
  TensorFile file = to_tensors(network);
  file.metadata[settings_key] = description;
  file.metadata[progress_key] = progress(state);
  for (std::size_t kept = 0; kept < state.optimiser.memory.size(); ++kept)
    for (std::size_t k = 0; k < state.optimiser.memory[kept].size(); ++k) {
      const std::vector<float>& values = state.optimiser.memory[kept][k];
      file.tensors.push_back({memory_name(kept, k), {static_cast<long long>(values.size())}, values});
    }
  if (state.average) add_network(*state.average, "average.", file);
  if (state.best) add_network(*state.best, "best.", file);
  file.metadata[content_hash_key] = content_sha256(file);
  write_file(path, to_safetensors(file));
}

void load_checkpoint(Network<float>& network, FitState& state, const std::string& description,
                     const std::string& path) {
  TensorFile file = from_safetensors(read_file(path, max_own_file_bytes), path);
  const auto text = [&](const std::string& key) {
    return file.metadata.contains(key) ? file.metadata.at(key) : std::string();
  };
  if (text(content_hash_key) != content_sha256(file))
    throw Error(Code::file_damaged, path, "is not a checkpoint of a fit, or is damaged",
                "delete it to train from the beginning");
  const std::string remedy =
      "give the network, samples and options it was begun with, or delete it to train from the beginning";
  for (const auto& [key, value] : network_metadata(network))
    if (text(key) != value) throw Error(Code::file_differs, path, "is of another network", remedy);
  if (text(settings_key) != description)
    throw Error(Code::file_differs, path,
                "is of a fit with other samples or options: " + text(settings_key) + "; here " + description, remedy);
  FitState loaded = state;
  read_progress(text(progress_key), path, loaded);
  const TensorIndex index(file);
  for (std::size_t kept = 0; kept < loaded.optimiser.memory.size(); ++kept)
    for (std::size_t k = 0; k < loaded.optimiser.memory[kept].size(); ++k) {
      std::vector<float>& values = loaded.optimiser.memory[kept][k];
      values = index.find(memory_name(kept, k), values.size(), path).values;
    }
  if (loaded.average) loaded.average = added_network("average.", network, file, path);
  if (loaded.best_epoch > 0) loaded.best = added_network("best.", network, file, path);
  load_network(network, std::move(file), path);
  state = std::move(loaded);
}

}  // namespace decid::nn
