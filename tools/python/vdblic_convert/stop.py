"""Signals that end a run: the frame being written is finished, then the process ends by the signal."""

import contextlib
import os
import signal


class Stopped(Exception):
    """A signal asked the run to stop."""


class Stop:
    """Remembers the first of SIGINT, SIGTERM and SIGHUP; the second one ends the process at once."""

    def __init__(self):
        self.signal = 0
        self._waits = False
        for number in signal.SIGINT, signal.SIGTERM, signal.SIGHUP:
            if signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, self._request)

    def _request(self, number, _):
        self.signal = number
        signal.signal(number, signal.SIG_DFL)
        if self._waits:
            raise Stopped

    @contextlib.contextmanager
    def ends_waits(self):
        """A context in which a signal raises Stopped at once: for calls that may block."""
        self._waits = True
        try:
            yield
        finally:
            self._waits = False

    def check(self):
        """Raise Stopped if a stop was requested."""
        if self.signal:
            raise Stopped


def die_by(number):
    """End the process by a signal, so that the caller sees 128 and its number."""
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)
    os._exit(128 + number)  # the signal is blocked
