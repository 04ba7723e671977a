"""The output of a tool: paths of finished outputs on standard output, everything else on standard error."""

import os
import re
import shutil
import sys
import time

from .errors import OutputError


class ClosedPipe(Exception):
    """The reader of standard output has closed it."""


def printable(text):
    """A text, possibly from a file, as one line: control characters and invalid UTF-8 are escaped."""
    no_text = lambda c: "\udc80" <= c <= "\udcff"  # PEP 383
    escaped = lambda c: f"\\x{ord(c) - 0xdc00:02x}" if no_text(c) else c.encode("unicode_escape").decode()
    return "".join(c if c.isprintable() else escaped(c) for c in text)


class Console:
    def __init__(self, tool, level, stop):
        self.tool = tool
        self._stop = stop
        self._level = level  # 0 quiet, 1 normal, 2 verbose
        self._terminal = sys.stderr.isatty() and sys.stdin.isatty() and sys.stdout.isatty()
        self._start = self._last = time.monotonic()
        self._bar = False

    def progress(self, frame, done, total):
        """Tell that `done` frames are finished, `frame` being the last; `total` is 0 if it is unknown."""
        now = time.monotonic()
        count = f"{done}/{total}" if total else str(done)
        left = f", {(now - self._start) / done * (total - done):.0f} s left" if done < total else ""
        if self._level and self._terminal:
            text = f"{self.tool}: frame {count}, {now - self._start:.0f} s{left}"
            self._print(f"\r\033[K{text[:shutil.get_terminal_size().columns - 1]}")
            self._bar = True
        elif self._level:
            self._print(f"{self.tool}: frame {frame}: {now - self._last:.1f} s, {count} done{left}\n")
        self._last = now

    def detail(self, message):
        if self._level == 2:
            self._message(message)

    def say(self, message):
        if self._level:
            self._message(message)

    def warn(self, message):
        self._message(f"warning: {message}")

    def error(self, message):
        self._message(f"error: {message}")

    def finished(self, path):
        """Print the path of a finished output."""
        self.clear()
        try:
            with self._stop.ends_waits():  # for the reader
                sys.stdout.buffer.write(os.fsencode(path) + b"\n")  # a name need not be UTF-8
                sys.stdout.buffer.flush()
        except BrokenPipeError:
            raise ClosedPipe from None
        except OSError as error:
            raise OutputError(f"standard output: cannot be written: {error.strerror}") from None

    def clear(self):
        """Remove the progress from a terminal."""
        if self._bar:
            self._print("\r\033[K")
            self._bar = False

    def _message(self, message):
        self.clear()
        self._print(f"{self.tool}: {printable(re.sub('`([a-z_]+)`', _option, message))}\n")

    @staticmethod
    def _print(text):
        """Failing to print a message does not stop the work."""
        try:
            sys.stderr.write(text)
            sys.stderr.flush()
        except OSError:
            pass


def _option(match):
    """The option that sets a parameter of the library."""
    return "--" + match[1].replace("_", "-")
