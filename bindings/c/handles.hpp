// The opaque types of decid.h, and the code that all of its functions share: no exception passes guarded().
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/text.hpp"
#include "bindings/c/decid.h"
#include "dataset/npz/npz.hpp"
#include "identify/fit_recordings.hpp"
#include "sim/simulate.hpp"

struct decid_protocol {
  explicit decid_protocol(decid::sim::Protocol of);

  decid::sim::Simulator simulator;
  decid::sim::ParameterTable ranges;
  std::string json;
  std::vector<double> tilt_rad;
  std::vector<decid_parameter_info> parameters;  // refer to ranges

  const decid::sim::Protocol& protocol() const { return simulator.protocol(); }
};

struct decid_model {
  decid_model(decid::Model of, std::string called);

  decid::Model model;
  std::string name;  // in errors
  decid_protocol protocol;
  std::string head, sha256;
  std::deque<std::string> texts;  // that the two below refer to
  std::vector<decid_layer> layers;
  std::vector<decid_tensor> tensors;
  std::shared_ptr<const decid::Identifier> identifier;  // of the model's own body; copied for each call
};

struct decid_trials {
  std::vector<std::string> names;
};

struct decid_recording {
  explicit decid_recording(decid::recording::Recording of);

  decid::recording::Recording recording;
  std::vector<decid_warning> warnings;
};

struct decid_result {
  /// common: what the report of the result says of its body.
  decid_result(decid::RecordingResult of, const decid::Report& common);

  decid::RecordingResult result;
  decid::sim::ParameterTable ranges;
  std::vector<decid_warning> warnings;
  std::vector<decid_parameter> quantities;
  decid_figures figures;
  decid_sampling sampling;
  std::vector<std::vector<double>> draws;              // by quantity
  std::vector<decid_compared_controller> controllers;  // none unless several were fitted
};

struct decid_dataset {
  explicit decid_dataset(decid::dataset::StoredDataset of);

  decid::dataset::StoredDataset data;
  decid_protocol protocol;
  std::vector<double> parameters;
};

namespace decid::c {

/// A callback asked for the end.
struct Stopped {
  const char* where;
};

/// Keeps the exception that is being handled as this thread's error.
decid_status remember_failure() noexcept;

/// Throws Error in a process that was forked from one with recorded threads: OpenMP would wait for ever for
/// threads that are not in it. A process that had one thread lacks nothing after a fork.
void refuse_fork();

/// Records that this process has several threads, if a call of this thread may start them.
void record_threads();

template <class F>
decid_status caught(const F& f) noexcept {
  try {
    f();
    return DECID_OK;
  } catch (...) {
    return remember_failure();
  }
}

template <class F>
decid_status guarded(const F& f) noexcept {
  return caught([&] {
    refuse_fork();
    record_threads();
    f();
  });
}

/// Makes a handle: sets *place to what `make` returns, or to null if it throws.
template <class Handle, class Make>
decid_status made(Handle** place, const char* where, const Make& make) noexcept {
  if (place != nullptr) *place = nullptr;
  return guarded([&] {
    if (place == nullptr)
      throw Error(Code::setting_missing, where, "has no place for what it makes", "give the address of a pointer");
    std::unique_ptr<Handle> handle = make();
    *place = handle.release();
  });
}

/// Returns the value behind a pointer. Throws Error if it is null.
template <class T>
T& given(T* pointer, const char* where, const char* what) {
  if (pointer == nullptr) throw Error(Code::setting_missing, where, std::string(what) + " is NULL", "give one");
  return *pointer;
}

/// Returns a path to write to. Throws Error if it is null or empty: before the work, which would be in vain.
inline const char* path_to_write(const char* path, const char* where) {
  if (given(path, where, "path") == '\0')
    throw Error(Code::setting_missing, where, "the path is empty", "give the path of a file");
  return path;
}

/// Sets how a fit draws. Throws Error for fewer than 8 draws.
inline void set_sampler(posterior::Settings& settings, std::uint64_t seed, int max_draws, const char* where) {
  if (max_draws < 8)
    throw Error(Code::setting_out_of_range, where, format("max_draws is %d", max_draws), "give 8 or more");
  settings.seed = seed;
  settings.max_draws = max_draws;
  settings.min_draws = std::min(settings.min_draws, max_draws);
}

template <class Options>
void set_defaults(Options* options, std::size_t size, Options defaults) noexcept {
  if (options == nullptr) return;
  defaults.size = size;
  std::memset(static_cast<void*>(options), 0, size);
  std::memcpy(static_cast<void*>(options), &defaults, std::min(size, sizeof defaults));
}

/// The options that were given, or the defaults. Throws Error unless they are of this library's size or, from an older
/// header, a smaller one.
template <class Options>
Options options_of(const Options* options, void (*set)(Options*, std::size_t), const char* where) {
  Options all;
  set(&all, sizeof all);
  if (options == nullptr) return all;
  if (options->size < sizeof options->size || options->size > sizeof all)
    throw Error(Code::size_mismatch, where,
                format("its options have a size of %zu, those of this library %zu", options->size, sizeof all),
                "set them with their decid_.._defaults(), and run with the library of that header or a newer one");
  std::memcpy(static_cast<void*>(&all), options, options->size);
  return all;
}

inline std::string text_or_empty(const char* text) {
  return text == nullptr ? "" : text;
}

/// Element i for an accessor, null if there is none.
template <class T>
const T* at(const std::vector<T>& list, std::size_t i) noexcept {
  return i < list.size() ? &list[i] : nullptr;
}

std::vector<decid_warning> to_c(const Warnings& warnings);

/// Throws Error if one of the two is given without the other; both 0: empty.
std::optional<sim::Body> make_body(double mass_kg, double height_m, const char* where);

}  // namespace decid::c
