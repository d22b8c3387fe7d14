"""The functions of decid: reading, identification, fits, simulation, data sets, training."""
from __future__ import annotations

import json
import math
import os
from dataclasses import dataclass, field
from inspect import signature
from typing import Any, Callable, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike

from . import _decid
from ._checks import (body_of, error as _error, flag, function_or_none, number, number_or, numbers_of, pairs_of, path_of, path_or_none, positive_or_0, seed_of,
                      whole, words, words_or_none)
from ._network import Model, Protocol, as_model, as_protocol
from ._results import Evaluation, Fit, Notice, Result, Study, result_of

Path = Union[str, bytes, "os.PathLike[str]", "os.PathLike[bytes]"]

_UNITS = {None: 0, "deg": 1, "rad": 2, "mrad": 3, "mm": 4, "cm": 5, "m": 6}
_DETREND = {"none": 0, "offset": 1, "linear": 2}
_SPLITS = {"all": 0, "training": 1, "validation": 2}


def _number_of(choices: dict[Any, int], value: Any, where: str) -> int:
    if not isinstance(value, (str, type(None))) or value not in choices:
        names = ", ".join(repr(name) for name in choices if name is not None)
        raise _error("setting_unknown", where, f"{value!r} is none of its values", f"give one of {names}")
    return choices[value]


def _text_of(name: Union[str, int, None], where: str) -> Optional[str]:
    return None if name is None else words(str(name), where)


def _angle_of(unit: Optional[str], name: str) -> int:
    """The number of a unit of angles; None is 0."""
    if unit in ("mm", "cm", "m"):
        raise _error("unit_unknown", name, f"is {unit!r}, a unit of positions", 'give a unit of angles: "deg", "rad" or "mrad"')
    return _number_of(_UNITS, unit, name)


def controllers() -> dict[str, str]:
    """Returns a description of each posture controller, by its name."""
    return _decid.controllers()


def set_threads(threads: int) -> None:
    """Sets the number of threads for calls from this thread, 1 to 1024; default: all cores. No result depends on it.

    A process whose first call of decid is set_threads(1) can be forked: its children compute too."""
    _decid.set_threads(whole(threads, "threads"))


class Recording:
    """Sway, and perhaps the platform's tilt, sampled together: from a file with decid.read(), or from samples."""

    def __init__(self, sway: ArrayLike, rate: float, unit: str, *, tilt: Optional[ArrayLike] = None, tilt_unit: Optional[str] = None,
                 invert_sway: bool = False, invert_tilt: bool = False, mean_is_upright: bool = False) -> None:
        """Copies sway (samples,) of the body's centre of mass, 0 upright; rate: Hz; unit: "deg", "rad" or "mrad".

        tilt: (samples,), of the platform, measured with the sway. It determines where the protocol starts; decid compares its course,
        sign and size with the protocol's. tilt_unit: None is the sway's unit. invert_sway, invert_tilt: True if positive means against
        the protocol's direction. mean_is_upright: True if detrend will subtract the sensor's offset: decid then judges the size of the
        sway from its mean."""
        if unit is None:
            raise _error("setting_missing", "unit", "is not given", 'give "deg", "rad" or "mrad"')
        samples = numbers_of(sway, "sway")
        if samples.ndim != 1:
            raise _error("size_mismatch", "sway", f"has the shape {samples.shape}", "give an array of one dimension, a value per sample")
        tilt_samples = None if tilt is None else numbers_of(tilt, "tilt")
        if tilt_samples is not None and tilt_samples.shape != samples.shape:
            raise _error("size_mismatch", "tilt", f"has the shape {tilt_samples.shape}, the sway {samples.shape}", "give signals that were sampled together")
        self._handle = _decid.recording_of(samples, positive_or_0(rate, "rate", "Hz"), _angle_of(unit, "unit"), tilt_samples,
                                           _angle_of(tilt_unit, "tilt_unit"), flag(invert_sway, "invert_sway"), flag(invert_tilt, "invert_tilt"),
                                           flag(mean_is_upright, "mean_is_upright"))

    @property
    def sway(self) -> np.ndarray:
        """The sway in rad: (samples,), read-only."""
        return self._handle.sway

    @property
    def tilt(self) -> Optional[np.ndarray]:
        """The platform's tilt in rad: (samples,); None if it was not read."""
        return self._handle.tilt

    @property
    def rate(self) -> float:
        """The sample rate in Hz."""
        return self._handle.rate_hz

    @property
    def time(self) -> np.ndarray:
        """The time in s, 0 at the first sample: (samples,)."""
        return np.arange(len(self.sway)) / self.rate

    @property
    def column(self) -> str:
        """The name of the sway's column; empty for samples."""
        return self._handle.column

    @property
    def warnings(self) -> tuple[Notice, ...]:
        return tuple(Notice(*notice) for notice in self._handle.warnings)

    def __repr__(self) -> str:
        column = f" of {self.column!r}" if self.column else ""
        return f"Recording({len(self.sway)} samples{column} at {self.rate:g} Hz)"


