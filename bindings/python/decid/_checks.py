"""Checks of arguments: bad ones raise decid.Error with a code and the argument's name."""
from __future__ import annotations

import operator
import os
from typing import Any, Callable, Mapping, Optional, Tuple

import numpy as np

from . import _decid


def error(code: str, where: str, problem: str, remedy: str) -> _decid.Error:
    made = _decid.Error(f"{where}: {problem}; {remedy}")
    made.code, made.where, made.problem, made.remedy = code, where, problem, remedy
    return made


def _shown(value: Any) -> str:
    try:
        return repr(value)
    except ValueError:  # Python shows no integer of more than 4300 digits
        return "an integer of very many digits"


def numbers_of(values: Any, name: str, dtype: Any = np.float64) -> np.ndarray:
    """An array of real numbers, copied if need be. Masks and imaginary parts would be lost without a word."""
    hidden = int(np.count_nonzero(np.ma.getmaskarray(values))) if np.ma.isMaskedArray(values) else 0
    if hidden:
        raise error("value_missing", name, f"has {hidden} masked samples", "fill them, with numpy.interp say, or give a file and fill_gaps")
    try:
        if np.iscomplexobj(values):
            raise error("value_invalid", name, "is complex", "give real numbers")
        array = np.asarray(values)
        times = array.dtype.kind in "mM" or (array.dtype.kind == "O" and any(isinstance(v, (np.datetime64, np.timedelta64)) for v in array.flat))
        if times:
            raise error("value_invalid", name, "has dates or times", "give numbers")
        return np.asarray(values, dtype=dtype)
    except (TypeError, ValueError, OverflowError) as raised:
        if isinstance(raised, _decid.Error):
            raise
        raise error("value_invalid", name, "is not an array of numbers", "give numbers") from None


def number(value: Any, name: str) -> float:
    """A number; not NaN, which is no value in C."""
    try:
        if isinstance(value, (str, bytes)):
            raise TypeError
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        raise error("setting_malformed", name, f"is {_shown(value)}", "give a number") from None
    if np.isnan(found):
        raise error("setting_out_of_range", name, "is NaN", "give a number")
    return found


def number_or(value: Any, name: str, otherwise: float) -> float:
    """The number, or another one for None."""
    return otherwise if value is None else number(value, name)


def positive_or_0(value: Any, name: str, unit: str) -> float:
    """A number above 0, or 0 for None."""
    found = number_or(value, name, 0.0)
    if value is not None and not 0.0 < found < np.inf:
        raise error("setting_out_of_range", name, f"is {found:g} {unit}", "give a number above 0, or leave it out")
    return found


def whole(value: Any, name: str, low: int = -2**31, high: int = 2**31 - 1) -> int:
    try:
        found = operator.index(value)
    except TypeError:
        raise error("setting_malformed", name, f"is {value!r}", "give a whole number") from None
    if not low <= found <= high:
        raise error("setting_out_of_range", name, f"is {_shown(found)}", f"give a whole number from {low} to {high}")
    return found


def seed_of(value: Any) -> int:
    return whole(value, "seed", 0, 2**64 - 1)


def flag(value: Any, name: str) -> bool:
    """True or False, also NumPy's, 1 or 0; None is False. A text such as "no" would be true."""
    if value is None or isinstance(value, (bool, np.bool_)) or (isinstance(value, (int, np.integer)) and value in (0, 1)):
        return bool(value)
    raise error("setting_malformed", name, f"is {value!r}", "give True or False")


def words(value: Any, name: str) -> str:
    """A text that C can have: without NUL, where it would end, and without single surrogates, which UTF-8 does not have."""
    if not isinstance(value, str):
        raise error("setting_malformed", name, f"is {_shown(value)}", "give a text")
    if "\0" in value or any("\ud800" <= character <= "\udfff" for character in value):
        raise error("setting_malformed", name, f"is {value!r}", "give a text without NUL and surrogates")
    return value


def words_or_none(value: Any, name: str) -> Optional[str]:
    return None if value is None else words(value, name)


def path_of(value: Any, name: str) -> bytes:
    """A path's bytes. Surrogates of os.fsdecode() are bytes of names that are not UTF-8."""
    try:
        found = os.fsencode(value)
    except (TypeError, UnicodeError):
        raise error("setting_malformed", name, f"is {_shown(value)}", "give a path") from None
    if b"\0" in found:
        raise error("setting_malformed", name, f"is {value!r}", "give a path without NUL")
    return found


def path_or_none(value: Any, name: str) -> Optional[bytes]:
    return None if value is None else path_of(value, name)


def function(given: Any, name: str) -> Callable[..., Any]:
    if not callable(given):
        raise error("setting_malformed", name, f"is {_shown(given)}", "give a function")
    return given


def function_or_none(given: Any, name: str) -> Optional[Callable[..., Any]]:
    return None if given is None else function(given, name)


def body_of(mass: Optional[float], height: Optional[float]) -> Tuple[float, float]:
    """kg and m; 0 for neither."""
    if (mass is None) != (height is None):
        given, left_out = ("height", "mass") if mass is None else ("mass", "height")
        raise error("setting_missing", left_out, f"is left out beside {given}", "give both, or neither for the protocol's body")
    return positive_or_0(mass, "mass", "kg"), positive_or_0(height, "height", "m")


def pairs_of(pairs: Optional[Mapping[str, Tuple[float, float]]], name: str, meaning: str) -> dict[str, Tuple[float, float]]:
    """Two numbers by each parameter's name."""
    if pairs is None:
        return {}
    if not isinstance(pairs, Mapping):
        raise error("setting_malformed", name, f"is {pairs!r}", f"give a dictionary: {meaning} by each parameter's name")
    found = {}
    for parameter, pair in pairs.items():
        try:
            first, second = pair
            found[words(str(parameter), name)] = number(first, name), number(second, name)
        except (TypeError, ValueError) as raised:
            if isinstance(raised, _decid.Error):
                raise
            raise error("setting_malformed", name, f"has {pair!r} for {parameter!r}", f"give two numbers, {meaning}") from None
    return found
