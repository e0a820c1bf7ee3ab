"""A study of many motions on a Dask cluster: that at an address, or one on this machine.

python on_dask.py chart.toml chart.zarr tcp://10.0.0.1:8786
"""

from __future__ import annotations

import sys
from contextlib import ExitStack

from distributed import Client, LocalCluster

from percuss.studies import load_study, run_study


def main(file: str, store: str, address: str | None = None) -> None:
    with ExitStack() as stack:
        if address is None:
            cluster = stack.enter_context(LocalCluster(n_workers=2, threads_per_worker=1))
            address = cluster.scheduler_address
        client = stack.enter_context(Client(address))
        print(f"the progress of its workers: {client.dashboard_link}")
        # Interrupted, the same call goes on with the store.
        result = run_study(load_study(file), "results", store=store, engine=address, progress=True)
    for name, words in result.report.items():
        print(f"{name:<30}{words}")
    print(*result.files, sep="\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
