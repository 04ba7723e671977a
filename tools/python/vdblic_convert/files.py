"""Output files: whole under their names or not there at all."""

import errno
import os
import pathlib
import re
import resource
import stat

from .errors import OutputError, ParameterError


def file_behind(output):
    """The file that an output replaces or makes, at the end of its symbolic links. Raises ParameterError if something
    other than a file is there."""
    output = pathlib.Path(output)
    if output.is_dir():
        raise ParameterError(f"output '{output}' is a folder; name a file")
    if output.exists() and (not stat.S_ISREG(output.stat().st_mode) or _is_standard_stream(output)):
        raise ParameterError(f"output '{output}' is a device or a pipe, which a file would replace; name a file")
    return pathlib.Path(os.path.realpath(output)) if output.is_symlink() else output


def _is_standard_stream(path):
    return any(os.path.samestat(path.stat(), os.fstat(stream)) for stream in (1, 2) if _is_open(stream))


def _is_open(descriptor):
    try:
        os.fstat(descriptor)
    except OSError:
        return False
    return True


def check_output(output):
    """Make sure before any work that an output can be written."""
    _Temporary(file_behind(output), output).close()


def check_not_inputs(outputs, inputs):
    """Raise ParameterError if an output would replace an input."""
    taken = {_identity(path) for path in inputs}
    for output in outputs:
        if os.path.exists(output) and _identity(output) in taken:
            raise ParameterError(f"output '{output}' would replace an input; name another file")


def _identity(path):
    status = os.stat(path)
    return status.st_dev, status.st_ino


def check_extension(output, extensions):
    if pathlib.Path(output).suffix.lower() not in extensions:
        raise ParameterError(f"output '{output}' must end in {' or '.join(extensions)}")


def write_file(output, data):
    """Write a file: under a temporary name, flushed to disk, renamed."""
    temporary = _Temporary(file_behind(output), output)
    try:
        temporary.commit(data)
    finally:
        temporary.close()


def bytes_of(output, write):
    """The bytes that a library writes to the file whose name `write` gets.

    They stay in memory, because libraries such as OpenVDB do not notice a write that fails. Raises OutputError, for
    `output`, where files may not be so large.
    """
    descriptor = os.memfd_create("output")
    with os.fdopen(descriptor, "rb") as file:
        write(f"/proc/self/fd/{descriptor}")
        data = file.read()
    limit, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
    if 0 <= limit <= len(data):
        raise OutputError(f"{output}: cannot be written: {os.strerror(errno.EFBIG)}")
    return data


class _Temporary:
    """A file without a name where the file system has such files, so that a killed process leaves nothing."""

    def __init__(self, final, shown):
        self._final, self._shown = final, shown
        self._folder = final.parent
        self._name = self._folder / f".{final.name[:120]}.{re.sub('/', '_', os.uname().nodename)}-{os.getpid()}.part"
        self._named = False
        if not self._folder.is_dir():
            raise OutputError(f"{shown}: the folder {self._folder} does not exist; make it first")
        try:
            self._descriptor = os.open(self._folder, os.O_TMPFILE | os.O_RDWR | os.O_CLOEXEC, 0o666)
        except PermissionError as error:
            raise self._failure(error) from None
        except OSError:
            self._descriptor = self._try(os.open, self._name, os.O_CREAT | os.O_EXCL | os.O_RDWR | os.O_CLOEXEC, 0o666)
            self._named = True

    def commit(self, data):
        left = memoryview(data)
        while left:
            left = left[self._try(os.write, self._descriptor, left) :]
        self._try(os.fsync, self._descriptor)
        if not self._named:
            # Python follows the link in /proc only where a folder is given, which an absolute path ignores.
            self._try(os.link, f"/proc/self/fd/{self._descriptor}", self._name, src_dir_fd=self._descriptor)
            self._named = True
        self._try(os.rename, self._name, self._final)
        self._named = False

    def close(self):
        os.close(self._descriptor)
        if self._named:
            self._name.unlink(missing_ok=True)

    def _try(self, call, *arguments, **options):
        try:
            return call(*arguments, **options)
        except OSError as error:
            raise self._failure(error) from None

    def _failure(self, error):
        return OutputError(f"{self._shown}: cannot be written: {error.strerror}")
