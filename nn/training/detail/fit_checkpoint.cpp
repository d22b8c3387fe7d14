// The file of an unfinished fit: see fit_checkpoint.hpp. Doubles are written with 17 digits, which read back to their
// bits.
#include "nn/training/detail/fit_checkpoint.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include "base/error.hpp"
#include "base/files/file.hpp"
#include "base/text.hpp"
#include "nn/network_file.hpp"

namespace decid::nn {
namespace {

constexpr const char* settings_key = "fit";

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

namespace {

constexpr const char* begin_again = "delete it to train from the beginning";

/// Reads the file of a checkpoint. Throws Error, and advises to delete nothing but a checkpoint, for any other.
TensorFile read_checkpoint(const std::string& path) {
  TensorFile file;
  try {
    file = from_safetensors(read_file(path, max_own_file_bytes), path);
  } catch (const Error& error) {
    if (error.code() != Code::file_damaged) throw;
    throw Error(error.code(), error.where(), error.problem(),
                std::string("give another path; if it is a fit's checkpoint, ") + begin_again);
  }
  if (!file.metadata.contains(progress_key))
    throw Error(Code::file_unsupported, path,
                is_network(file) ? "is a network, not a checkpoint" : "is not the checkpoint of a fit",
                "give another path");
  const auto hash = file.metadata.find(content_hash_key);
  if (hash == file.metadata.end() || hash->second != content_sha256(file))
    throw Error(Code::file_damaged, path, "is a damaged checkpoint of a fit", begin_again);
  return file;
}

/// Returns the first of two descriptions' settings, which ", " separates, that differs.
std::pair<std::string_view, std::string_view> first_difference(std::string_view a, std::string_view b) {
  const auto take = [](std::string_view& text) {
    const std::string_view setting = text.substr(0, text.find(", "));
    text.remove_prefix(std::min(text.size(), setting.size() + 2));
    return setting;
  };
  while (!a.empty() || !b.empty()) {
    const std::string_view of_a = take(a), of_b = take(b);
    if (of_a != of_b) return {of_a, of_b};
  }
  return {};
}

}  // namespace

void load_checkpoint(Network<float>& network, FitState& state, const std::string& description,
                     const std::string& path) {
  TensorFile file = read_checkpoint(path);
  const auto text = [&](const std::string& key) {
    return file.metadata.contains(key) ? file.metadata.at(key) : std::string();
  };
  const std::string remedy =
      "give the network, samples and options it was begun with, or delete it to train from the beginning";
  for (const auto& [key, value] : network_metadata(network))
    if (text(key) != value) throw Error(Code::file_differs, path, "is of another network", remedy);
  if (const std::string settings = text(settings_key); settings != description) {
    const auto [there, here] = first_difference(settings, description);
    throw Error(Code::file_differs, path,
                "is of a fit with other samples or options: it has " + std::string(there) + " where this fit has " +
                    std::string(here),
                remedy);
  }
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
