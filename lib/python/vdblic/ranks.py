"""The ranks of `mpirun`, by a communicator of mpi4py."""

from __future__ import annotations

from typing import Any

import numpy

from .grids import Array

_MOST = 1 << 30  # bytes that MPI takes at a time: it counts with an int


class Ranks:
    """The communication for _core. All but `rank` and `size` is collective."""

    def __init__(self, comm: Any) -> None:
        if not all(hasattr(comm, name) for name in ("alltoall", "allgather", "Get_rank", "Get_size")):
            raise TypeError(f"`comm` cannot be {comm!r:.100}; it is a communicator of mpi4py, such as MPI.COMM_WORLD")
        self._comm, self.rank, self.size = comm, comm.Get_rank(), comm.Get_size()

    def swap(self, messages: list[bytes]) -> list[bytes]:
        """Send a message to each rank, and receive one from each."""
        part = _MOST // self.size
        longest = max(self._comm.allgather(max(map(len, messages))))
        parts = [
            self._comm.alltoall([message[at : at + part] for message in messages]) for at in range(0, longest, part)
        ]
        return [b"".join(received) for received in zip(*parts)] if parts else messages

    def sum(self, numbers: Array) -> Array:
        """The sums over all ranks."""
        return numpy.sum(self._comm.allgather(numbers), axis=0, dtype=numbers.dtype)  # type: ignore[no-any-return]

    def max(self, numbers: Array) -> Array:
        """The largest over all ranks."""
        return numpy.max(self._comm.allgather(numbers), axis=0)  # type: ignore[no-any-return]

    def agree(self, error: ValueError | None, placed: str) -> None:
        """Raise one rank's error at all ranks; or an error if their parts differ in name, transform or time."""
        told = self._comm.allgather((None if error is None else str(error), placed))
        if error is not None:
            raise error
        for rank, (message, _) in enumerate(told):
            if message is not None:
                raise ValueError(f"rank {rank}: {message}")
        if len({place for _, place in told}) > 1:
            raise ValueError("the ranks' velocities differ in name, transform or time; `origin` tells a part's place")
