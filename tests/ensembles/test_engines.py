from __future__ import annotations

import contextlib
import gc
import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.ensembles.studies import chart, slow_measure, whole_chart

import percuss as pc
from percuss.ensembles.cluster import EngineError

OSC, FORCE = pc.impact_oscillator(restitution=0.8), pc.cosine(2.5)


@pytest.fixture(scope="module")
def local() -> Iterator[Any]:
    """A cluster without workers: those of a test are for those after it, too."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=0, threads_per_worker=1, dashboard_address=":0", processes=True
    ) as cluster:
        yield cluster


@contextlib.contextmanager
def client_of(cluster: Any, n_workers: int) -> Iterator[Any]:
    """Give a client of a cluster with so many workers."""
    distributed = pytest.importorskip("distributed")
    cluster.scale(n_workers)
    with distributed.Client(cluster, set_as_default=False) as client:
        until = time.monotonic() + 120.0
        while len(client.scheduler_info()["workers"]) != n_workers and time.monotonic() < until:
            time.sleep(0.02)
        yield client


def test_processes_give_the_bits_of_threads(tmp_path: Path) -> None:
    processes = chart(str(tmp_path / "a.zarr"), engine="processes")

    assert processes.identical(whole_chart())


def test_a_cluster_without_workers_is_reported_and_waited_for(
    local: Any, caplog: pytest.LogCaptureFixture
) -> None:
    over = {"forcing.omega": [2.4, 2.5]}
    with client_of(local, 0) as client:
        joins = threading.Timer(1.0, lambda: local.scale(1))
        joins.start()
        data = pc.sweep("period", OSC, FORCE, over=over, transient=5, periods=5, engine=client)
        joins.join()

    assert data.attrs["complete"] == 1
    reported = f"no workers yet at {local.scheduler_address}; waiting: the run goes on when"
    assert reported in caplog.text


@pytest.mark.skipif(os.name != "posix", reason="signals are POSIX's")
def test_workers_that_are_frozen_are_reported_and_the_run_goes_on_when_they_return(
    local: Any, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("percuss.ensembles.cluster.SILENT", 2.0)
    monkeypatch.setattr("percuss.ensembles.cluster.AGAIN", 1.0)
    over = {"forcing.omega": np.linspace(2.0, 3.0, 96)}
    reported: list[str] = []
    frozen: list[int] = []

    def freeze(done: float, total: float) -> bool:  # noqa: ARG001
        if not frozen:
            frozen.append(next(iter(local.workers.values())).process.process.pid)
            os.kill(frozen[0], signal.SIGSTOP)
        reported.append(caplog.text)
        caplog.clear()
        if "".join(reported).count("nothing has been heard of 1 of 1 workers") >= 2:
            os.kill(frozen[0], signal.SIGCONT)
        return True

    with client_of(local, 1) as client:
        data = pc.sweep(whose, OSC, FORCE, over=over, engine=client, progress=freeze)

    assert "waiting: the run goes on when workers answer or join" in "".join(reported)
    assert data.attrs["complete"] == 1
    assert set(data.whose.values) == {frozen[0]}


def whose(osc: pc.Oscillator, force: pc.Forcing, wait_for: str = "") -> float:  # noqa: ARG001
    """Return the process that has been asked, after a while; or once a file is there."""
    time.sleep(0.01)
    while wait_for and not Path(wait_for).exists():
        time.sleep(0.01)
    return float(os.getpid())


def test_a_worker_that_joins_in_mid_run_gets_its_part_and_a_lost_cluster_is_reported(
    local: Any, tmp_path: Path
) -> None:
    # Nothing is done before there are two.
    joined = tmp_path / "joined"
    over = {"forcing.omega": np.linspace(2.0, 3.0, 320)}
    store = tmp_path / "a.zarr"
    grown: list[float] = []

    with client_of(local, 1) as client:

        def let_join(done: float, total: float) -> bool:  # noqa: ARG001
            if not grown:
                local.scale(2)
                grown.append(done)
            if len(client.scheduler_info()["workers"]) == 2:
                joined.touch()
            return True

        waiting = partial(whose, wait_for=str(joined))
        data = pc.sweep(waiting, OSC, FORCE, over=over, engine=client, progress=let_join)

        def lose(done: float, total: float) -> bool:  # noqa: ARG001
            client.close()
            return True

        with pytest.raises(EngineError, match="the Dask cluster has failed"):
            pc.sweep(whose, OSC, FORCE, over=over, engine=client, store=store, progress=lose)

    assert len(np.unique(data.measure)) == 2
    assert grown == [0.0]
    assert 1 <= pc.status_of_store(store)["done"] < 20


def test_a_cluster_gives_the_same_bits_though_a_worker_dies(local: Any) -> None:
    over = {"forcing.omega": np.linspace(2.0, 3.0, 96)}
    expected = pc.sweep(slow_measure, OSC, FORCE, over=over, engine="threads")
    killed: list[float] = []

    def kill_one(done: float, total: float) -> bool:
        if not killed and done > 0.2 * total:
            worker = next(iter(local.workers.values()))
            worker.process.process.kill()
            killed.append(done)
        return True

    with client_of(local, 2) as client:
        data = pc.sweep(slow_measure, OSC, FORCE, over=over, engine=client, progress=kill_one)
        by_address = chart(engine=local.scheduler_address)

    assert killed
    assert data.identical(expected)
    assert by_address.identical(whole_chart())


def test_a_function_that_cannot_be_sent_to_a_worker_is_refused() -> None:
    pytest.importorskip("distributed")
    lock = threading.Lock()

    class Client:
        """As far as it is asked before anything is sent."""

        submit = scheduler_info = loop = None

    with pytest.raises(pc.ParameterError, match="cannot be sent to a worker"):
        pc.sweep(
            lambda osc, force: float(lock.locked()),  # noqa: ARG005
            OSC,
            FORCE,
            over={"forcing.omega": [2.0]},
            engine=Client(),
        )


@pytest.mark.parametrize("address", ["tcp://127.0.0.1", "foo://127.0.0.1:9", "tls://127.0.0.1:9"])
def test_a_wrong_address_is_refused(address: str) -> None:
    distributed = pytest.importorskip("distributed")

    def open_clients() -> int:
        clients = [it for it in gc.get_objects() if type(it) is distributed.Client]
        return sum(client.status != "closed" for client in clients)

    before = open_clients()
    with pytest.raises(EngineError, match=f"no Dask scheduler answers at {address}: "):
        chart(engine=address)
    # The garbage collector would close it at any time, even while another begins: for ever.
    assert open_clients() <= before


@pytest.mark.parametrize("n", [0, -1, 1.5, True])
def test_a_wrong_number_of_workers_is_refused(n: object, tmp_path: Path) -> None:
    over = {"forcing.omega": [2.0]}

    with pytest.raises(pc.ParameterError, match="n_workers"):
        pc.sweep("period", OSC, FORCE, over=over, n_workers=n, store=tmp_path / "a.zarr")  # type: ignore[arg-type]
    assert not (tmp_path / "a.zarr").exists()


def test_a_cluster_that_does_not_answer_is_reported(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    pytest.importorskip("distributed")
    monkeypatch.setattr("percuss.ensembles.cluster.CONNECT", 0.2)

    with pytest.raises(EngineError, match="no Dask scheduler answers"):
        chart(str(tmp_path / "a.zarr"), engine="tcp://127.0.0.1:9")
    # Nothing was begun.
    assert not (tmp_path / "a.zarr").exists()


def test_a_scheduler_that_is_gone_ends_the_run_with_a_sentence(tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    over = {"forcing.omega": np.linspace(2.0, 3.0, 1600)}
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1",
               "--port", "0", "--no-dashboard"]  # fmt: skip
    with (
        subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as scheduler,
        contextlib.ExitStack() as after,
    ):
        after.callback(scheduler.kill)
        assert scheduler.stderr is not None
        address = next(
            match[0] for line in scheduler.stderr if (match := re.search(r"tcp://[\d.:]+", line))
        )
        client = after.enter_context(distributed.Client(address, timeout=120, set_as_default=False))

        def lose(done: float, total: float) -> bool:  # noqa: ARG001
            scheduler.kill()
            return True

        with pytest.raises(
            EngineError,
            match=r"the Dask cluster has failed.*0 of 1,600 points are done and kept in",
        ):
            pc.sweep(whose, OSC, FORCE, over=over, engine=client, store=tmp_path / "a.zarr",
                     progress=lose)  # fmt: skip


def test_a_wrong_engine_is_refused() -> None:
    with pytest.raises(pc.ParameterError, match="neither"):
        chart(engine="gpu")