def read(path: Path, column: Union[str, int, None] = None, unit: Optional[str] = None, rate: Optional[float] = None,
         fill_gaps: float = 0.0, tilt_column: Union[str, int, None] = None, tilt_unit: Optional[str] = None,
         invert_sway: bool = False, invert_tilt: bool = False, *, skip_lines: Optional[int] = None,
         com_height: Optional[float] = None, leg: Union[str, int, None] = None, trunk: Union[str, int, None] = None,
         hip: Union[str, int, None] = None, shoulder: Union[str, int, None] = None, ankle: Union[str, int, None] = None,
         height: Optional[float] = None, section: Union[str, int, None] = None, trial_column: Union[str, int, None] = None,
         trial: Union[str, int, None] = None, missing: Optional[float] = None, mean_is_upright: bool = False) -> Recording:
    """Reads a CSV, MAT, C3D or .xlsx file.

    column, tilt_column: a name, or a number from 1; None: found by name; tilt_column "none": no tilt is read.
    unit, tilt_unit: "deg", "rad" or "mrad"; None: from the column's name, else degrees; the tilt's is `unit` before degrees.
    skip_lines: the number of lines above the table of a text file; None: found. section: the table to read in a text file
    of several, by its name or its number from 1, or the sheet of a workbook by its name.
    trial_column: the column that distinguishes the recordings of a file, several joined by commas, or an array of a
    MAT-file; trial: the recording to read, a name of trial_names(). trial_column "none": all rows are one recording; None:
    files of several recordings are errors.
    Sources of the sway instead of `column`: leg and trunk, columns of angles in space; hip and shoulder, columns of
    positions, with the person's height in m; or com_height, the height in m above the ankles of the position in `column`.
    Positions count from the column ankle; without it their means are upright. Their unit may be "mm", "cm" or "m".
    rate: Hz, instead of the column of time. fill_gaps: longest gap in seconds to interpolate.
    missing: a number that marks a missing value, in addition to the usual ones.
    invert_sway, invert_tilt, mean_is_upright: as for Recording.
    If a centre of mass has several axes (COM_x, COM_y), `.sway` is the first; identify and fit use the one that follows
    the tilt."""
    longest = number(fill_gaps, "fill_gaps")
    if not 0.0 <= longest <= 60.0:
        raise _error("setting_out_of_range", "fill_gaps", f"is {longest:g} s", "give 0 to 60 s")
    recording = Recording.__new__(Recording)
    recording._handle = _decid.read_recording(
        path_of(path, "path"), _text_of(column, "column"), _number_of(_UNITS, unit, "unit"), positive_or_0(rate, "rate", "Hz"),
        longest, _text_of(tilt_column, "tilt_column"), _angle_of(tilt_unit, "tilt_unit"),
        flag(invert_sway, "invert_sway"), flag(invert_tilt, "invert_tilt"),
        -1 if skip_lines is None else whole(skip_lines, "skip_lines", 0), positive_or_0(com_height, "com_height", "m"),
        positive_or_0(height, "height", "m"),
        (_text_of(leg, "leg"), _text_of(trunk, "trunk"), _text_of(hip, "hip"), _text_of(shoulder, "shoulder"), _text_of(ankle, "ankle")),
        _text_of(section, "section"), _text_of(trial_column, "trial_column"), _text_of(trial, "trial"), None if missing is None else number(missing, "missing"),
        flag(mean_is_upright, "mean_is_upright"))
    return recording


def trial_names(path: Path, trial_column: Union[str, int], *, skip_lines: Optional[int] = None,
                section: Union[str, int, None] = None) -> List[str]:
    """Returns the names of the recordings in a file of several, for read(), in the order in which they begin.

        for name in decid.trial_names("long.csv", "subject,trial"):
            decid.identify(decid.read("long.csv", trial_column="subject,trial", trial=name))"""
    return _decid.trial_names(path_of(path, "path"), _text_of(trial_column, "trial_column"), -1 if skip_lines is None else whole(skip_lines, "skip_lines", 0),
                              _text_of(section, "section"))


