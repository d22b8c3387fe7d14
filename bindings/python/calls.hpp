// Shared code of the module's functions: handles, statuses as exceptions, callbacks, arrays without copies. Every call
// of libdecid runs without the interpreter's lock.
#pragma once

#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "bindings/c/decid.h"
#include "bindings/python/errors.hpp"

namespace decid::python {

using namespace py::literals;

using OptionalText = std::optional<std::string>;

/// A handle of libdecid.
template <class T, void (*Free)(T*)>
struct Handle {
  std::shared_ptr<T> owned;
  const T* get() const { return owned.get(); }
  static Handle of(T* made) { return {std::shared_ptr<T>(made, Free)}; }
};
using Model = Handle<decid_model, decid_model_free>;
using Recording = Handle<decid_recording, decid_recording_free>;
using Result = Handle<decid_result, decid_result_free>;
using Dataset = Handle<decid_dataset, decid_dataset_free>;
/// A protocol may be part of a model or a data set, which it then keeps.
struct Protocol {
  std::shared_ptr<const decid_protocol> owned;
  const decid_protocol* get() const { return owned.get(); }
};

/// Calls libdecid without the interpreter's lock; throws what its status says.
template <class Call>
void run(const Call& call) {
  decid_status status;
  {
    const py::gil_scoped_release unlocked;
    status = call();
  }
  if (status == DECID_BAD_INPUT) {
    set_error(decid_error_text(), decid_error_code(), decid_error_where(), decid_error_problem(), decid_error_remedy());
    throw py::error_already_set();
  }
  if (status == DECID_NO_MEMORY) throw std::bad_alloc();
  if (status != DECID_OK) throw std::runtime_error(decid_error_text());
}

/// A Python function that libdecid calls back, perhaps from a thread of its own. An exception or Ctrl-C in it stops the
/// work, and the call raises it.
class Callback {
 public:
  explicit Callback(py::object function) : function_(std::move(function)) {}

  template <class... Arguments>
  int call(const Arguments&... arguments) noexcept {
    const py::gil_scoped_acquire locked;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!function_.is_none()) function_(argument(arguments)...);
      return 0;
    } catch (...) {
      raised_ = std::current_exception();
      return 1;
    }
  }
  /// run(), and then what was raised meanwhile.
  template <class Call>
  void run(const Call& call) const {
    try {
      python::run(call);
    } catch (const std::runtime_error&) {
      if (!raised_) throw;
    }
    if (raised_) std::rethrow_exception(raised_);
  }

  static int progress(void* self, double done, const char* stage) {
    return static_cast<Callback*>(self)->call(done, stage);
  }
  static int training(void* self, const decid_training* at) {
    return static_cast<Callback*>(self)->call(at->epoch, at->epochs, at->done, at->trials, at->epoch_is_over != 0,
                                              at->training_mse, at->validation_mse, at->learning_rate);
  }

 private:
  template <class T>
  static const T& argument(const T& value) {
    return value;
  }
  static py::str argument(const char* text) { return text_of(text); }

  py::object function_;
  std::exception_ptr raised_;
};

inline const char* text_or_null(const OptionalText& text) {
  return text ? text->c_str() : nullptr;
}

/// Read-only, without a copy: the array keeps its owner.
template <class T>
py::array view(const T* values, std::vector<py::ssize_t> shape, const py::object& owner) {
  py::array_t<T> array(std::move(shape), values, owner);
  array.attr("setflags")("write"_a = false);
  return array;
}

inline py::object number_or_none(double value) {
  return std::isnan(value) ? py::none() : py::object(py::float_(value));
}

inline py::object interval_or_none(const double (&limits)[2]) {
  return std::isnan(limits[0]) ? py::none() : py::object(py::make_tuple(limits[0], limits[1]));
}

inline py::tuple warning(const decid_warning& of) {
  static constexpr const char* severities[] = {"info", "caution", "invalid"};
  return py::make_tuple(severities[of.severity], of.code, text_of(of.text));
}

}  // namespace decid::python
