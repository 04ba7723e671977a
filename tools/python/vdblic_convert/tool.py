"""A command-line tool: the options that all tools share, messages and exit statuses."""

import argparse
import contextlib
import difflib
import errno
import math
import os
import re
import signal
import sys

from vdblic._core import guard_against_crashes

from .console import ClosedPipe, Console, printable
from .errors import STATUS, OutputError, ParameterError
from .stop import Stop, Stopped, die_by

MOST_NUMBER = 1_000_000_000_000  # of a frame
_STATUS = """Exit status: 0 done, 2 usage, 3 bad input data, 4 output could not be written, 5 a bug; after a
signal 128 and its number.
The path of each finished output is printed on standard output, messages on standard error."""


class _Help(argparse.HelpFormatter):
    """Help in the layout of VDBLIC's other tools."""

    def __init__(self, prog):
        super().__init__(prog, max_help_position=30, width=10_000)

    def _format_action_invocation(self, action):
        names = ",".join(action.option_strings) or action.metavar
        value = f" {self._format_args(action, 'TEXT')}" if action.option_strings else " TEXT"
        value = re.sub(r" \[.* \.\.\.\]", " ...", value) if action.nargs == "+" else value * (action.nargs != 0)
        return names + value + (" REQUIRED" if action.required else "")

    def _format_text(self, text):
        return f"{text}\n\n"


class _Parser(argparse.ArgumentParser):
    def __init__(self, name, description):
        super().__init__(name, description=description, epilog=_STATUS, formatter_class=_Help, allow_abbrev=False)
        self._negative_number_matcher = re.compile(r"-[.\d]|-inf$|-nan$")  # values, not options

    def format_help(self):
        """Help in the order of VDBLIC's other tools: first the description."""
        _, rest = super().format_help().split(f"{self.description}\n\n")
        inputs = " ".join(action.metavar for action in self._get_positional_actions())
        return f"{self.description}\nUsage: {self.prog} [OPTIONS] {inputs}\n\n{rest}"

    def error(self, message):
        raise ParameterError(message)

    def check(self, words):
        """Name the option that was probably meant, which argparse does not."""
        if "" in words or any(re.fullmatch(r"--?[a-z-]+=", word) for word in words):
            raise ParameterError("an argument is empty; leave it out or give it a value")
        known = [name for action in self._actions for name in action.option_strings if name.startswith("--")]
        for word in words:
            if word == "--":
                return
            option = word.partition("=")[0]
            if re.match(r"--[a-zA-Z]", word) and option not in known:
                near = [name for name in known if name.startswith(option)] or difflib.get_close_matches(option, known)
                raise ParameterError(f"there is no option {option[:60]}{f'; {near[0]} is one' if near else ''}")


def number(text):
    """A finite number, for options."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or abs(value) > 1e30:
        raise argparse.ArgumentTypeError(f"'{text[:60]}' is not a number, or out of range")
    return value


def positive(text):
    value = number(text)
    if not 1e-30 < value <= 1e12:
        raise argparse.ArgumentTypeError(f"'{text[:60]}' must be a positive number, at most 1e12")
    return value


def whole(least, most):
    """The type of options that are whole numbers in a range."""

    def parse(text):
        if not re.fullmatch(r"-?\d{1,15}", text) or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"'{text[:60]}' is not a whole number from {least} to {most}")
        return int(text)

    return parse


def _hold_standard_streams():
    """Occupy the descriptors of closed streams, so that no file gets one and receives printed text."""
    for number, mode in enumerate((os.O_WRONLY, os.O_RDONLY, os.O_RDONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, mode)  # the lowest free descriptor
    if sys.stdout is None:  # writing fails, as it should
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # pylint: disable=consider-using-with
    if sys.stderr is None:
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # pylint: disable=consider-using-with


def _drop_unprinted():
    """Discard output that cannot be printed: the interpreter would retry at its exit and change the status."""
    for stream, number in (sys.stdout, 1), (sys.stderr, 2):
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), number)


class Tool:
    """The command line of a tool. `add` has the arguments of argparse's add_argument."""

    def __init__(self, name, version, description):
        self.name = name
        self._parser = _Parser(name, description)
        self.add = self._parser.add_argument
        self._parser._optionals.title = "Options"
        self._parser._positionals.title = "Positionals"
        self.add("--version", action="version", version=version, help="Display program version information and exit")
        level = self._parser.add_mutually_exclusive_group().add_argument
        told = {("-q", "--quiet"): (0, "Print errors and warnings only."), ("-v", "--verbose"): (2, "Print details.")}
        for names, (const, text) in told.items():
            level(*names, dest="level", action="store_const", const=const, default=1, help=text)

    def sequence(self, numbering="paths on standard input", frames=""):
        """The options that select frames and name outputs."""
        self.add("--frames", metavar="TEXT", default="",
                 help=f"Frames to use: 1-100, 1-100x2 or 1,5,9-20; every frame found by default.{frames}")  # fmt: skip
        self.add("--clamp-frames", action="store_true",
                 help="Leave out frames of --frames that lie beyond the files on disk.")  # fmt: skip
        ends = -MOST_NUMBER, MOST_NUMBER
        self.add("--renumber", metavar=f"INT:INT in [{ends[0]} - {ends[1]}]", type=whole(*ends),
                 help=f"Number {numbering} from this number on as they come, whatever their names.")  # fmt: skip
        self.add("--skip-existing", action="store_true",
                 help="Leave outputs that are there as they are, and print their paths.")  # fmt: skip

    def run(self, words, job):
        """Parse the command line and run `job(options, console, stop)`. Returns the exit status."""
        _hold_standard_streams()
        try:
            return self._run(words, job)
        finally:
            _drop_unprinted()

    def _run(self, words, job):
        guard_against_crashes(self.name)
        stop = Stop()
        console = Console(self.name, 1, stop)
        try:
            self._parser.check(words)
            options = self._parser.parse_args(words)
        except ParameterError as error:
            with contextlib.suppress(OSError):
                sys.stderr.write(f"{self.name}: {printable(str(error))}\n{self.name} --help lists the options.\n")
            return STATUS[ParameterError]
        except SystemExit:  # --help, --version
            return self._told(console)
        except OSError as error:
            return self._told(console, error)
        console = Console(self.name, options.level, stop)
        try:
            job(options, console, stop)
            return 0
        except ClosedPipe:
            die_by(stop.signal or signal.SIGPIPE)
        except Stopped:
            console.say("stopped")
            die_by(stop.signal)
        except tuple(STATUS) as error:
            console.error(str(error))
            return STATUS[type(error)]
        except MemoryError:
            console.error(
                "this takes more memory than may be used; choose fewer voxels, or give the process more memory"
            )
            return 3
        except Exception as error:  # pylint: disable=broad-except
            console.error(f"internal error, please report it: {type(error).__name__}: {error}")
        return 5

    def _told(self, console, error=None):
        """The status after something was printed instead of a job; `error` if that failed."""
        try:
            sys.stdout.flush()
        except OSError as failure:
            error = failure
        if not error:
            return 0
        _drop_unprinted()
        if error.errno == errno.EPIPE:
            die_by(signal.SIGPIPE)
        console.error(f"standard output: cannot be written: {error.strerror}")
        return STATUS[OutputError]
