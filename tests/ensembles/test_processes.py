"""Other processes: what they need of the script that asks for them, and what befalls them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import pytest
from tests.children import begun, finished, interrupt

import percuss as pc
from percuss.ensembles.threads import Threads

ROOT = Path(__file__).parents[2]
OSC, FORCE = pc.impact_oscillator("0.8"), pc.cosine(2.5)

HEAD = """import percuss as pc
def run(measure, store="a.zarr"):
    found = pc.sweep(measure, pc.impact_oscillator("0.8"), pc.cosine(2.5),
                     over={"forcing.omega": [2.4, 2.5]}, engine="processes", n_workers=1,
                     store=store)
    print("found", found[found.attrs and list(found)[0]].values)
"""
MEASURE = """def mine(osc, force, k=1):
    return float(osc.stiffness)
"""
GUARD = 'if __name__ == "__main__":\n'


def inner(text: str) -> str:
    return "".join(f"    {line}\n" for line in text.splitlines())


SCRIPTS = {
    "no guard": (
        HEAD + MEASURE + "run(mine)\n",
        "begins other processes, which import script.py and would come to its line 9 again",
    ),
    "no guard, built in": (HEAD + "run('period')\n", "come to its line 7 again; put what"),
    "under the guard": (
        HEAD + GUARD + inner(MEASURE + "run(mine)"),
        "measure = 'mine': defined under `if __name__ == \"__main__\":`, where other processes",
    ),
}


@pytest.mark.parametrize(
    "what", [pytest.param("no guard", marks=pytest.mark.nightly), *list(SCRIPTS)[1:]]
)
def test_what_a_script_lacks_is_one_sentence_before_anything_begins(
    what: str, tmp_path: Path
) -> None:
    text, message = SCRIPTS[what]
    (tmp_path / "script.py").write_text(text, encoding="utf-8")

    done = run([sys.executable, "script.py"], tmp_path)

    assert done.returncode == 1
    assert message in done.stderr.splitlines()[-1]
    assert done.stderr.count("Traceback") == 1
    assert not (tmp_path / "a.zarr").exists()


@pytest.mark.nightly
def test_a_text_that_python_reads_from_a_pipe_cannot_be_imported(tmp_path: Path) -> None:
    done = run([sys.executable, "-"], tmp_path, HEAD + MEASURE + "run(mine)\n")

    last = done.stderr.splitlines()[-1]
    # What python calls it differs between its versions.
    assert "<stdin> is no file; save it as one" in last or "defined where no other process" in last


def test_a_text_that_is_given_to_python_cannot_be_imported(tmp_path: Path) -> None:
    # As a session or a notebook has it: first what needs no import, then what does.
    text = HEAD + MEASURE + "run('period')\nrun(mine, 'b.zarr')\n"

    done = run([sys.executable, "-c", text], tmp_path)

    assert "found [" in done.stdout, done.stderr
    assert "measure = 'mine': defined where no other process can" in done.stderr.splitlines()[-1]


def test_a_script_with_a_guard_runs(tmp_path: Path) -> None:
    # A partial needs all that the function itself needs.
    text = HEAD + MEASURE + f"import functools\n{GUARD}    run(functools.partial(mine, k=2))\n"
    (tmp_path / "script.py").write_text(text, encoding="utf-8")

    done = run([sys.executable, "script.py"], tmp_path)

    assert done.stdout.count("found [1. 1.]") == 1, done.stderr


def run(command: list[str], folder: Path, text: str = "") -> subprocess.CompletedProcess[str]:
    return finished(command, text=text, cwd=folder)


def deadly(osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG001
    """Kill its process, from some frequency on."""
    if float(force.frequency or 0) > 2.35:
        os.kill(os.getpid(), signal.SIGKILL)
    return 1.0


@pytest.mark.skipif(os.name != "posix", reason="signals are POSIX's")
def test_points_that_kill_three_workers_are_named_with_what_the_store_keeps(tmp_path: Path) -> None:
    over = {"forcing.omega": [2.0 + i / 100 for i in range(64)]}

    with pytest.raises(pc.PercussError) as raised:
        pc.sweep(deadly, OSC, FORCE, over=over, engine="processes", n_workers=1,
                 store=tmp_path / "a.zarr")  # fmt: skip

    reported = str(raised.value)
    assert "3 worker processes have died, one after another" in reported
    assert "these points were at work: 32 to 47;" in reported
    assert "32 of 64 points are done and kept in" in reported
    assert pc.status_of_store(tmp_path / "a.zarr")["points_done"] == 32


def mortal(osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG001
    """Kill its process at two of 64 points, the first time that it is asked."""
    omega = float(force.frequency or 0)
    mark = Path(os.environ[MARKS]) / f"{omega:.2f}"
    if round(100 * omega) % 32 == 8 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return omega


MARKS = "PERCUSS_TEST_MARKS"


@pytest.mark.skipif(os.name != "posix", reason="signals are POSIX's")
def test_an_engine_that_has_lost_workers_goes_on_with_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv(MARKS, str(tmp_path))
    omega = [2.0 + i / 100 for i in range(64)]

    data = pc.sweep(
        mortal, OSC, FORCE, over={"forcing.omega": omega}, engine="processes", n_workers=2
    )

    assert data.mortal.values.tolist() == omega
    assert len(list(tmp_path.iterdir())) == 2
    assert "a worker process has died while these points were at work" in caplog.text


SLOW = """import os, signal, sys, time
import percuss as pc
from percuss.ensembles.threads import Threads
def slow(osc, force):
    print("began", file=sys.stderr, flush=True)
    time.sleep(float(sys.argv[1]))
    return 1.0
