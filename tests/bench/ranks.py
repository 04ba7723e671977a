#!/usr/bin/python3
"""The table "Many machines" of docs/evidence.md: memory and traffic of vdblic_advect_mpi, ABC flow of 256³ voxels.

    tests/bench/ranks.py TOOLS
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

from measure import run

ENVIRONMENT = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
               "OMPI_MCA_btl_vader_single_copy_mechanism": "none"}
SIDE = 256
ADVECT = ["v.%04d.vdb", "-o", "t.%04d.vdb", "--frames", "1-2", "--preroll", "2", "--checkpoint-every", "0", "-v"]  # 4 steps


def ranks_of(tools, ranks):
    """The peak of the largest rank [bytes], and the bytes exchanged [MB]."""
    measure = (f"/usr/bin/time -f %M -o memory.$OMPI_COMM_WORLD_RANK {tools}/vdblic_advect_mpi --threads 1 "
               f"{' '.join(ADVECT)}")  # fmt: skip
    command = ["mpirun", "--oversubscribe", "--bind-to", "none", "-n", str(ranks), "sh", "-c", measure]
    told = subprocess.run(command, env=ENVIRONMENT, check=True, capture_output=True, text=True).stderr
    peaks = [1024 * int(pathlib.Path(f"memory.{rank}").read_text(encoding="utf-8")) for rank in range(ranks)]
    return max(peaks), float(re.search(r"exchanged ([\d.]+) MB", told)[1])


def main():
    tools = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory(prefix="vdblic-") as folder:
        os.chdir(folder)
        run(tools / "vdblic_synth", "abc", "-o", "v.%04d.vdb", "--size", SIDE, SIDE, SIDE, "--frames", "1-3")
        _, alone = run(tools / "vdblic_advect", "--threads", 1, *ADVECT)
        print(f"One process takes {alone / 1e6:.0f} MB.\n")
        print("| ranks | memory of a rank, largest [MB] | of one process's | exchanged [MB] |\n|---|---|---|---|")
        for ranks in 2, 3, 4, 7:
            memory, sent = ranks_of(tools, ranks)
            print(f"| {ranks} | {memory / 1e6:.0f} | {memory / alone:.2f} | {sent:.0f} |", flush=True)


main()