@dataclass(frozen=True, eq=False)
class Trials:
    """Simulated trials with known parameters."""
    sway: np.ndarray = field(repr=False)  #: rad: (samples,), or (trials, samples); NaN from where a body falls
    tilt: np.ndarray = field(repr=False)  #: of the platform, rad: (samples,)
    rate: float  #: Hz
    parameters: dict[str, Any]  #: SI units: numbers, or arrays (trials,)
    valid: np.ndarray  #: True if the body stood: () or (trials,)

    @property
    def time(self) -> np.ndarray:
        """The time in s: (samples,)."""
        return np.arange(self.sway.shape[-1]) / self.rate


def simulate(protocol: Union[Protocol, Path] = "default", seed: int = 1, allow_falls: bool = False,
             controller: Optional[str] = None, **parameters: ArrayLike) -> Trials:
    """Simulates recordings of the single pendulum, with the bits of `decid simulate --seed`.

    controller: a name of controllers(), for a protocol given by name or path; None: the protocol's.

    parameters: Kp=900, delay=0.1, ..., SI units; the others have the middle of their range. Arrays (trials,) make as many
    trials, trial i with the noise of seed + i. A body that falls raises decid.Error unless allow_falls."""
    if controller is not None and isinstance(protocol, Protocol):
        raise _error("setting_conflict", "controller", "comes from the protocol", "leave it out, or give the protocol's name or path")
    played = as_protocol(protocol) if controller is None else Protocol(protocol, controller)
    infos = played.parameters
    unknown = set(parameters) - {info.name for info in infos}
    if unknown:
        raise _error("setting_unknown", "simulate", f"there is no parameter {sorted(unknown)[0]!r}",
                     "give " + ", ".join(info.name for info in infos))
    given = [numbers_of(parameters.get(info.name, 0.5 * (info.low + info.high)), info.name) for info in infos]
    try:
        values = np.broadcast_arrays(*given)
    except ValueError:
        shapes = ", ".join(f"{info.name} {array.shape}" for info, array in zip(infos, given) if array.ndim)
        raise _error("size_mismatch", "simulate", f"the parameters have other shapes: {shapes}",
                     "give numbers, or arrays of one length") from None
    if values[0].ndim > 1:
        raise _error("size_mismatch", "simulate", "the parameters have two dimensions or more", "give numbers, or arrays of one dimension")
    table = np.stack([np.atleast_1d(value) for value in values], axis=1)
    sway, valid = _decid.simulate(played._handle, table, seed_of(seed))
    valid = valid.astype(bool)
    if not flag(allow_falls, "allow_falls") and not valid.all():
        raise _error("body_falls", "simulate", f"the body of trial {int(np.argmin(valid))} falls",
                     "raise Kp or Kd, lower Nv, the delay or the tilt, or give allow_falls=True")
    one = values[0].ndim == 0
    used = {info.name: float(value) if one else np.array(value) for info, value in zip(infos, values)}
    return Trials(sway[0] if one else sway, played.tilt, played.rate, used, valid[0] if one else valid)


_OF_SAMPLES = ("tilt", "tilt_unit", "invert_sway", "invert_tilt")


def _recording_of(recording: Union[Recording, Trials, Path, ArrayLike], rate: Optional[float],
                  unit: Optional[str], reading: Mapping[str, Any], height: Optional[float] = None,
                  detrend: str = "none") -> Recording:
    if "mean_is_upright" in reading:
        raise _error("setting_conflict", "mean_is_upright", "follows from detrend", "leave it out")
    upright = detrend != "none"
    if isinstance(recording, (str, bytes, os.PathLike)):
        if "tilt" in reading:
            raise _error("setting_conflict", "tilt", "is for samples", "name the file's column with tilt_column")
        of_body = {"height": height} if {"com_height", "hip", "shoulder"} & set(reading) else {}
        return read(recording, rate=rate, unit=unit, mean_is_upright=upright, **of_body, **reading)
    if isinstance(recording, (Recording, Trials)):
        if reading:
            raise _error("setting_conflict", ", ".join(reading), "is for files and samples", "leave it out")
        if rate is not None or unit is not None:
            raise _error("setting_conflict", "rate, unit", "are known of this recording", "leave them out")
        return recording if isinstance(recording, Recording) else Recording(recording.sway, recording.rate, "rad")
    if rate is None or unit is None:
        raise _error("setting_missing", "rate, unit", "samples do not say theirs", 'give both, such as rate=100, unit="deg"')
    unknown = [name for name in reading if name not in _OF_SAMPLES and name not in signature(read).parameters]
    if unknown:
        raise TypeError(f"unexpected keyword argument {unknown[0]!r}")
    of_files = [name for name in reading if name not in _OF_SAMPLES]
    if of_files:
        raise _error("setting_conflict", ", ".join(of_files), "is for files", "leave it out")
    return Recording(recording, rate, unit, mean_is_upright=upright, **reading)


