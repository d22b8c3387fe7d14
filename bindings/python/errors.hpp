// Shared code of the modules _decid and _nn: the type of arrays that they take, and decid.Error.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

namespace decid::python {

namespace py = pybind11;

using DoublesIn = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Sets decid.Error as the interpreter's error, with the message, its three parts and its code.
inline void set_error(const char* text, const char* code, const char* where, const char* problem, const char* remedy) {
  const py::object type = py::module_::import("decid._decid").attr("Error");
  const py::object error = type(text);
  error.attr("code") = code;
  error.attr("where") = where;
  error.attr("problem") = problem;
  error.attr("remedy") = remedy;
  PyErr_SetObject(type.ptr(), error.ptr());
}

}  // namespace decid::python
