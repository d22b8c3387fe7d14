// decid::nn as Python sees it, with NumPy arrays. Users call nn.py beside it.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "bindings/python/functions.hpp"
#include "bindings/python/network.hpp"
#include "nn/fit.hpp"
#include "nn/network_file.hpp"

namespace decid::python {
namespace {

std::span<const float> values_of(const FloatsIn& array) {
  return {array.data(), static_cast<std::size_t>(array.size())};
}

py::tuple tuple_of(const nn::Shape& shape) {
  return py::make_tuple(shape.channels, shape.rows, shape.columns);
}

/// Raises decid.Error in a process that was forked from one with several threads, and records this process's. The
/// record is libdecid's, because its calls and the ones here share OpenMP's threads: its set_threads() looks there and
/// records the number that it sets, which here is the same as before.
void refuse_fork() {
  py::module_::import("decid._decid").attr("set_threads")(thread_count());
}

std::string shape_text(const FloatsIn& array) {
  return py::str(array.attr("shape"));
}

/// Returns true if a sample's axes, behind the first, are the network's input. Axes of length 1 may be left out.
bool has_shape_of(const nn::Shape& shape, const FloatsIn& inputs) {
  std::vector<py::ssize_t> given, wanted;
  for (py::ssize_t axis = 1; axis < inputs.ndim(); ++axis)
    if (inputs.shape(axis) != 1) given.push_back(inputs.shape(axis));
  for (const int extent : {shape.channels, shape.rows, shape.columns})
    if (extent != 1) wanted.push_back(extent);
  return given == wanted;
}

/// The first axis counts samples, which have the network's input shape or are flat.
int samples_in(const FloatsIn& inputs, const Network& network) {
  const nn::Shape& shape = network.input_shape();
  const auto count = inputs.ndim() < 1 ? 0 : inputs.shape(0);
  const bool flat = inputs.ndim() == 2 && inputs.shape(1) == shape.size();
  if (count < 1 || count > 1 << 30 || !(flat || has_shape_of(shape, inputs)))
    throw Error(Code::size_mismatch, "inputs", "have the shape " + shape_text(inputs),
                "give one or more samples along the first axis, each of the network's input_shape " +
                    std::string(py::str(tuple_of(shape))) + " or flat");
  return static_cast<int>(count);
}

/// Views the arrays. The first axis of both counts samples.
nn::Samples samples_of(const FloatsIn& inputs, const FloatsIn& targets, const Network& network) {
  const int count = samples_in(inputs, network);
  if (targets.ndim() < 1 || targets.shape(0) != count)
    throw Error(Code::size_mismatch, "targets",
                "have the shape " + shape_text(targets) + " where there are " + std::to_string(count) + " inputs",
                "give a target for each input along the first axis");
  return {values_of(inputs), values_of(targets), count};
}

py::array predict(Network& network, const FloatsIn& inputs) {
  refuse_fork();
  const auto scope = reading(network);
  const auto count = static_cast<py::ssize_t>(samples_in(inputs, network));
  std::vector<float> outputs;
  {
    const py::gil_scoped_release unlocked;
    outputs = nn::predict(network, values_of(inputs));
  }
  return py::array_t<float>(with_first(count, output_axes(network)), outputs.data());
}

/// by_output: of the outputs' shape. The result has the inputs' shape.
py::array input_gradient(Network& network, const FloatsIn& inputs, const FloatsIn& by_output) {
  refuse_fork();
  const auto scope = reading(network);
  samples_in(inputs, network);
  std::vector<float> gradient;
  {
    const py::gil_scoped_release unlocked;
    gradient = nn::input_gradient(network, values_of(inputs), values_of(by_output));
  }
  return py::array_t<float>(Axes(inputs.shape(), inputs.shape() + inputs.ndim()), gradient.data());
}

/// Views of the parameters and statistics, by their names in files; they keep the network.
py::dict tensors(const py::object& self) {
  auto& network = self.cast<Network&>();
  py::dict all;
  std::size_t line = 0;
  for (nn::Layer<float>& layer : network.layers()) {
    const std::string prefix = "layers." + std::to_string(line) + ".";
    line += layer.lines();
    for (nn::Parameter<float>& p : layer.parameters())
      all[(prefix + p.name).c_str()] =
          py::array_t<float>(std::vector<py::ssize_t>(p.shape.begin(), p.shape.end()), p.value.data(), self);
    for (nn::RunningStatistics<float>& s : layer.statistics())
      all[(prefix + s.name).c_str()] =
          py::array_t<float>(static_cast<py::ssize_t>(s.value.size()), s.value.data(), self);
  }
  return all;
}

/// Views what `given` keeps.
nn::Samples samples_of(const GivenSamples& given, Network& network) {
  if (!given.load) return samples_of(given.inputs, given.targets, network);
  return {given.count, nn::Samples::LoadBatch([&given, &network](const nn::Samples::Batch& batch) {
            load_samples(given, network, batch);
          })};
}

/// loss: a name, or a pair of a function and its name. optimiser: a name, or a function, its name and the number of
/// arrays that it keeps for each parameter. callback(epoch, training loss, validation loss, learning rate) after each
/// epoch. Returns the log's rows, and the epoch that is kept.
py::tuple fit(Network& network, const GivenSamples& given, nn::FitOptions options, const py::object& loss,
              const py::object& optimiser, const GivenSamples* validation, const py::object& callback) {
  refuse_fork();
  const auto scope = fitting(network);
  const nn::Samples samples = samples_of(given, network);
  if (py::isinstance<py::str>(loss)) {
    options.loss = nn::loss_named(loss.cast<std::string>());
  } else {
    const auto [call, name] = loss.cast<std::pair<py::object, std::string>>();
    options.loss = std::make_shared<FunctionLoss>(call, name, given.target, network);
  }
  if (py::isinstance<py::str>(optimiser)) {
    options.optimiser = nn::optimiser_named(optimiser.cast<std::string>());
  } else {
    const auto [call, name, memory] = optimiser.cast<std::tuple<py::object, std::string, int>>();
    options.optimiser = std::make_shared<FunctionOptimiser>(call, name, memory, network);
  }
  if (validation != nullptr) options.validation_samples = samples_of(*validation, network);
  options.after_batch = [](int, int, double) {
    const py::gil_scoped_acquire locked;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();  // Ctrl-C
    return true;
  };
  options.after_epoch = [&](const nn::FitEpoch& e) {
    const py::gil_scoped_acquire locked;
    const auto callback_scope = in_callback(network);
    if (!callback.is_none()) callback(e.epoch, e.training_loss, e.validation_loss, e.learning_rate);
  };
  nn::FitLog log;
  {
    const py::gil_scoped_release unlocked;
    log = nn::fit(network, samples, options);
  }
  py::list rows;
  for (const nn::FitEpoch& e : log.epochs)
    rows.append(py::make_tuple(e.epoch, e.training_loss, e.validation_loss, e.learning_rate));
  return py::make_tuple(rows, log.kept);
}

}  // namespace
}  // namespace decid::python