def identify(recording: Union[Recording, Trials, Path, ArrayLike], rate: Optional[float] = None,
             unit: Optional[str] = None, *, mass: Optional[float] = None, height: Optional[float] = None,
             begin: Optional[float] = None, detrend: str = "none",
             model: Union[Model, Path, None] = None, **reading: Any) -> Result:
    """Estimates the parameters with a model's network, in milliseconds; same bits as `decid identify`.

    recording: samples (samples,) with their rate in Hz and unit, "deg", "rad" or "mrad"; a file; a Recording; or Trials.
    mass, height: of the person, kg and m; None for both: the protocol's body. read() also uses height, for com_height, hip and shoulder.
    begin: the protocol's start in s after the first sample; None: from the measured tilt, else 0.
    detrend: subtract the mean of whole cycles ("offset"), a line ("linear") or nothing ("none"). model: None is the built-in
    one. reading: other arguments of read() for a file, such as fill_gaps=0.4, or of Recording() for samples, such as
    tilt=platform."""
    of = as_model(model)
    raw = _decid.identify(of._handle, _recording_of(recording, rate, unit, reading, height, detrend)._handle, *body_of(mass, height),
                          number_or(begin, "begin", math.nan), _number_of(_DETREND, detrend, "detrend"))
    return result_of(raw)


def _priors_of(ranges: Optional[Mapping[str, Tuple[float, float]]],
               priors: Optional[Mapping[str, Tuple[float, float]]]) -> List[Tuple[str, float, float, float, float]]:
    """Name, low, high, mean and sd of each parameter of either; NaN: none."""
    limits, normal = pairs_of(ranges, "ranges", "low and high"), pairs_of(priors, "priors", "mean and standard deviation")
    none = (math.nan, math.nan)
    return [(name, *limits.get(name, none), *normal.get(name, none)) for name in dict.fromkeys([*limits, *normal])]


def _list_of(names: Union[str, Iterable[str], None], where: str) -> Optional[str]:
    """Names separated by commas, as C has them; None for none."""
    if names is None or isinstance(names, str):
        return words(names or "", where) or None
    if not isinstance(names, Iterable):
        raise _error("setting_malformed", where, f"is {names!r}", "give a list of texts")
    return ",".join(words(name, where) for name in names) or None


def fit(recording: Union[Recording, Trials, Path, ArrayLike], rate: Optional[float] = None, unit: Optional[str] = None, *,
        mass: Optional[float] = None, height: Optional[float] = None, begin: Optional[float] = None,
        detrend: str = "none", model: Union[Model, Path, None] = None, protocol: Union[Protocol, Path, None] = None,
        prior_start: float = 0.1, prior_gain: float = 0.06, prior_noise: float = 0.02,
        ranges: Optional[Mapping[str, Tuple[float, float]]] = None,
        priors: Optional[Mapping[str, Tuple[float, float]]] = None, moved_before: bool = False, max_draws: int = 160,
        seed: int = 1, controllers: Union[str, Iterable[str], None] = None,
        progress: Optional[Callable[[float, str], object]] = None, **reading: Any) -> Fit:
    """Draws from the posterior, in seconds to minutes; same bits as `decid fit`. Arguments of identify(), and:

    protocol: the protocol played; None: the model's. prior_start: the recording starts at most this many s before or after
    the protocol. prior_gain: standard deviation of the logarithm of recorded over true sway. prior_noise: centre of the
    measurement noise's prior in degrees, two thirds within a factor of 20. ranges: where parameters may lie, {"delay": (0.05,
    0.2)}; priors: normal distributions within the ranges, mean and standard deviation, {"delay": (0.12, 0.02)}; both in the
    units of Result.parameters, or over the body's m g h, {"Kp/mgh": (1.0, 0.2)}. moved_before: True if the platform played the cycle's end before the recording. max_draws: of
    each chain. progress(done, stage): gets the fraction done, 0 to 1; its exceptions end the fit.

    controllers: names of controllers(), each of which is fitted; Fit.comparison compares them, and the parameters are the
    first one's. None: the protocol's. A controller that the protocol names must be among them. ranges and priors act on the
    controllers that have the parameter.

        fit = decid.fit("recording.csv", controllers=["dec", "dec2015", "ic"])
        fit.comparison["ic"].difference, fit.comparison["ic"].difference_standard_error     # nats"""
    of = as_model(model)
    played = None if protocol is None else as_protocol(protocol)
    raw = _decid.fit(of._handle, _recording_of(recording, rate, unit, reading, height, detrend)._handle, *body_of(mass, height),
                     number_or(begin, "begin", math.nan), _number_of(_DETREND, detrend, "detrend"),
                     None if played is None else played._handle, number(prior_start, "prior_start"),
                     number(prior_gain, "prior_gain"), number(prior_noise, "prior_noise"), whole(max_draws, "max_draws", 8),
                     seed_of(seed), flag(moved_before, "moved_before"), _priors_of(ranges, priors),
                     _list_of(controllers, "controllers"), function_or_none(progress, "progress"))
    found = result_of(raw)
    assert isinstance(found, Fit)
    return found


