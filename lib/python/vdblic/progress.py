"""Progress, warnings and messages of a computation."""

from __future__ import annotations

import logging
import re
import sys
import warnings
from collections.abc import Callable
from typing import Any, Union

Progress = Union[bool, Callable[[int, Union[int, None]], Any], None]
"""A function that is called with the steps done and their number (None if unknown); True for a bar of tqdm, False for
none. By default there is a bar in a notebook and in a terminal if tqdm is installed."""

_LOG = logging.getLogger("vdblic")


class Teller:
    """Passes on reports of _core: warnings as Python's, messages to the logger `vdblic`."""

    def __init__(self, progress: Progress, title: str, unit: str = "steps", stacklevel: int = 3) -> None:
        """@param stacklevel  of warnings: the caller of the function that computes"""
        self._stacklevel = stacklevel
        self.folder = ""  # of frames that wait as files
        self._tell = progress if callable(progress) else None
        self._bar: Any = None
        if not callable(progress) and (progress or progress is None and _is_watched()):
            self._bar = _bar(title, unit, is_needed=progress is True)

    def __call__(self, kind: str, *told: Any) -> None:
        if kind == "warned":
            warnings.warn(without_files(told[0], self.folder), stacklevel=self._stacklevel)
        elif kind == "said":
            _LOG.info(without_files(told[0], self.folder))
        else:
            self._show(told[0], told[1] or None)

    def _show(self, done: int, total: int | None) -> None:
        if self._tell is not None:
            self._tell(done, total)
        if self._bar is not None:
            self._bar.total = total
            self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """End the bar."""
        if self._bar is not None:
            self._bar.close()

    def __enter__(self) -> Teller:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


def without_files(message: str, folder: str) -> str:
    """A message with numbers in place of the files in which frames wait: `velocity 2`, or `velocity` for all."""
    files = rf"{re.escape(folder)}/(\w+)\.(?:0*(\d+)|%06d)\.vdb"
    return re.sub(files, lambda file: " ".join(filter(None, file.groups())), message) if folder else message


def _is_watched():
    return "ipykernel" in sys.modules or sys.stderr is not None and sys.stderr.isatty()


def _bar(title, unit, is_needed):
    try:
        from tqdm.auto import tqdm  # type: ignore  # pylint: disable=import-outside-toplevel
    except ImportError:
        if is_needed:
            raise
        return None
    return tqdm(desc=title, unit=unit)
