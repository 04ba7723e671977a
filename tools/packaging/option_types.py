"""Writes the types of the keyword arguments that the library describes, for mypy and editors.

    PYTHONPATH=FOLDER_OF_THE_MODULE python3 option_types.py vdblic/_options.pyi
"""

import sys

import vdblic.films
import vdblic.flow
import vdblic.measures
import vdblic.pictures
from vdblic import _core

HEAD = '''# Written by option_types.py from the library's parameters.
import datetime
from collections.abc import Sequence
from os import PathLike
from typing import Any, Literal, TypedDict

import numpy
from numpy.typing import NDArray

Number = float | numpy.integer[Any] | numpy.floating[Any]
Numbers = Number | Sequence[Number | Sequence[Number]] | NDArray[Any]
Seconds = Number | datetime.timedelta | numpy.timedelta64
Text = str | PathLike[str] | Sequence[Any] | NDArray[Any]
'''


def type_of(parameter):
    """The type of a keyword argument."""
    if parameter["choices"]:
        return f"Literal[{', '.join(map(repr, parameter['choices']))}]"
    if parameter["unit"] == "s":
        return "Seconds"
    number = "Numbers" if parameter["several"] else "Number"
    return {"flag": "bool", "text": "Text"}.get(parameter["type"], number)


def main(path):
    """Write the types of all functions to a file."""
    text = HEAD
    for name, function, known in (
        ("AdvectOptions", "advect", vdblic.flow.PARAMETERS),
        ("StreakOptions", "advect", vdblic.flow.STREAK_PARAMETERS),
        ("FlowOptions", "advect", vdblic.flow.FLOW_PARAMETERS),
        ("PictureOptions", "picture", vdblic.pictures.OPTIONS),
        ("FilmOptions", "film", vdblic.films.OPTIONS),
        ("DiffOptions", "diff", vdblic.measures.DIFF_OPTIONS),
        ("CoherenceOptions", "coherence", vdblic.measures.COHERENCE_OPTIONS),
    ):
        text += f"\nclass {name}(TypedDict, total=False):\n"
        for parameter in _core.parameters(function):
            if parameter["key"] in known:
                text += f"    {parameter['key']}: {type_of(parameter)} | None\n"
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


main(sys.argv[1])