def study(sheet: Path, *, group: bool = False, within: Union[str, Sequence[str]] = (),
          covariates: Union[str, Sequence[str]] = (), fit: bool = False, joint: Optional[str] = None,
          free: Optional[str] = None, model: Union[Model, Path, None] = None, max_draws: int = 160, seed: int = 1,
          controllers: Union[str, Iterable[str], None] = None, progress: Optional[Callable[[float, str], object]] = None) -> Study:
    """Estimates all recordings of a study's sheet, and compares its participants: `decid identify --study`, or with fit=True
    `decid fit --study`, each recording with its own body, protocol and reading options.

        study = decid.study("participants.tsv", group=True, within=["session"], covariates=["age"])

    group: True compares the groups in the sheet's column "group". within: "session", "condition" or both, to compare within
    participants. covariates: columns of numbers, also "weight" (kg) and "height" (m). joint: fit recordings together that have
    the same text in this column, such as "participant_id". free: parameters that then differ between the texts of another
    column, such as "theta,Nv:condition". max_draws, seed, controllers, progress: as in fit(), for fit=True; several controllers
    do not go with joint."""
    text = _decid.study(as_model(model)._handle, path_of(sheet, "sheet"), flag(group, "group"), _list_of(within, "within"),
                        _list_of(covariates, "covariates"), flag(fit, "fit"), words_or_none(joint, "joint"), words_or_none(free, "free"),
                        whole(max_draws, "max_draws", 8), seed_of(seed), _list_of(controllers, "controllers"), function_or_none(progress, "progress"))
    return Study(text)


class Dataset:
    """Simulated trials with known parameters, in memory or on disk: Dataset.make(), Dataset.read()."""

    def __init__(self, handle: _decid.Dataset) -> None:
        self._handle = handle

    @classmethod
    def make(cls, count: int, base: int = 0, seed: int = 1, protocol: Union[Protocol, Path] = "default",
             path: Optional[Path] = None, progress: Optional[Callable[[float, str], object]] = None) -> Dataset:
        """Simulates valid trials, as `decid dataset` does. base: number of trials drawn from the ranges; the rest are
        children of large sways; 0: all. path: write to this .npz file, for sets that memory does not hold."""
        return cls(_decid.make_dataset(as_protocol(protocol)._handle, whole(count, "count"), whole(base, "base"), seed_of(seed),
                                       path_or_none(path, "path"), function_or_none(progress, "progress")))

    @classmethod
    def read(cls, path: Path) -> Dataset:
        """Opens an .npz file that decid has written. Its sway stays on disk."""
        return cls(_decid.read_dataset(path_of(path, "path")))

    def write(self, path: Path) -> None:
        """Writes a data set in memory as an .npz file, completely or not at all; numpy.load opens it."""
        self._handle.write(path_of(path, "path"))

    def __len__(self) -> int:
        return self._handle.trials

    @property
    def protocol(self) -> Protocol:
        return Protocol._of(self._handle.protocol)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the parameters' columns."""
        return tuple(info.name for info in self.protocol.parameters)

    @property
    def sway(self) -> np.ndarray:
        """The sway in rad: (trials, samples), float32, read-only; each access reads a data set on disk again."""
        return self._handle.sway

    @property
    def parameters(self) -> np.ndarray:
        """The parameters in SI units: (trials, parameters), read-only, in the order of names."""
        return self._handle.parameters

    @property
    def group(self) -> np.ndarray:
        """The number of the trial's parent, its own if it has none: (trials,)."""
        return self._handle.group

    @property
    def split(self) -> np.ndarray:
        """0 training, 1 validation: (trials,)."""
        return self._handle.split

    def __repr__(self) -> str:
        return f"Dataset({len(self)} trials of {self.protocol!r})"


