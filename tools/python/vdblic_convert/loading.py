"""Safe loading of libraries: some end the process if they cannot start their threads."""

import threading

THREADS = 6  # of OpenVDB's log4cplus and of NumPy's BLAS, beside the first one


def check_threads():
    """Raise RuntimeError if so many threads cannot be started."""
    done, started = threading.Event(), []
    try:
        for _ in range(THREADS):
            thread = threading.Thread(target=done.wait)
            thread.start()
            started.append(thread)
    finally:
        done.set()
        for thread in started:
            thread.join()
