"""A folder of clips retimed by workers that SLURM starts: ``python examples/engines/with_slurm.py CLIPS OUT``.

``--show`` prints the job that would start a worker, and starts none: get queue, account and modules right first
(``SLURMCluster(queue=..., account=..., job_script_prologue=[...])``).
"""

from __future__ import annotations

import sys

from dask_jobqueue import SLURMCluster
from distributed import Client

import retime


def main(clips: str, out: str) -> None:
    """Retime a folder by 64 workers of one processor each."""
    with SLURMCluster(cores=1, processes=1, memory="4GB", walltime="04:00:00") as cluster:
        if clips == "--show":
            print(cluster.job_script())
            return
        cluster.scale(64)
        with Client(cluster) as client:
            print(retime.batch.run(clips, out, {"length": "80%"}, client=client).counts)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[-1])
