from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.ensembles.studies import chart, slow_measure

import percuss as pc
from percuss.ensembles.engines import EngineError

OSC, FORCE = pc.impact_oscillator(restitution=0.8), pc.cosine(2.5)


def test_processes_give_the_bits_of_threads(tmp_path: Path) -> None:
    threads = chart()

    processes = chart(str(tmp_path / "a.zarr"), engine="processes")

    assert processes.identical(threads)


def test_a_cluster_gives_the_same_bits_though_a_worker_dies() -> None:
    distributed = pytest.importorskip("distributed")
    over = {"forcing.omega": np.linspace(2.0, 3.0, 400)}
    expected = pc.sweep(slow_measure, OSC, FORCE, over=over, engine="threads")
    killed: list[float] = []

    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=":0", processes=True
        ) as cluster,
        distributed.Client(cluster) as client,
    ):

        def kill_one(done: float, total: float) -> bool:
            if not killed and done > 0.2 * total:
                worker = next(iter(cluster.workers.values()))
                worker.process.process.kill()
                killed.append(done)
            return True

        found = pc.sweep(slow_measure, OSC, FORCE, over=over, engine=client, progress=kill_one)
        by_address = chart(engine=cluster.scheduler_address)

    assert killed
    assert found.identical(expected)
    assert by_address.identical(chart())


def test_a_cluster_that_does_not_answer_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("percuss.ensembles.engines.CONNECT", 0.2)

    with pytest.raises(EngineError, match="no Dask scheduler answers"):
        chart(engine="tcp://127.0.0.1:9")


def test_an_engine_that_is_none_is_told() -> None:
    with pytest.raises(pc.ParameterError, match="neither"):
        chart(engine="gpu")
