"""Neural networks of decid's own engine, with NumPy arrays:

    import decid.nn as nn
    net = nn.Network((1, 28, 28), "conv 32 3x3 pad 1; batchnorm; relu; maxpool 2; fc 10")
    log = net.fit(images, labels, loss="cross-entropy", epochs=5)
    scores = net.predict(others)
    net.save("net.safetensors")

Arrays have a sample along the first axis and become float32. Behind it inputs have the network's input_shape, where
axes of length 1 may be left out, or are flat; so have targets the outputs' shape. Equal arguments give equal bits, for any number of threads.
docs/guide/engine.md lists layers, losses, optimisers and options. Bad input raises decid.Error.

fit() also takes functions of yours: a loss, an Optimiser, Samples that are made as they are needed, a callback. It calls
them one after the other, in its own thread. docs/reference/python-nn.md has an example of each.

Threads may use one network at once for predictions and files. While fit() changes a network, its other calls raise
decid.Error; only the functions that fit() calls may read it. Different networks are independent.
"""
from dataclasses import dataclass
from functools import partial
from os import PathLike
from types import MappingProxyType
from typing import Any, Callable, Mapping, Optional, Tuple, Union

import numpy as np

from . import _nn
from ._checks import error, function, function_or_none, number, numbers_of, path_of, seed_of, whole, words
from ._decid import Error
from ._nn import Random

__all__ = ["Epoch", "Error", "Log", "Network", "Optimiser", "Random", "Samples", "load"]


@dataclass(frozen=True)
class Epoch:
    """One epoch of a training; validation_loss is NaN if no sample was validated."""

    epoch: int
    training_loss: float
    validation_loss: float
    learning_rate: float


@dataclass(frozen=True)
class Log:
    """kept: the epoch whose weights the network has, with patience the best, else the last."""

    epochs: list[Epoch]
    kept: int


@dataclass(frozen=True)
class Samples:
    """Samples that a function makes. load(samples, epoch, random, inputs, targets) gets the numbers of some samples, from
    0, and writes all their values: inputs (samples, channels, rows, columns) and targets (samples, *target_shape). epoch
    counts from 1. random has numbers for augmentation; it is None in validation. target_shape: by default the outputs',
    and () for the loss "cross-entropy"."""

    count: int
    load: Callable[[np.ndarray, int, Optional[Random], np.ndarray, np.ndarray], Any]
    target_shape: Optional[Tuple[int, ...]] = None


@dataclass(frozen=True)
class Optimiser:
    """A step of your own: update(value, gradient, learning_rate, step, *memory) changes the array value in place, for one
    parameter after the other; step counts from 1. memory: the number of arrays of the parameter's shape that fit() keeps
    for update(), 0 before the first step. Checkpoints have them."""

    update: Callable[..., Any]
    memory: int = 0


