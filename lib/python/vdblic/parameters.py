"""Keyword arguments that the library describes."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Iterable, Mapping
from typing import Any

from . import _core


def described(
    function: Any, parameters: list[dict[str, Any]], without: Iterable[str] = (), others: list[dict[str, Any]] | None = None
) -> frozenset[str]:
    """List the library's parameters in a docstring in place of {parameters}, and in the signature. Returns their names.

    others   all parameters of the tool; the unlisted names replace {others}
    """
    lines = []
    listed = [p for p in parameters if p["key"] not in without]
    for parameter in listed:
        text = parameter["text"].rstrip(".")
        notes = [parameter["unit"], parameter["kind"], parameter["default"] and f"default {parameter['default']}"]
        text += f" [{'; '.join(note for note in notes if note)}]"
        lines += textwrap.wrap(text, 118, initial_indent=f"    {parameter['key']:<18} ", subsequent_indent=" " * 23)
    names = frozenset(p["key"] for p in listed)
    left_out = textwrap.fill(", ".join(p["key"] for p in others or [] if p["key"] not in names), 118)
    text = (function.__doc__ or "").replace("{parameters}", "\n".join(lines) + "\n")
    function.__doc__ = text.replace("{others}", left_out.replace("\n", "\n    "))
    called = vars(function)["__init__"] if isinstance(function, type) else function
    signature = inspect.signature(called)
    own = [p for p in signature.parameters.values() if p.kind != p.VAR_KEYWORD]
    more = [inspect.Parameter(p["key"], inspect.Parameter.KEYWORD_ONLY, default=_default(p)) for p in listed]
    called.__signature__ = signature.replace(parameters=own + more)
    return names


def _default(parameter):
    """The default of a parameter as a value; None where it depends on the data."""
    text = parameter["default"]
    if parameter["type"] == "text" or not text:
        return text or None
    kind = {"flag": lambda word: word == "true", "integer": int, "number": float}[parameter["type"]]
    words = tuple(map(kind, text.split()))
    return words if len(words) > 1 else words[0]


def checked(name: str, given: Mapping[str, Any], known: frozenset[str]) -> dict[str, Any]:
    """The arguments that are not None. Raises TypeError for one that the library does not have."""
    for key in given:
        if key not in known:
            near = _core.nearest_name(key, sorted(known))
            advice = f"'{near}' is one" if near else f"help(vdblic.{name}) lists them"
            raise TypeError(f"{name}() has no parameter '{key}'; {advice}")
    return {key: value for key, value in given.items() if value is not None}
