"""Neural networks of decid's own engine, with NumPy arrays:

    import decid.nn as nn
    net = nn.Network((1, 28, 28), "conv 32 3x3 pad 1; batchnorm; relu; maxpool 2; fc 10")
    log = net.fit(images, labels, loss="cross-entropy", epochs=5)
    scores = net.predict(others)
    net.save("net.safetensors")

Arrays have a sample along the first axis and become float32. Behind it inputs have the network's input_shape, where
axes of length 1 may be left out, or are flat. Equal arguments give equal bits, for any number of threads.
docs/guide/engine.md lists layers, losses, optimisers and options. Bad input raises decid.Error.

Threads may use one network at once for predictions and files. While fit() changes a network, its other calls raise
decid.Error; only the callback of fit() may read it. Different networks are independent.
"""
from dataclasses import dataclass
from os import PathLike, fspath
from types import MappingProxyType
from typing import Any, Callable, Mapping, Optional, Union

import numpy as np

from . import _nn
from ._checks import error, number, numbers_of, seed_of, whole
from ._decid import Error

__all__ = ["Epoch", "Error", "Log", "Network", "load"]


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


class Network:
    """A chain of layers from a text, one layer per line or separated by ';'."""

    def __init__(self, input_shape, architecture: str):
        """input_shape: (channels, rows, columns)."""
        self._network = _nn.Network(tuple(input_shape), architecture)

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
        """Weights and running statistics by name: views, to read and to write, which stay so in fit(). The mapping
        itself takes no array: write values with tensors["layers.0.weight"][:] = array."""
        return MappingProxyType(self._network.tensors)

    def initialise(self, seed: int = 1) -> None:
        """Draws new weights (He et al., 2015). fit() does so for a network whose values are all as new."""
        self._network.initialise(seed_of(seed))

    def fit(self, inputs, targets, *, loss: str = "squared-error", optimiser: str = "adamw", epochs: int = 10,
            batch: int = 64, learning_rate: float = 1e-3, schedule: str = "cosine", warmup_epochs: float = 0,
            clip_norm: float = 0, average: float = 0, frozen_lines: int = 0, validation=0.1, patience: int = 0,
            seed: int = 1, checkpoint: Union[str, PathLike] = "",
            callback: Optional[Callable[[Epoch], None]] = None) -> Log:
        """Trains the network. loss: "squared-error", "cross-entropy", "huber" or "huber DELTA". optimiser: "adamw", "sgd"
        or "nesterov", then settings: "adamw weight_decay 0.05 beta2 0.99", "sgd momentum 0.8". validation: a fraction of
        the samples, or a pair (inputs, targets). checkpoint: a file from which a stopped fit continues; one of another
        network, other arrays or options raises decid.Error, and callbacks are not compared. callback: called after each
        epoch; an exception in it stops the training. nn/fit.hpp explains each option."""
        fraction, samples = 0.0, None
        if isinstance(validation, (tuple, list)):
            if len(validation) != 2:
                raise error("setting_malformed", "validation", f"has {len(validation)} elements", "give a fraction, or inputs and targets")
            samples = _floats(validation[0], "validation inputs"), _floats(validation[1], "validation targets")
        else:
            fraction = number(validation, "validation")
        rows, kept = self._network.fit(
            _floats(inputs, "inputs"), _floats(targets, "targets"), loss, optimiser, whole(epochs, "epochs"),
            whole(batch, "batch"), number(learning_rate, "learning_rate"), schedule, number(warmup_epochs, "warmup_epochs"),
            number(clip_norm, "clip_norm"), number(average, "average"), whole(frozen_lines, "frozen_lines"), fraction,
            samples, whole(patience, "patience"), seed_of(seed), fspath(checkpoint),
            None if callback is None else lambda *row: callback(Epoch(*row)))
        return Log([Epoch(*row) for row in rows], kept)

    def predict(self, inputs) -> np.ndarray:
        """Returns (samples, outputs), or (samples, channels, rows, columns) for outputs in planes."""
        return self._network.predict(_floats(inputs, "inputs"))

    def accuracy(self, inputs, labels) -> float:
        """Returns the fraction of samples whose largest output is that of their label, a class from 0."""
        return self._network.accuracy(_floats(inputs, "inputs"), _floats(labels, "labels"))

    def save(self, path: Union[str, PathLike]) -> None:
        """Writes a safetensors file, which decid info, decid export and nn::read_network read."""
        self._network.save(fspath(path))

    def __reduce__(self) -> tuple[Any, ...]:
        """For pickle and copy: the bytes of the file that save() writes."""
        return _of_bytes, (self._network.to_bytes(),)

    def __repr__(self):
        return f"<decid.nn.Network {self.input_shape} -> {self.output_shape}, {self._network.parameter_count} parameters>"


def _floats(values: Any, name: str) -> np.ndarray:
    return numbers_of(values, name, np.float32)


def _of(handle: _nn.Network) -> Network:
    network = Network.__new__(Network)
    network._network = handle
    return network


def _of_bytes(content: bytes) -> Network:
    return _of(_nn.of_bytes(content))


def load(path: Union[str, PathLike]) -> Network:
    """Returns the network of a file."""
    return _of(_nn.load(fspath(path)))