class Network:
    """A chain of layers from a text, one layer per line or separated by ';'."""

    def __init__(self, input_shape, architecture: str):
        """input_shape: (channels, rows, columns). All weights are 0 until initialise() or fit()."""
        shape = _extents(input_shape, "input_shape", 1)
        if len(shape) != 3:
            raise error("setting_malformed", "input_shape", f"is {input_shape!r}", "give channels, rows and columns")
        self._network = _nn.Network(shape, words(architecture, "architecture"))

    @property
    def input_shape(self) -> tuple[int, int, int]:
        return self._network.input_shape

    @property
    def output_shape(self) -> tuple[int, int, int]:
        return self._network.output_shape

    @property
    def architecture(self) -> str:
        return self._network.architecture

    @property
    def weights_sha256(self) -> str:
        return self._network.weights_sha256

    @property
    def tensors(self) -> Mapping[str, np.ndarray]:
        """Weights and running statistics by name: views, to read and to write, also during fit(). You cannot replace an
        array of this mapping: write values with tensors["layers.0.weight"][:] = array."""
        return MappingProxyType(self._network.tensors)

    def initialise(self, seed: int = 1) -> None:
        """Draws new weights (He et al., 2015). fit() does this for a network that was never trained or changed. Call it before
        you set the weights of some layers: fit() refuses a network in which two layers in a chain are still 0."""
        self._network.initialise(seed_of(seed))

    def fit(self, inputs, targets=None, *, loss: Union[str, Callable[[np.ndarray, np.ndarray], Tuple[Any, Any]]] = "squared-error",
            optimiser: Union[str, Optimiser] = "adamw", epochs: int = 10, batch: int = 64, learning_rate: float = 1e-3,
            schedule: str = "cosine", warmup_epochs: float = 0, clip_norm: float = 0, average: float = 0,
            frozen_lines: int = 0, validation=0.1, patience: int = 0, seed: int = 1, checkpoint: Union[str, bytes, PathLike] = "",
            callback: Optional[Callable[[Epoch], None]] = None) -> Log:
        """Trains the network. inputs and targets: arrays, or Samples and None.

        loss: "squared-error", "cross-entropy", "huber" or "huber DELTA", or a function of a batch's outputs and targets. It
        returns the mean of the samples' losses, or each sample's, and the derivatives of the mean by the outputs.
        optimiser: "adamw", "sgd" or "nesterov", then settings: "adamw weight_decay 0.05 beta2 0.99", "sgd momentum 0.8";
        or an Optimiser. validation: a fraction of the samples, a pair (inputs, targets), or Samples. checkpoint: a file from
        which a stopped fit continues; that of a finished fit replaces the network's weights, and nothing more is trained. One of
        another network, other arrays or options raises decid.Error. Functions are
        compared by their names, functools.partial also by its numbers and texts. callback: called after each epoch. With average
        it gets the averaged network's validation loss, while the network has the last step's weights.
        nn/fit.hpp explains each option.

        An exception of one of these functions ends the training, and fit() raises it. Then the parameters are those of the
        last complete step, not of the best epoch or the average; BatchNorm's statistics may include one more batch."""
        fraction, samples = 0.0, None
        function_or_none(callback, "callback")
        if isinstance(validation, Samples):
            samples = self._samples(validation, None, loss, "validation ")
        elif isinstance(validation, (tuple, list)):
            if len(validation) != 2:
                raise error("setting_malformed", "validation", f"has {len(validation)} elements", "give a fraction, or inputs and targets")
            samples = self._samples(*validation, loss, "validation ")
        else:
            fraction = number(validation, "validation")
        rows, kept = self._network.fit(
            self._samples(inputs, targets, loss, ""), _loss_of(loss), _optimiser_of(optimiser), whole(epochs, "epochs"),
            whole(batch, "batch"), number(learning_rate, "learning_rate"), words(schedule, "schedule"), number(warmup_epochs, "warmup_epochs"),
            number(clip_norm, "clip_norm"), number(average, "average"), whole(frozen_lines, "frozen_lines"), fraction,
            samples, whole(patience, "patience"), seed_of(seed), path_of(checkpoint, "checkpoint"),
            None if callback is None else lambda *row: callback(Epoch(*row)))
        return Log([Epoch(*row) for row in rows], kept)

    def _output_axes(self) -> Tuple[int, ...]:
        """The shape of a sample's outputs in predict()."""
        channels, *plane = self.output_shape
        return (channels,) if plane == [1, 1] else self.output_shape

    def _samples(self, inputs: Any, targets: Any, loss: Any, prefix: str) -> _nn.Samples:
        if not isinstance(inputs, Samples):
            given, wanted = _floats(inputs, prefix + "inputs"), _floats(targets, prefix + "targets")
            self._refuse_other_axes(wanted.shape[1:], loss, prefix + "targets")
            return _nn.Samples(given, wanted)
        if targets is not None:
            raise error("setting_conflict", prefix + "targets", "are given with Samples", "leave them out: load() writes them")
        if inputs.target_shape is None:
            shape = () if loss == "cross-entropy" else self._output_axes()
        else:
            shape = _extents(inputs.target_shape, "target_shape", 0)
            self._refuse_other_axes(shape, loss, "target_shape")
        return _nn.Samples(whole(inputs.count, "count", 1), function(inputs.load, prefix + "samples"), list(shape))

    def _refuse_other_axes(self, shape: Tuple[int, ...], loss: Any, name: str) -> None:
        """Raises an error for targets of decid's own losses whose axes have another order than the outputs'."""
        given, wanted = [[extent for extent in axes if extent != 1] for axes in (shape, self.output_shape)]
        if isinstance(loss, str) and len(wanted) > 1 and len(given) > 1 and given != wanted and np.prod(given) == np.prod(wanted):
            raise error("size_mismatch", name, f"has {tuple(shape)} values per sample", f"give the outputs' {self._output_axes()}, or flat ones")

    def predict(self, inputs) -> np.ndarray:
        """Returns (samples, outputs), or (samples, channels, rows, columns) for outputs in planes."""
        return self._network.predict(_floats(inputs, "inputs"))

    def input_gradient(self, inputs, by_output) -> np.ndarray:
        """Returns the derivatives of (by_output * predict(inputs)).sum() by the inputs, in their shape. by_output: an array of
        the outputs' shape, such as a loss's gradient, or one that broadcasts to it: [0, 1, 0] for output 1 of 3."""
        values, by = _floats(inputs, "inputs"), _floats(by_output, "by_output")
        outputs = (values.shape[0] if values.ndim else 0, *self._output_axes())
        try:
            by = np.broadcast_to(by, outputs)
        except ValueError:
            raise error("size_mismatch", "by_output", f"has the shape {by.shape}", f"give one that broadcasts to {outputs}") from None
        return self._network.input_gradient(values, by)

    def accuracy(self, inputs, labels) -> float:
        """Returns the fraction of samples whose largest output is that of their label, a class from 0."""
        return self._network.accuracy(_floats(inputs, "inputs"), _floats(labels, "labels"))

    def save(self, path: Union[str, bytes, PathLike]) -> None:
        """Writes a safetensors file, which decid info, decid export and nn::read_network read."""
        self._network.save(path_of(path, "path"))

    def __reduce__(self) -> tuple[Any, ...]:
        """For pickle and copy: the bytes of the file that save() writes."""
        return _of_bytes, (self._network.to_bytes(),)

    def __repr__(self):
        return f"<decid.nn.Network {self.input_shape} -> {self.output_shape}, {self._network.parameter_count} parameters>"