if __name__ == "__main__":
    found = pc.sweep(slow, pc.impact_oscillator("0.8"), pc.cosine(2.5),
                     over={"forcing.omega": [2 + i / 100 for i in range(64)]},
                     engine=sys.argv[2], n_workers=1)
    print(int(found.slow.notnull().sum()), found.attrs["complete"], flush=True)
"""


@pytest.mark.skipif(os.name != "posix", reason="signals are POSIX's")
@pytest.mark.parametrize(
    ("times", "engine"),
    [
        (1, "processes"),
        (2, "threads"),
        pytest.param(1, "threads", marks=pytest.mark.nightly),
        pytest.param(2, "processes", marks=pytest.mark.nightly),
    ],
)
def test_ctrl_c_is_heard_at_once_and_a_second_one_drops_what_is_at_work(
    engine: str, times: int, tmp_path: Path
) -> None:
    (tmp_path / "script.py").write_text(SLOW, encoding="utf-8")
    # A chunk is 16 points: 1.6 s, or a quarter of an hour.
    command = [sys.executable, "script.py", "0.1" if times == 1 else "60", engine]
    with begun(command, cwd=tmp_path) as process:
        # Whatever hangs ends here, and fails.
        watchdog = threading.Timer(100.0, process.kill)
        watchdog.start()
        try:
            wait_for(process, "began")
            interrupt(process)
            wait_for(process, "stopping after the chunks at work; Ctrl-C again drops them")
            if times == 2:
                interrupt(process)
            out, err = process.communicate(timeout=60)
        finally:
            watchdog.cancel()

    # What was at work is kept, and with processes what was on the way to one; no more is begun.
    assert out in (["0 0\n"] if times == 2 else ["16 0\n", "32 0\n"]), err
    assert f"interrupted; {out.split()[0]} of 64 points are done" in err


def wait_for(process: subprocess.Popen[str], words: str) -> None:
    assert process.stderr is not None
    for line in process.stderr:
        if words in line:
            return
    pytest.fail(f"it ended without {words!r}")


def test_ctrl_c_while_chunks_are_handed_out_is_heard_as_well(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    real, calls = Threads.submit, []

    def submit(pool: Threads, *arguments: Any) -> Any:
        calls.append(arguments)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return real(pool, *arguments)

    monkeypatch.setattr(Threads, "submit", submit)
    over = {"forcing.omega": [2.0 + i / 100 for i in range(64)]}

    data = pc.sweep(lambda osc, force: 1.0, OSC, FORCE, over=over, n_workers=1)  # noqa: ARG005

    assert len(calls) == 2
    assert data.attrs["complete"] == 0
    # The first chunk may not have been begun yet.
    assert int(data.measure.notnull().sum()) in (0, 16)
    assert "stopping after the chunks at work" in caplog.text
