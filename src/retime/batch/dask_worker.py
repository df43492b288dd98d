"""What each worker of a cluster made here does first.

A terminal sends Ctrl-C to all its processes. The one that asked for the work ends the others in order; a worker that
ended by itself meanwhile would say so in a hundred lines.
"""

from __future__ import annotations

import signal
import threading


def dask_setup(worker: object) -> None:
    """Leave Ctrl-C to the client; called by Dask."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)