def _floats(values: Any, name: str) -> np.ndarray:
    return numbers_of(values, name, np.float32)


def _extents(shape: Any, name: str, least: int) -> Tuple[int, ...]:
    try:
        return tuple(whole(extent, name, least) for extent in shape)
    except TypeError:
        raise error("setting_malformed", name, f"is {shape!r}", "give a tuple of whole numbers") from None


def _name_of(function: Callable[..., Any]) -> str:
    """By which a checkpoint is compared. A functools.partial has its numbers and texts in the name."""
    if isinstance(function, partial):
        given = [*enumerate(function.args), *sorted(function.keywords.items())]
        plain = [(key, value.item() if isinstance(value, np.generic) else value) for key, value in given]
        shown = [f"{key}={value!r}" for key, value in plain if isinstance(value, (str, bool, int, float))]
        return f"{_name_of(function.func)}({', '.join(shown)})"
    named = function if hasattr(function, "__qualname__") else type(function)
    return f"{named.__module__}.{named.__qualname__}"


def _loss_of(loss: Any) -> Any:
    """A name, or a function whose results have the shapes that the engine takes, and its name."""
    if isinstance(loss, str):
        return words(loss, "loss")
    function(loss, "loss")

    def call(outputs: np.ndarray, targets: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
        shape, found = outputs.shape, loss(outputs, targets)
        if not isinstance(found, tuple) or len(found) != 2:
            raise error("setting_malformed", "loss", f"returns a {type(found).__name__}", "return a value and a gradient")
        value, gradient = numbers_of(found[0], "loss"), numbers_of(found[1], "loss")
        if value.shape not in ((), shape[:1]) or gradient.shape != shape:
            raise error("size_mismatch", "loss", f"returns shapes {value.shape} and {gradient.shape} for outputs of {shape}",
                        "return the mean, or a loss of each sample, and a derivative by each output")
        return np.broadcast_to(value, shape[:1]), gradient

    return call, _name_of(loss)


def _optimiser_of(optimiser: Any) -> Any:
    """A name, or a function, its name and the number of arrays that it keeps."""
    if isinstance(optimiser, str):
        return words(optimiser, "optimiser")
    if not isinstance(optimiser, Optimiser):
        raise error("setting_malformed", "optimiser", f"is a {type(optimiser).__name__}", "give a name or an Optimiser")
    return function(optimiser.update, "optimiser"), _name_of(optimiser.update), whole(optimiser.memory, "memory", 0, 1000)


def _of(handle: _nn.Network) -> Network:
    network = Network.__new__(Network)
    network._network = handle
    return network


def _of_bytes(content: bytes) -> Network:
    return _of(_nn.of_bytes(content))


def load(path: Union[str, bytes, PathLike]) -> Network:
    """Returns the network of a file."""
    return _of(_nn.load(path_of(path, "path")))
