// Shared code of the modules _decid and _nn: the type of arrays that they take, and decid.Error.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstring>

namespace decid::python {

namespace py = pybind11;

using DoublesIn = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Returns text that may name a file whose name is not UTF-8, as os.fsdecode() does: other bytes become surrogates.
inline py::str text_of(const char* text) {
  return py::reinterpret_steal<py::str>(
      PyUnicode_DecodeUTF8(text, static_cast<Py_ssize_t>(std::strlen(text)), "surrogateescape"));
}

/// Sets decid.Error as the interpreter's error, with the message, its three parts and its code.
inline void set_error(const char* text, const char* code, const char* where, const char* problem, const char* remedy) {
  const py::object type = py::module_::import("decid._decid").attr("Error");
  const py::object error = type(text_of(text));
  error.attr("code") = code;
  error.attr("where") = text_of(where);
  error.attr("problem") = text_of(problem);
  error.attr("remedy") = text_of(remedy);
  PyErr_SetObject(type.ptr(), error.ptr());
}

}  // namespace decid::python
