"""Keyword arguments that the library describes."""

from __future__ import annotations

import textwrap


def described(
    function, parameters: list[dict], without: tuple[str, ...] = (), others: list[dict] | None = None
) -> frozenset[str]:
    """List the library's parameters in a docstring in place of {parameters}. Returns their names.

    others   all parameters of the tool; the names of those that are not listed are put in place of {others}
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
    return names


def checked(name: str, given: dict, known: frozenset[str]) -> dict:
    """The arguments that are not None. Raises TypeError for one that the library does not have."""
    for key in given:
        if key not in known:
            raise TypeError(f"{name}() has no parameter '{key}'; it has {', '.join(sorted(known))}")
    return {key: value for key, value in given.items() if value is not None}
