"""Results of identification, fits and evaluation: plain values that print well. None is an unknown value."""
from __future__ import annotations

import html
import json
from dataclasses import asdict, dataclass
from typing import Any, Iterator, Optional

import numpy as np

from . import _decid, _tables

Interval = tuple[float, float]


@dataclass(frozen=True)
class Parameter:
    """A parameter, or another quantity of a fit, in SI units unless its name says otherwise."""
    name: str
    unit: str  #: "1" for a plain number
    low: Optional[float]  #: the range that the model was trained on
    high: Optional[float]
    value: float
    sd: Optional[float]  #: standard deviation
    interval50: Optional[Interval]
    interval90: Optional[Interval]
    normalized: Optional[float]  #: value / (m g h), where that has a meaning
    normalized_interval90: Optional[Interval]
    rhat: Optional[float] = None  #: of a fit
    effective_draws: Optional[float] = None

    def __str__(self) -> str:
        unit = "" if self.unit == "1" else " " + self.unit
        within = "" if self.interval90 is None else f" (90%: {_tables.between(self.interval90)})"
        return f"{self.name} = {self.value:.5g}{unit}{within}"


@dataclass(frozen=True)
class Notice:
    """An assumption, an anomaly, or the reason why a result is invalid. Codes: docs/guide/warnings.md."""
    severity: str  #: "info", "caution" or "invalid"
    code: str
    text: str


@dataclass(frozen=True)
class TiltMatch:
    """Compares the measured tilt of the platform with the protocol's."""
    delay_s: float  #: time in the recording at which the protocol starts
    correlation: float
    gain: Optional[float]  #: measured over the protocol's size; None: the tilt's column has no unit


@dataclass(frozen=True)
class Body:
    """The body to which stiffness and damping belong."""
    mass_kg: float  #: above the ankles
    com_height_m: float
    inertia_kgm2: float  #: about the ankles
    assumed: bool  #: True if no body was given

    @property
    def mgh(self) -> float:
        """Gravitational stiffness, N m/rad."""
        return self.mass_kg * 9.81 * self.com_height_m


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """A model's estimates for a recording. result["Kp"] is a Parameter; iteration and `in` are over parameters' names."""
    parameters: dict[str, Parameter]
    trust: str  #: "usable", "caution" or "not usable"
    warnings: tuple[Notice, ...]  #: the most severe first
    rms_residual_deg: Optional[float]  #: of the noise-free trial of these parameters, against the recording
    variance_accounted_for: Optional[float]
    peak_to_peak_deg: float
    response_ratio: Optional[float]  #: stimulus response ratio: 1 the whole response, 0 none
    ood_score: Optional[float]  #: out-of-distribution score; above 1: unlike the training trials
    tilt: Optional[TiltMatch]
    body: Body
    correlations: np.ndarray  #: (parameters, parameters); a fit's: of all quantities; NaN unknown
    sway: np.ndarray  #: the recording at the protocol's rate and length, rad: (samples,), float32
    fitted: np.ndarray  #: the noise-free trial, rad; shorter if the body falls

    def __getitem__(self, name: str) -> Parameter:
        if name not in self.parameters:
            raise KeyError(f"there is no parameter {name!r}: give {', '.join(self.parameters)}")
        return self.parameters[name]

    def __contains__(self, name: object) -> bool:
        return name in self.parameters

    def __iter__(self) -> Iterator[str]:
        return iter(self.parameters)

    def __len__(self) -> int:
        return len(self.parameters)

    def rows(self) -> list[dict[str, Any]]:
        """Returns one dict per parameter, with the ends of intervals as separate numbers: for csv, json, pandas."""
        def row(parameter: Parameter) -> dict[str, Any]:
            flat: dict[str, Any] = {}
            for key, value in asdict(parameter).items():
                if key.endswith(("interval50", "interval90")):
                    flat[key + "_low"], flat[key + "_high"] = (None, None) if value is None else value
                else:
                    flat[key] = value
            return flat
        return [row(parameter) for parameter in self._shown().values()]

    def to_frame(self) -> Any:
        """A pandas.DataFrame, one row per parameter; needs pandas."""
        return _tables.frame(self.rows(), "name")

    def _shown(self) -> dict[str, Parameter]:
        return self.parameters

    def __repr__(self) -> str:
        lines = [self.trust + "".join(f"; {notice.text}" for notice in self.warnings if notice.severity != "info")]
        for p in self._shown().values():
            lines.append(f"{p.name:<16} {p.value:12.5g}  {_tables.between(p.interval90):<24} {'' if p.unit == '1' else p.unit}")
        if self.body.assumed:
            lines.append(self._assumed())
        return "\n".join(lines)

    def _assumed(self) -> str:
        return f"Body (assumed): {self.body.mass_kg:.1f} kg above the ankles; give the person's mass= and height="

    def _repr_html_(self) -> str:
        rows = []
        for p in self._shown().values():
            known = p.low is not None and p.high is not None and p.interval90 is not None
            rows.append((p.name, _tables.number(p.value), _tables.between(p.interval90), "" if p.unit == "1" else p.unit,
                         _tables.number(p.normalized),
                         _tables.interval_bar(p.low, p.high, p.interval90, p.value) if known else ""))
        notices = "".join(f"<li>{html.escape(notice.severity)}: {html.escape(notice.text)}</li>" for notice in self.warnings)
        heading = ("", "value", "90% interval", "unit", "relative to gravity", "within the limits (not a normal range)")
        table = _tables.html_table(heading, rows)
        table += f"<p>{html.escape(self._assumed())}</p>" if self.body.assumed else ""
        return f"<p><b>{html.escape(self.trust)}</b></p>{table}" + (f"<ul>{notices}</ul>" if notices else "")


