// The C interface as a Python module. Users call the Python code beside it.
#include "bindings/python/calls.hpp"

namespace decid::python {
namespace {

// ---- Protocols and models ----

Protocol load_protocol(const std::string& name_or_path, const OptionalText& controller) {
  decid_protocol* made = nullptr;
  run([&] { return decid_protocol_load_controller(name_or_path.c_str(), text_or_null(controller), &made); });
  return {std::shared_ptr<decid_protocol>(made, decid_protocol_free)};
}

py::dict controllers() {
  py::dict all;
  for (std::size_t i = 0; i < decid_controllers(); ++i)
    all[decid_controller_name(i)] = py::str(decid_controller_description(i));
  return all;
}

py::list protocol_parameters(const Protocol& protocol) {
  py::list all;
  for (std::size_t p = 0; p < decid_protocol_parameters(protocol.get()); ++p) {
    const decid_parameter_info& info = *decid_protocol_parameter(protocol.get(), p);
    all.append(py::make_tuple(info.name, info.unit, info.description, info.low, info.high, info.scales_with_mgh != 0));
  }
  return all;
}

py::array protocol_tilt(const py::object& self) {
  const auto* protocol = self.cast<const Protocol&>().get();
  return view(decid_protocol_tilt(protocol), {static_cast<py::ssize_t>(decid_protocol_samples(protocol))}, self);
}

py::tuple simulate(const Protocol& protocol, const DoublesIn& parameters, std::uint64_t seed) {
  const auto count = static_cast<py::ssize_t>(decid_protocol_parameters(protocol.get()));
  if (parameters.ndim() != 2 || parameters.shape(1) != count)
    throw py::value_error("parameters: trials x " + std::to_string(count) + " values are needed");
  const auto samples = static_cast<py::ssize_t>(decid_protocol_samples(protocol.get()));
  py::array_t<double> sway({parameters.shape(0), samples});
  py::array_t<unsigned char> valid(parameters.shape(0));
  run([&, values = parameters.data(), rows = sway.mutable_data(), standing = valid.mutable_data()] {
    return decid_simulate(protocol.get(), values, static_cast<std::size_t>(parameters.shape(0)), seed, rows, standing);
  });
  return py::make_tuple(sway, valid);
}

Model load_model(const OptionalText& path) {
  decid_model* made = nullptr;
  run([&] { return decid_model_load(text_or_null(path), &made); });
  return Model::of(made);
}

py::list model_layers(const Model& model) {
  py::list all;
  for (std::size_t i = 0; i < decid_model_layers(model.get()); ++i) {
    const decid_layer& layer = *decid_model_layer(model.get(), i);
    const auto shape = [](const std::size_t(&of)[3]) { return py::make_tuple(of[0], of[1], of[2]); };
    all.append(py::make_tuple(layer.text, shape(layer.input_shape), shape(layer.output_shape), layer.flops));
  }
  return all;
}

py::dict model_tensors(const py::object& self) {
  const auto* model = self.cast<const Model&>().get();
  py::dict all;
  for (std::size_t i = 0; i < decid_model_tensors(model); ++i) {
    const decid_tensor& tensor = *decid_model_tensor(model, i);
    all[tensor.name] = view(tensor.values, {tensor.shape, tensor.shape + tensor.dimensions}, self);
  }
  return all;
}

// ---- Recordings and results ----

Recording read_recording(const std::string& path, const OptionalText& column, int unit, double rate_hz,
                         double fill_gaps_s, const OptionalText& tilt_column, int tilt_unit, bool invert_sway,
                         bool invert_tilt, int skip_lines, double com_height_m, double body_height_m,
                         const std::array<OptionalText, 5>& columns, const OptionalText& section,
                         const OptionalText& trial_column, const OptionalText& trial,
                         const std::optional<double>& missing, bool mean_is_upright) {
  decid_read_options options;
  decid_read_defaults(&options, sizeof options);
  options.column = text_or_null(column);
  options.unit = unit;
  options.rate_hz = rate_hz;
  options.fill_gaps_s = fill_gaps_s;
  options.tilt_column = text_or_null(tilt_column);
  options.tilt_unit = tilt_unit;
  options.invert_sway = invert_sway;
  options.invert_tilt = invert_tilt;
  options.skip_lines = skip_lines;
  options.com_height_m = com_height_m;
  options.body_height_m = body_height_m;
  options.leg_column = text_or_null(columns[0]);
  options.trunk_column = text_or_null(columns[1]);
  options.hip_column = text_or_null(columns[2]);
  options.shoulder_column = text_or_null(columns[3]);
  options.ankle_column = text_or_null(columns[4]);
  options.section = text_or_null(section);
  options.trial_column = text_or_null(trial_column);
  options.trial = text_or_null(trial);
  options.missing_value = missing ? &*missing : nullptr;
  options.mean_is_upright = mean_is_upright ? 1 : 0;
  decid_recording* made = nullptr;
  run([&] { return decid_recording_read(path.c_str(), &options, &made); });
  return Recording::of(made);
}

std::vector<std::string> trial_names(const std::string& path, const std::string& trial_column, int skip_lines,
                                     const OptionalText& section) {
  decid_read_options options;
  decid_read_defaults(&options, sizeof options);
  options.trial_column = trial_column.c_str();
  options.skip_lines = skip_lines;
  options.section = text_or_null(section);
  decid_trials* made = nullptr;
  run([&] { return decid_trials_read(path.c_str(), &options, &made); });
  const auto trials = Handle<decid_trials, decid_trials_free>::of(made);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < decid_trials_count(made); ++i) names.emplace_back(decid_trials_name(made, i));
  return names;
}

/// tilt: as long as sway, which the caller checks.
Recording make_recording(const DoublesIn& sway, double rate_hz, int unit, const std::optional<DoublesIn>& tilt,
                         int tilt_unit, bool invert_sway, bool invert_tilt, bool mean_is_upright) {
  if (sway.ndim() != 1 || (tilt && (tilt->ndim() != 1 || tilt->size() != sway.size())))
    throw py::value_error("sway and tilt: give arrays of one dimension and length, one value per sample");
  decid_samples_options options;
  decid_samples_defaults(&options, sizeof options);
  options.unit = unit;
  options.tilt = tilt ? tilt->data() : nullptr;
  options.tilt_unit = tilt_unit;
  options.invert_sway = invert_sway ? 1 : 0;
  options.invert_tilt = invert_tilt ? 1 : 0;
  options.mean_is_upright = mean_is_upright ? 1 : 0;
  decid_recording* made = nullptr;
  run([&, values = sway.data(), samples = static_cast<std::size_t>(sway.size())] {
    return decid_recording_of_samples(values, samples, rate_hz, &options, &made);
  });
  return Recording::of(made);
}

py::object recording_signal(const py::object& self, const double* (*signal)(const decid_recording*)) {
  const auto* recording = self.cast<const Recording&>().get();
  const double* values = signal(recording);
  if (values == nullptr) return py::none();
  return view(values, {static_cast<py::ssize_t>(decid_recording_samples(recording))}, self);
}

py::list recording_warnings(const Recording& recording) {
  py::list all;
  for (std::size_t i = 0; i < decid_recording_warnings(recording.get()); ++i)
    all.append(warning(*decid_recording_warning(recording.get(), i)));
  return all;
}

Result identify(const Model& model, const Recording& recording, double mass_kg, double height_m, double begin_s,
                int detrend) {
  decid_identify_options options;
  decid_identify_defaults(&options, sizeof options);
  options.mass_kg = mass_kg;
  options.height_m = height_m;
  options.begin_s = begin_s;
  options.detrend = detrend;
  decid_result* made = nullptr;
  run([&] { return decid_identify(model.get(), recording.get(), &options, &made); });
  return Result::of(made);
}

/// Name, low, high, mean, standard deviation: see decid_parameter_prior.
using ParameterPrior = std::tuple<std::string, double, double, double, double>;

Result fit(const Model& model, const Recording& recording, double mass_kg, double height_m, double begin_s, int detrend,
           const std::optional<Protocol>& protocol, double prior_start_s, double prior_gain, double prior_noise_deg,
           int max_draws, std::uint64_t seed, bool moved_before, const std::vector<ParameterPrior>& parameter_priors,
           const OptionalText& controllers, py::object progress) {
  Callback callback(std::move(progress));
  decid_fit_options options;
  decid_fit_defaults(&options, sizeof options);
  options.mass_kg = mass_kg;
  options.height_m = height_m;
  options.begin_s = begin_s;
  options.detrend = detrend;
  options.protocol = protocol ? protocol->get() : nullptr;
  options.prior_start_s = prior_start_s;
  options.prior_gain = prior_gain;
  options.prior_noise_deg = prior_noise_deg;
  options.max_draws = max_draws;
  options.seed = seed;
  options.moved_before = moved_before ? 1 : 0;
  std::vector<decid_parameter_prior> priors;
  for (const auto& [name, low, high, mean, sd] : parameter_priors)
    priors.push_back({name.c_str(), low, high, mean, sd});
  options.parameter_priors = priors.data();
  options.parameter_prior_count = priors.size();
  options.controllers = text_or_null(controllers);
  options.progress = Callback::progress;
  options.user = &callback;
  decid_result* made = nullptr;
  callback.run([&] { return decid_fit(model.get(), recording.get(), &options, &made); });
  return Result::of(made);
}

/// Keywords of decid.Parameter.
py::list result_quantities(const Result& result) {
  py::list all;
  for (std::size_t q = 0; q < decid_result_quantities(result.get()); ++q) {
    const decid_parameter& of = *decid_result_parameter(result.get(), q);
    all.append(py::dict(
        "name"_a = of.name, "unit"_a = of.unit, "low"_a = number_or_none(of.low), "high"_a = number_or_none(of.high),
        "value"_a = of.value, "sd"_a = number_or_none(of.sd), "interval50"_a = interval_or_none(of.interval50),
        "interval90"_a = interval_or_none(of.interval90), "normalized"_a = number_or_none(of.normalized),
        "normalized_interval90"_a = interval_or_none(of.normalized_interval90), "rhat"_a = number_or_none(of.rhat),
        "effective_draws"_a = number_or_none(of.effective_draws)));
  }
  return all;
}

py::array_t<double> result_correlations(const Result& result) {
  const std::size_t size = decid_result_quantities(result.get());
  py::array_t<double> all({size, size});
  auto values = all.mutable_unchecked<2>();
  for (std::size_t a = 0; a < size; ++a)
    for (std::size_t b = 0; b < size; ++b)
      values(static_cast<py::ssize_t>(a), static_cast<py::ssize_t>(b)) = decid_result_correlation(result.get(), a, b);
  return all;
}

py::dict result_figures(const Result& result) {
  const decid_figures& of = *decid_result_figures(result.get());
  return py::dict("rms_residual_deg"_a = number_or_none(of.rms_residual_deg),
                  "variance_accounted_for"_a = number_or_none(of.variance_accounted_for),
                  "peak_to_peak_deg"_a = of.peak_to_peak_deg, "response_ratio"_a = number_or_none(of.response_ratio),
                  "ood_score"_a = number_or_none(of.ood_score), "tilt_delay_s"_a = number_or_none(of.tilt_delay_s),
                  "tilt_correlation"_a = number_or_none(of.tilt_correlation),
                  "tilt_gain"_a = number_or_none(of.tilt_gain), "mass_kg"_a = of.mass_kg,
                  "com_height_m"_a = of.com_height_m, "inertia_kgm2"_a = of.inertia_kgm2,
                  "body_assumed"_a = of.body_assumed != 0);
}

py::list result_warnings(const Result& result) {
  py::list all;
  for (std::size_t i = 0; i < decid_result_warnings(result.get()); ++i)
    all.append(warning(*decid_result_warning(result.get(), i)));
  return all;
}

py::array result_signal(const py::object& self, const float* (*signal)(const decid_result*, std::size_t*)) {
  std::size_t samples = 0;
  const float* values = signal(self.cast<const Result&>().get(), &samples);
  return view(values, {static_cast<py::ssize_t>(samples)}, self);
}

/// Keywords of decid.Sampling.
py::object result_sampling(const Result& result) {
  const decid_sampling* of = decid_result_sampling(result.get());
  if (of == nullptr) return py::none();
  return py::dict("chains"_a = of->chains, "draws"_a = of->draws, "agreed"_a = of->agreed != 0,
                  "from_network"_a = of->from_network != 0, "divergences"_a = of->divergences,
                  "samples_noise_deg"_a = of->samples_noise_deg, "seconds"_a = of->seconds);
}

py::object result_draws(const py::object& self) {
  const auto* result = self.cast<const Result&>().get();
  const decid_sampling* sampling = decid_result_sampling(result);
  if (sampling == nullptr) return py::none();
  py::dict all;
  for (std::size_t q = 0; q < decid_result_quantities(result); ++q)
    all[decid_result_parameter(result, q)->name] = view(decid_result_draws(result, q), {sampling->draws}, self);
  return all;
}

/// Keywords of decid.ComparedController.
py::list result_controllers(const Result& result) {
  py::list all;
  for (std::size_t i = 0; i < decid_result_controllers(result.get()); ++i) {
    const decid_compared_controller& of = *decid_result_controller(result.get(), i);
    all.append(py::dict("controller"_a = of.controller, "log_predictive_density"_a = of.log_predictive_density,
                        "difference"_a = of.difference, "difference_standard_error"_a = of.difference_standard_error,
                        "weight"_a = of.weight, "comparable"_a = of.comparable != 0));
  }
  return all;
}

// ---- Studies ----

/// Returns the JSON of the study.
py::str run_study(const Model& model, const std::string& sheet, bool by_group, const OptionalText& within,
                  const OptionalText& covariates, bool fit, const OptionalText& joint, const OptionalText& free,
                  int max_draws, std::uint64_t seed, const OptionalText& controllers, py::object progress) {
  Callback callback(std::move(progress));
  decid_study_options options;
  decid_study_defaults(&options, sizeof options);
  options.by_group = by_group ? 1 : 0;
  options.within = text_or_null(within);
  options.covariates = text_or_null(covariates);
  options.fit = fit ? 1 : 0;
  options.joint = text_or_null(joint);
  options.free = text_or_null(free);
  options.controllers = text_or_null(controllers);
  options.max_draws = max_draws;
  options.seed = seed;
  options.progress = Callback::progress;
  options.user = &callback;
  decid_study* made = nullptr;
  callback.run([&] { return decid_study_run(model.get(), sheet.c_str(), &options, &made); });
  const auto study = Handle<decid_study, decid_study_free>::of(made);
  return py::str(decid_study_json(made));
}

// ---- Data sets, evaluation, training ----

Dataset make_dataset(const Protocol& protocol, int count, int base, std::uint64_t seed, const OptionalText& path,
                     py::object progress) {
  Callback callback(std::move(progress));
  decid_dataset_options options;
  decid_dataset_defaults(&options, sizeof options);
  options.count = count;
  options.base = base;
  options.seed = seed;
  options.path = text_or_null(path);
  options.progress = Callback::progress;
  options.user = &callback;
  decid_dataset* made = nullptr;
  callback.run([&] { return decid_dataset_make(protocol.get(), &options, &made); });
  return Dataset::of(made);
}

Dataset read_dataset(const std::string& path) {
  decid_dataset* made = nullptr;
  run([&] { return decid_dataset_read(path.c_str(), &made); });
  return Dataset::of(made);
}

py::ssize_t trials_of(const Dataset& dataset) {
  return static_cast<py::ssize_t>(decid_dataset_trials(dataset.get()));
}

/// A view; of a data set on disk, a copy.
py::array dataset_sway(const py::object& self) {
  const auto& dataset = self.cast<const Dataset&>();
  const auto samples = static_cast<py::ssize_t>(decid_protocol_samples(decid_dataset_protocol(dataset.get())));
  const std::vector<py::ssize_t> shape{trials_of(dataset), samples};
  if (const float* values = decid_dataset_sway(dataset.get())) return view(values, shape, self);
  py::array_t<float> copy(shape);
  run([&, rows = copy.mutable_data()] {
    return decid_dataset_copy_sway(dataset.get(), 0, decid_dataset_trials(dataset.get()), rows);
  });
  return copy;
}

py::array dataset_parameters(const py::object& self) {
  const auto& dataset = self.cast<const Dataset&>();
  const auto count = static_cast<py::ssize_t>(decid_protocol_parameters(decid_dataset_protocol(dataset.get())));
  return view(decid_dataset_parameters(dataset.get()), {trials_of(dataset), count}, self);
}

/// Keywords of decid.Evaluation.
py::dict evaluate(const Model& model, const Dataset& dataset, int split) {
  decid_evaluation found;
  run([&] { return decid_evaluate(model.get(), dataset.get(), split, &found, sizeof found); });
  const std::size_t parameters = decid_protocol_parameters(decid_model_protocol(model.get()));
  return py::dict(
      "trials"_a = found.trials, "mse"_a = found.mse, "matlab_loss"_a = found.matlab_loss,
      "mse_per_parameter"_a = std::vector<double>(found.mse_per_parameter, found.mse_per_parameter + parameters),
      "coverage50"_a = number_or_none(found.coverage50), "coverage90"_a = number_or_none(found.coverage90),
      "log_score"_a = number_or_none(found.log_score));
}

Model train(const std::optional<Dataset>& dataset, const std::optional<Protocol>& protocol, const std::string& preset,
            const OptionalText& architecture, const OptionalText& head, const OptionalText& image,
            const OptionalText& schedule, int epochs, int batch, double learning_rate, double momentum,
            double weight_decay, std::uint64_t seed, int patience, int stream_trials, int validation_trials,
            py::object progress) {
  Callback callback(std::move(progress));
  decid_train_options options;
  decid_train_defaults(&options, sizeof options);
  options.preset = preset.c_str();
  options.architecture = text_or_null(architecture);
  options.head = text_or_null(head);
  options.image = text_or_null(image);
  options.schedule = text_or_null(schedule);
  options.epochs = epochs;
  options.batch = batch;
  options.learning_rate = learning_rate;
  options.momentum = momentum;
  options.weight_decay = weight_decay;
  options.seed = seed;
  options.patience = patience;
  options.stream_trials = stream_trials;
  options.validation_trials = validation_trials;
  options.progress = Callback::training;
  options.user = &callback;
  decid_model* made = nullptr;
  callback.run([&] {
    return decid_train(dataset ? dataset->get() : nullptr, protocol ? protocol->get() : nullptr, &options, &made);
  });
  return Model::of(made);
}

}  // namespace
}  // namespace decid::python

