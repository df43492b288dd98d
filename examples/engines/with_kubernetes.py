"""A folder of clips retimed by pods of Kubernetes: ``python examples/engines/with_kubernetes.py IMAGE CLIPS OUT``.

The image has ``retime[batch]``, and the folders are mounted under the same names in the pods and here.
``python examples/engines/with_kubernetes.py IMAGE`` prints what would be asked of the cluster, and asks nothing.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from dask_kubernetes.operator import KubeCluster, make_cluster_spec
from distributed import Client

import retime


def spec_of(image: str) -> dict[str, Any]:
    """Say what the cluster is: 16 workers of one processor and 4 GB each."""
    return make_cluster_spec(
        name="retime",
        image=image,
        n_workers=16,
        resources={"limits": {"cpu": "1", "memory": "4Gi"}},
        worker_command=["dask", "worker", "--nthreads", "1"],
    )


def main(image: str, clips: str, out: str) -> None:
    """Retime a folder."""
    with KubeCluster(custom_cluster_spec=spec_of(image)) as cluster, Client(cluster) as client:
        print(retime.batch.run(clips, out, {"length": "80%"}, client=client).counts)


if __name__ == "__main__":
    if len(sys.argv) == 2:
        print(json.dumps(spec_of(sys.argv[1]), indent=2))
    else:
        main(*sys.argv[1:4])