PYBIND11_MODULE(_nn, module) {
  using namespace decid::python;
  using namespace py::literals;
  namespace nn = decid::nn;
  module.doc() = "decid::nn for decid.nn, which is what to import.";
  // pybind11 takes a function of a pointer by value.
  // NOLINTNEXTLINE(performance-unnecessary-value-param)
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const decid::Error& error) {
      set_error(error.what(), name(error.code()), error.where().c_str(), error.problem().c_str(),
                error.remedy().c_str());
    }
  });
  py::class_<SamplesRandom>(
      module, "Random",
      "Counted random numbers of an epoch's samples, the same in any batch. Each call goes on with the next numbers of "
      "each sample.")
      .def("uniform", &SamplesRandom::uniform, "count"_a, "Returns (samples, count) uniform numbers between 0 and 1.")
      .def("normal", &SamplesRandom::normal, "count"_a, "Returns (samples, count) standard normal numbers.");
  py::class_<GivenSamples>(module, "Samples")
      .def(py::init([](const FloatsIn& inputs, const FloatsIn& targets) {
        GivenSamples given{inputs, targets};
        if (targets.ndim() > 0) given.target.assign(targets.shape() + 1, targets.shape() + targets.ndim());
        return given;
      }))
      .def(py::init([](int count, const py::object& load, const Axes& target) {
        return GivenSamples{{}, {}, count, load, target};
      }));
  py::class_<Network>(module, "Network")
      .def(py::init([](const std::array<int, 3>& shape, const std::string& architecture) {
        return std::make_unique<Network>(nn::Shape{shape[0], shape[1], shape[2]}, architecture);
      }))
      .def_property_readonly("input_shape", [](const Network& n) { return tuple_of(n.input_shape()); })
      .def_property_readonly("output_shape", [](const Network& n) { return tuple_of(n.output_shape()); })
      .def_property_readonly("architecture", [](const Network& n) { return n.architecture(); })
      .def_property_readonly("parameter_count", [](const Network& n) { return n.parameter_count(); })
      .def_property_readonly("weights_sha256",
                             [](const Network& n) {
                               require_readable(n);
                               return nn::weights_sha256(n);
                             })
      .def_property_readonly("tensors", tensors)
      .def("initialise",
           [](Network& n, std::uint64_t seed) {
             require_changeable(n);
             n.initialise(seed);
           })
      .def("predict", predict)
      .def("input_gradient", input_gradient)
      .def("accuracy",
           [](Network& n, const FloatsIn& inputs, const FloatsIn& targets) {
             refuse_fork();
             const auto scope = reading(n);
             const nn::Samples samples = samples_of(inputs, targets, n);
             const py::gil_scoped_release unlocked;
             return nn::accuracy(n, samples);
           })
      .def("save",
           [](const Network& n, const std::string& path) {
             require_readable(n);
             nn::write_network(n, path);
           })
      .def("to_bytes",
           [](const Network& n) {
             require_readable(n);
             return py::bytes(nn::to_safetensors(nn::to_tensors(n)));
           })
      .def("fit", [](Network& network, const GivenSamples& samples, const py::object& loss, const py::object& optimiser,
                     int epochs, int batch, double learning_rate, const std::string& schedule, double warmup_epochs,
                     double clip_norm, double average, int frozen_lines, double validation,
                     const GivenSamples* validation_samples, int patience, std::uint64_t seed,
                     const std::string& checkpoint, const py::object& callback) {
        return fit(network, samples,
                   {.epochs = epochs,
                    .batch = batch,
                    .learning_rate = learning_rate,
                    .schedule = schedule,
                    .warmup_epochs = warmup_epochs,
                    .clip_norm = clip_norm,
                    .average = average,
                    .frozen_lines = frozen_lines,
                    .validation = validation,
                    .patience = patience,
                    .seed = seed,
                    .checkpoint = checkpoint},
                   loss, optimiser, validation_samples, callback);
      });
  module.def("load", [](const std::string& path) { return std::make_unique<Network>(nn::read_network(path)); });
  module.def("of_bytes", [](const py::bytes& content) {
    const std::string bytes = content;
    return std::make_unique<Network>(
        nn::from_tensors(nn::from_safetensors(bytes, "pickled network"), "pickled network"));
  });
}