def evaluate(model: Union[Model, Path, None], dataset: Union[Dataset, Path], split: str = "all") -> Evaluation:
    """The model's error, as `decid evaluate` measures it. split: "all", "training" or "validation". Trials that the model
    was trained on are refused, but either half of its own data set may be asked for."""
    of = as_model(model)
    data = dataset if isinstance(dataset, Dataset) else Dataset.read(dataset)
    found = _decid.evaluate(of._handle, data._handle, _number_of(_SPLITS, split, "split"))
    names = (info.name for info in of.protocol.parameters)
    return Evaluation(**{**found, "mse_per_parameter": dict(zip(names, found["mse_per_parameter"]))})


@dataclass(frozen=True)
class Epoch:
    """An epoch of a training, over."""
    epoch: int  #: from 1
    epochs: int
    training_mse: float  #: of z-scored parameters
    validation_mse: float
    learning_rate: float


def _json_of(image: Any) -> str:
    try:
        return json.dumps(image)
    except (TypeError, ValueError):
        raise _error("setting_malformed", "image", f"is {image!r}", "give a dictionary of numbers and texts") from None


def train(data: Union[Dataset, Protocol, Path], *, preset: str = "best", architecture: Optional[str] = None,
          head: Optional[str] = None, image: Optional[dict[str, Any]] = None, schedule: Optional[str] = None,
          epochs: Optional[int] = None, batch: Optional[int] = None, learning_rate: Optional[float] = None,
          momentum: Optional[float] = None, weight_decay: Optional[float] = None, seed: int = 1, patience: int = 0,
          stream_trials: int = 25600, validation_trials: int = 1000,
          on_batch: Optional[Callable[[int, int, int], object]] = None,
          on_epoch: Optional[Callable[[Epoch], object]] = None) -> Model:
    """Trains a model, with the weights of `decid train`, which also leaves checkpoints: use it for long trainings.

    data: a Dataset or its .npz file, or a protocol of which new trials are simulated in every epoch: stream_trials of them, and
    validation_trials for validation. None is the preset's (docs/guide/models.md). architecture: layers, one a line; image:
    settings as `decid info --json` shows them. patience: epochs without improvement before it stops and keeps the best.
    on_batch(epoch, done, trials), on_epoch(Epoch): called on the way; what they raise ends the training."""
    def progress(epoch: int, all_epochs: int, done: int, trials: int, is_over: bool, training_mse: float,
                 validation_mse: float, rate: float) -> None:
        if is_over and on_epoch is not None:
            on_epoch(Epoch(epoch, all_epochs, training_mse, validation_mse, rate))
        if not is_over and on_batch is not None:
            on_batch(epoch, done, trials)

    def or_presets(value: Any, presets: Any, least: float, name: str) -> Any:
        if value is None:
            return presets
        value = whole(value, name) if isinstance(presets, int) else number(value, name)
        if value < least:  # 0 and -1 mean the preset's in C
            raise _error("setting_out_of_range", name, f"is {value}", f"give {least} or more")
        return value

    function_or_none(on_batch, "on_batch")
    function_or_none(on_epoch, "on_epoch")
    if isinstance(data, (str, bytes, os.PathLike)) and path_of(data, "data").endswith(b".npz"):
        data = Dataset.read(data)
    dataset = data._handle if isinstance(data, Dataset) else None
    protocol = None if isinstance(data, Dataset) else as_protocol(data)._handle
    return Model._of(_decid.train(
        dataset, protocol, words(preset, "preset"), words_or_none(architecture, "architecture"), words_or_none(head, "head"),
        None if image is None else _json_of(image), words_or_none(schedule, "schedule"),
        or_presets(epochs, 0, 1, "epochs"), or_presets(batch, 0, 1, "batch"),
        or_presets(learning_rate, 0.0, 1e-12, "learning_rate"), or_presets(momentum, -1.0, 0.0, "momentum"),
        or_presets(weight_decay, -1.0, 0.0, "weight_decay"), seed_of(seed), whole(patience, "patience"),
        whole(stream_trials, "stream_trials"), whole(validation_trials, "validation_trials"), progress))
