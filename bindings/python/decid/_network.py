"""Protocols, which describe an experiment, and models, trained networks."""
from __future__ import annotations

import json
import os
import tempfile
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, Optional, Union

import numpy as np

from . import _decid, _tables
from ._checks import path_of, path_or_none, words_or_none


@dataclass(frozen=True)
class ParameterInfo:
    """A parameter of a protocol's controllers."""
    name: str  #: "Kp_pass"
    unit: str  #: "N m/rad"; "1" for a plain number
    description: str
    low: float  #: the range that trials are drawn from, for the protocol's body
    high: float
    scales_with_mgh: bool  #: value / (m g h) has a meaning


class Protocol:
    """Platform movement, body, controller and recording: "default", "short" or a JSON file."""

    def __init__(self, name_or_path: Union[str, bytes, os.PathLike[str], os.PathLike[bytes]] = "default", controller: Optional[str] = None) -> None:
        """controller: a name of decid.controllers(); None: the protocol's own. It determines the parameters."""
        self._handle = _decid.load_protocol(path_of(name_or_path, "protocol"), words_or_none(controller, "controller"))

    @classmethod
    def _of(cls, handle: _decid.Protocol) -> Protocol:
        made = cls.__new__(cls)
        made._handle = handle
        return made

    @property
    def samples(self) -> int:
        """Samples per trial."""
        return self._handle.samples

    @property
    def rate(self) -> float:
        """The sample rate in Hz."""
        return self._handle.rate_hz

    @property
    def tilt(self) -> np.ndarray:
        """The platform's tilt, rad: (samples,)."""
        return self._handle.tilt

    @property
    def controller(self) -> str:
        """Its name: "dec", the paper's, unless the protocol has another."""
        return self._handle.controller

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        return tuple(ParameterInfo(*info) for info in self._handle.parameters)

    @property
    def settings(self) -> dict[str, Any]:
        """The complete protocol as a dict; docs/reference/protocols.md describes its keys."""
        return json.loads(self._handle.json)

    def __reduce__(self) -> tuple[Any, ...]:
        return _protocol_of_json, (self._handle.json,)

    def __repr__(self) -> str:
        return f"Protocol({self.settings['name']!r}: {self.samples} samples at {self.rate:g} Hz)"


def _protocol_of_json(text: str) -> Protocol:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pickled.json"
        path.write_text(text, encoding="utf-8")
        return Protocol(path)


def as_protocol(protocol: Union[Protocol, str, bytes, os.PathLike[str], os.PathLike[bytes]]) -> Protocol:
    return protocol if isinstance(protocol, Protocol) else Protocol(protocol)


@dataclass(frozen=True)
class Layer:
    """A layer, or several lines of the architecture that are computed as one."""
    text: str  #: "conv 64 3x3 stride 1x1 pad 1x1"
    input_shape: tuple[int, int, int]  #: channels, rows, columns
    output_shape: tuple[int, int, int]
    flops: int  #: of one sample


class Network:
    """A model's layers and weights."""

    def __init__(self, handle: _decid.Model) -> None:
        self._handle = handle

    def __reduce__(self) -> tuple[Any, ...]:
        return _network_of, (Model._of(self._handle),)

    @property
    def layers(self) -> tuple[Layer, ...]:
        return tuple(Layer(*layer) for layer in self._handle.layers)

    @property
    def weights(self) -> dict[str, np.ndarray]:
        """Weights and running statistics by their names in the file, "layers.0.weight": float32, read-only, not copied.
        Convolutions are (out, in, rows, columns), fully connected layers (out, in)."""
        return self._handle.tensors

    def __repr__(self) -> str:
        lines = [f"{layer.text.replace(chr(10), ' + '):<56} {' x '.join(map(str, layer.output_shape))}"
                 for layer in self.layers]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        rows = [(layer.text.replace("\n", " + "), " × ".join(map(str, layer.output_shape)), f"{layer.flops:,}")
                for layer in self.layers]
        return _tables.html_table(("layer", "output", "FLOP"), rows)


class Model:
    """A trained model: of a file that `decid train` or Model.save() wrote, or the built-in one. It does not change, so
    threads may share it."""

    def __init__(self, path: Union[str, bytes, os.PathLike[str], os.PathLike[bytes], None] = None) -> None:
        self._handle = _decid.load_model(path_or_none(path, "path"))

    @classmethod
    def _of(cls, handle: _decid.Model) -> Model:
        made = cls.__new__(cls)
        made._handle = handle
        return made

    @property
    def protocol(self) -> Protocol:
        """The protocol of its training trials, which recordings must play."""
        return Protocol._of(self._handle.protocol)

    @property
    def network(self) -> Network:
        return Network(self._handle)

    @property
    def head(self) -> str:
        """The kind of the outputs: "point", or a distribution, "mixture 2"."""
        return self._handle.head

    @property
    def sha256(self) -> str:
        """SHA-256 of the weights."""
        return self._handle.sha256

    def save(self, path: Union[str, bytes, os.PathLike[str], os.PathLike[bytes]]) -> None:
        """Writes the model file, completely or not at all."""
        self._handle.save(path_of(path, "path"))

    def __reduce__(self) -> tuple[Any, ...]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "pickled.safetensors"
            self.save(path)
            return _model_of_file, (path.read_bytes(),)

    def __repr__(self) -> str:
        return f"Model({self.head}, protocol {self.protocol.settings['name']!r}, SHA-256 {self.sha256[:12]}...)"


def _network_of(model: Model) -> Network:
    return model.network


def _model_of_file(content: bytes) -> Model:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "pickled.safetensors"
        path.write_bytes(content)
        return Model(path)


@lru_cache(maxsize=1)
def built_in() -> Model:
    return Model()


def as_model(model: Union[Model, str, bytes, os.PathLike[str], os.PathLike[bytes], None]) -> Model:
    if model is None:
        return built_in()
    return model if isinstance(model, Model) else Model(model)