namespace py = pybind11;
using namespace decid::python;

PYBIND11_MODULE(_decid, module) {
  module.doc() = "libdecid for the package decid, which is what to import.";
  // An attribute of the module keeps it.
  module.attr("Error") = py::reinterpret_steal<py::object>(PyErr_NewExceptionWithDoc(
      "decid.Error",
      "Bad input: an argument, a file or a recording. str() reads 'where: problem; remedy', the parts of which are the "
      "attributes where, problem and remedy; the attribute code names its cause ('file_missing').",
      PyExc_ValueError, nullptr));
  run([] { return decid_name_settings(DECID_PLAIN_NAMES); });
  module.attr("__version__") = decid_version();
  module.def("set_threads", [](int threads) { run([&] { return decid_set_threads(threads); }); });

  py::class_<Protocol>(module, "Protocol")
      .def_property_readonly("samples", [](const Protocol& p) { return decid_protocol_samples(p.get()); })
      .def_property_readonly("rate_hz", [](const Protocol& p) { return decid_protocol_rate_hz(p.get()); })
      .def_property_readonly("json", [](const Protocol& p) { return decid_protocol_json(p.get()); })
      .def_property_readonly("controller", [](const Protocol& p) { return decid_protocol_controller(p.get()); })
      .def_property_readonly("parameters", protocol_parameters)
      .def_property_readonly("tilt", protocol_tilt);
  module.def("load_protocol", load_protocol);
  module.def("controllers", controllers);
  module.def("simulate", simulate);

  py::class_<Model>(module, "Model")
      .def_property_readonly("protocol",
                             [](const Model& model) {
                               return Protocol{{model.owned, decid_model_protocol(model.get())}};
                             })
      .def_property_readonly("head", [](const Model& model) { return decid_model_head(model.get()); })
      .def_property_readonly("sha256", [](const Model& model) { return decid_model_sha256(model.get()); })
      .def_property_readonly("layers", model_layers)
      .def_property_readonly("tensors", model_tensors)
      .def("save", [](const Model& model, const std::string& path) {
        run([&] { return decid_model_save(model.get(), path.c_str()); });
      });
  module.def("load_model", load_model);

  py::class_<Recording>(module, "Recording")
      .def_property_readonly("rate_hz", [](const Recording& r) { return decid_recording_rate_hz(r.get()); })
      .def_property_readonly("column", [](const Recording& r) { return decid_recording_column(r.get()); })
      .def_property_readonly("warnings", recording_warnings)
      .def_property_readonly("sway", [](const py::object& r) { return recording_signal(r, decid_recording_sway); })
      .def_property_readonly("tilt", [](const py::object& r) { return recording_signal(r, decid_recording_tilt); });
  module.def("read_recording", read_recording);
  module.def("trial_names", trial_names);
  module.def("recording_of", make_recording);

  py::class_<Result>(module, "Result")
      .def_property_readonly("trust",
                             [](const Result& result) {
                               static constexpr const char* names[] = {"usable", "caution", "not usable"};
                               return names[decid_result_trust(result.get())];
                             })
      .def_property_readonly("parameters", [](const Result& r) { return decid_result_parameters(r.get()); })
      .def_property_readonly("quantities", result_quantities)
      .def_property_readonly("correlations", result_correlations)
      .def_property_readonly("figures", result_figures)
      .def_property_readonly("warnings", result_warnings)
      .def_property_readonly("sampling", result_sampling)
      .def_property_readonly("draws", result_draws)
      .def_property_readonly("controllers", result_controllers)
      .def_property_readonly("sway", [](const py::object& r) { return result_signal(r, decid_result_sway); })
      .def_property_readonly("fitted", [](const py::object& r) { return result_signal(r, decid_result_fitted); });
  module.def("identify", identify);
  module.def("study", run_study);
  module.def("fit", fit);

  py::class_<Dataset>(module, "Dataset")
      .def_property_readonly("protocol",
                             [](const Dataset& dataset) {
                               return Protocol{{dataset.owned, decid_dataset_protocol(dataset.get())}};
                             })
      .def_property_readonly("trials", trials_of)
      .def_property_readonly("sway", dataset_sway)
      .def_property_readonly("parameters", dataset_parameters)
      .def_property_readonly("group",
                             [](const py::object& self) {
                               const auto& dataset = self.cast<const Dataset&>();
                               return view(decid_dataset_group(dataset.get()), {trials_of(dataset)}, self);
                             })
      .def_property_readonly("split",
                             [](const py::object& self) {
                               const auto& dataset = self.cast<const Dataset&>();
                               return view(decid_dataset_split(dataset.get()), {trials_of(dataset)}, self);
                             })
      .def("write", [](const Dataset& dataset, const std::string& path) {
        run([&] { return decid_dataset_write(dataset.get(), path.c_str()); });
      });
  module.def("make_dataset", make_dataset);
  module.def("read_dataset", read_dataset);
  module.def("evaluate", evaluate);
  module.def("train", train);
}