@dataclass(frozen=True)
class Sampling:
    """How a fit's chains ran."""
    chains: int
    draws: int  #: of all chains
    agreed: bool  #: every R-hat is at most 1.05, and every quantity has 100 effective draws
    from_network: bool  #: True if the chains are far apart, and the values are the network's
    divergences: int
    samples_noise_deg: float  #: white measurement noise, by the power above 2 Hz
    seconds: float


@dataclass(frozen=True)
class ComparedController:
    """A controller among those that a fit compares, by how well it predicts each block of the recording from all others."""
    controller: str
    log_predictive_density: float  #: leave-one-out, of the recording, nats
    difference: float  #: of it to the largest one, nats: 0 or below; below two standard errors it decides nothing
    difference_standard_error: float  #: nats; 0 for the controller with the largest density
    weight: float  #: stacking: the mixture of the controllers with these weights predicts best; they add up to 1
    comparable: bool  #: False: its chains are far apart or it has an invalid warning; ignore its numbers


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Result):
    """The posterior of a recording: a Result whose intervals are those of the draws."""
    quantities: dict[str, Parameter]  #: sensor_noise_deg, start_s and gain
    draws: dict[str, np.ndarray]  #: of parameters and quantities, chain by chain: (draws,)
    sampling: Sampling
    comparison: dict[str, ComparedController]  #: by the controllers' names, in the order of fit(); empty for one

    def _shown(self) -> dict[str, Parameter]:
        return {**self.parameters, **self.quantities}

    def draws_frame(self) -> Any:
        """A pandas.DataFrame, one row per draw, with its chain; needs pandas."""
        per_chain = self.sampling.draws // self.sampling.chains
        chain = np.arange(self.sampling.draws) // per_chain
        import pandas
        return pandas.DataFrame({"chain": chain, **self.draws})


class Study:
    """The results of a study, as the program's JSON has them (docs/guide/results.md, docs/guide/groups.md)."""

    def __init__(self, text: str) -> None:
        self.text = text  #: the JSON, which `decid rerun` reads when it is saved
        self.json: dict[str, Any] = json.loads(text)

    @property
    def recordings(self) -> list[dict[str, Any]]:
        """Each recording's file, columns of the sheet, parameters, trust and warnings, or its error."""
        return self.json["recordings"]

    @property
    def hierarchical(self) -> Optional[dict[str, Any]]:
        """The hierarchical model: groups, comparisons, interactions, covariates, changes; None if it has too few people."""
        return self.json.get("hierarchical")

    @property
    def comparisons(self) -> list[dict[str, Any]]:
        """Each pair of groups by the t-test: names, people, and each parameter's difference; empty if none is compared."""
        return self.json.get("comparisons") or []

    @property
    def groups(self) -> Optional[dict[str, Any]]:
        """The same as `hierarchical`, not the JSON's `groups`: these are the t-test's, json["groups"]."""
        return self.hierarchical

    def rows(self) -> list[dict[str, Any]]:
        """Returns one dict per recording and parameter, with the columns of the sheet; one dict for a recording with an error."""
        rows = []
        for recording in self.recordings:
            common = {key: recording.get(key) for key in ("file", "participant_id", "session", "group", "condition")}
            common.update(recording.get("columns", {}), trust=recording.get("trust"), error=recording.get("error"))
            for of in recording.get("parameters", [{}]):
                low, high = of.get("interval90") or (None, None)
                rows.append({**common, "parameter": of.get("name"), "unit": of.get("unit"), "value": of.get("value"),
                             "sd": of.get("sd"), "low90": low, "high90": high})
        return rows

    def to_frame(self) -> Any:
        """A pandas.DataFrame, one row per recording and parameter; needs pandas."""
        import pandas
        return pandas.DataFrame(self.rows())

    def __repr__(self) -> str:
        failed = sum("error" in recording for recording in self.recordings)
        return f"Study({len(self.recordings)} recordings, {failed} with an error)"


@dataclass(frozen=True)
class Evaluation:
    """A model's error on trials of known parameters, z-scored: guessing the mean has an error of 1."""
    trials: int
    mse: float
    matlab_loss: float  #: MATLAB's regression loss: half the sum over the parameters
    mse_per_parameter: dict[str, float]
    coverage50: Optional[float]  #: fraction of the true values in the intervals
    coverage90: Optional[float]
    log_score: Optional[float]  #: nats per parameter; 0: only the ranges are known


def result_of(raw: _decid.Result) -> Result:
    """A Result, or a Fit if it is one."""
    figures = raw.figures
    quantities = {of["name"]: Parameter(**of) for of in raw.quantities}
    names = list(quantities)
    parameters = raw.parameters
    delay = figures["tilt_delay_s"]
    common: dict[str, Any] = {
        "parameters": {name: quantities[name] for name in names[:parameters]},
        "trust": raw.trust,
        "warnings": tuple(Notice(*notice) for notice in raw.warnings),
        "tilt": None if delay is None else TiltMatch(delay, figures["tilt_correlation"], figures["tilt_gain"]),
        "body": Body(figures["mass_kg"], figures["com_height_m"], figures["inertia_kgm2"], figures["body_assumed"]),
        "correlations": raw.correlations,
        "sway": raw.sway,
        "fitted": raw.fitted,
    }
    for name in ("rms_residual_deg", "variance_accounted_for", "peak_to_peak_deg", "response_ratio", "ood_score"):
        common[name] = figures[name]
    sampling = raw.sampling
    if sampling is None:
        return Result(**common)
    return Fit(quantities={name: quantities[name] for name in names[parameters:]}, draws=raw.draws,
               sampling=Sampling(**sampling), comparison={of["controller"]: ComparedController(**of) for of in raw.controllers},
               **common)
