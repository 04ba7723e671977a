"""Runs of tools, measured from outside: a process of its own starts them, whose memory is not in theirs."""

import subprocess


def run(tool, *arguments):
    """Run a tool. Returns elapsed seconds and the most memory that it held [bytes]."""
    command = ["/usr/bin/time", "-f", "%e %M", str(tool), *map(str, arguments)]
    done = subprocess.run(command, text=True, capture_output=True, check=True)
    seconds, kilobytes = done.stderr.splitlines()[-1].split()
    return float(seconds), 1024 * int(kilobytes)
