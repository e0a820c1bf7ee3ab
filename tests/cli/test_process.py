"""The command as a process of its own: exit statuses, tracebacks, Ctrl-C, imports."""

from __future__ import annotations

import errno
import io
import os
import shlex
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest
from tests.children import begun, finished, interrupt

import percuss as pc
from percuss.cli.app import main
from percuss.io import load_netcdf, load_record
from percuss.studies.templates import template_text

PERCUSS = [sys.executable, "-m", "percuss"]

# Half a minute of work: a hundred harmonics make each impact slow.
HARMONICS = "".join(
    f"[[forcing.harmonics]]\namplitude = 0.1\nomega = {n}.5\n" for n in range(1, 101)
)
LONG = f"""\
[oscillator]
stiffness = 1
[[oscillator.stops]]
type = "wall"
at = 0
side = "below"
{HARMONICS}
[start]
x0 = 0
v0 = 1
[run]
max_impacts = 5_000_000
[draw]
png = false
svg = false
[save]
csv = false
"""


def percuss(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return finished([*PERCUSS, *arguments], cwd=folder)


def test_the_module_is_the_command(tmp_path: Path) -> None:
    done = percuss("--version", folder=tmp_path)

    assert (done.returncode, done.stdout) == (0, f"percuss {pc.__version__}\n")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device of Linux")
def test_a_full_output_is_one_sentence(tmp_path: Path) -> None:
    done = finished(["sh", "-c", shlex.join([*PERCUSS, "cite"]) + " > /dev/full"], cwd=tmp_path)

    assert done.returncode == 1
    assert done.stderr == "the output cannot be written: no space left on device\n"


def test_what_is_wrong_with_a_file_that_nobody_expected_names_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def lost(**_: object) -> None:
        raise OSError(errno.EIO, "Input/output error", "part/labels.nc")

    monkeypatch.setattr(import_module("percuss.cli.app"), "app", lost)

    with pytest.raises(SystemExit, match=r"^part/labels\.nc: input/output error$"):
        main()


@pytest.mark.skipif(os.name == "nt", reason="of shells")
def test_a_run_without_an_error_stream_writes_its_files(tmp_path: Path) -> None:
    text = template_text("impact").replace("g = true", "g = false")
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    done = finished(
        ["sh", "-c", shlex.join([*PERCUSS, "run", "study.toml"]) + " 2>&-"], cwd=tmp_path
    )

    assert done.returncode == 0
    assert (tmp_path / "study" / "motion.nc").exists()


def test_bad_input_ends_with_status_2_and_without_a_traceback(tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text("[start]\nx0 = nan\nv0 = 'x'\n[run\n")

    done = percuss("run", "bad.toml", folder=tmp_path)

    assert (done.returncode, done.stdout) == (2, "")
    assert "Traceback" not in done.stderr
    assert all(line.startswith("bad.toml:") for line in done.stderr.splitlines())
    assert [path.name for path in tmp_path.iterdir()] == ["bad.toml"]


def test_ctrl_c_keeps_what_was_done_and_ends_with_status_130(tmp_path: Path) -> None:
    (tmp_path / "long.toml").write_text(LONG)
    with begun([*PERCUSS, "run", "long.toml"], cwd=tmp_path) as process:
        # Lines come by the clock, the first one after two seconds, in a pipe too.
        assert process.stderr is not None
        assert any(line.startswith("simulating") for line in process.stderr)
        interrupt(process)
        out, err = process.communicate(timeout=120)

    assert process.returncode == 130
    assert "Traceback" not in err
    assert "interrupted" in out
    assert "interrupted; writing what was done (Ctrl-C again drops it)" in err
    result = tmp_path / "long" / "motion.nc"
    assert load_record(result).outcome == pc.Outcome.interrupted.value
    assert load_netcdf(result)["impacts"].to_dataset().sizes["impact"] > 1000


@pytest.mark.nightly  # test_pipelines.py sends the signal inside one process
@pytest.mark.skipif(os.name != "posix", reason="Windows ends a process at once")
def test_ctrl_c_ends_a_proof_with_status_130_and_no_certificate(tmp_path: Path) -> None:
    # The motion is there at once, its proof takes minutes.
    text = template_text("impact").replace("periods = 20 ", "periods = 20000 ")
    (tmp_path / "long.toml").write_text(text, encoding="utf-8")
    with begun([*PERCUSS, "prove", "long.toml"], cwd=tmp_path) as process:
        assert process.stderr is not None
        assert any(line.startswith("proving") for line in process.stderr)
        interrupt(process)
        _, err = process.communicate(timeout=120)

    assert process.returncode == 130
    assert err == "interrupted; nothing was written\n"
    assert [path.name for path in tmp_path.iterdir()] == ["long.toml"]


def test_sigterm_keeps_what_was_done_and_ends_with_status_143(tmp_path: Path) -> None:
    (tmp_path / "long.toml").write_text(LONG)
    with begun([*PERCUSS, "run", "long.toml"], cwd=tmp_path) as process:
        assert process.stderr is not None
        assert any(line.startswith("simulating") for line in process.stderr)
        # To this process alone, as a queue does at the end of its time.
        process.terminate()
        _, err = process.communicate(timeout=120)

    assert process.returncode == 143
    assert "ended by SIGTERM; writing what was done (once more drops it)" in err
    result = tmp_path / "long" / "motion.nc"
    assert load_record(result).outcome == pc.Outcome.interrupted.value


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["--version"]])
def test_help_loads_nothing_slow(arguments: list[str], tmp_path: Path) -> None:
    code = (
        "import sys, percuss.cli\n"
        f"sys.argv[1:] = {arguments!r}\n"
        "try:\n    percuss.cli.main()\n"
        "except SystemExit:\n    pass\n"
        "slow = {'numpy', 'numba', 'xarray', 'matplotlib', 'h5py', 'scipy'}\n"
        "print(slow & set(sys.modules), file=sys.stderr)"
    )

    done = finished([sys.executable, "-c", code], cwd=tmp_path)

    assert (done.returncode, done.stderr) == (0, "set()\n")
    assert done.stdout


@pytest.mark.parametrize("encoding", ["cp1252", "ascii"])
def test_a_title_that_the_terminal_has_no_letters_for_is_shown_with_marks_in_their_place(
    encoding: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    title = "Übung \u22121 ω"
    text = f'[study]\ntitle = "{title}"\n{LONG}'.replace("5_000_000", "3")
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    monkeypatch.setattr(sys, "argv", ["percuss", "run", "study.toml"])
    written = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(written, encoding=encoding))

    with pytest.raises(SystemExit) as end:
        main()

    sys.stdout.flush()
    assert end.value.code == 0
    assert written.getvalue().splitlines()[0] == title.encode(encoding, errors="replace")
    assert f'title = "{title}"' in load_record(tmp_path / "study" / "motion.nc").study


# Addresses that are none, and what is said of them.
ADDRESSES = [
    (["--port", "99999"], "port = 99999: not a whole number from 0 to 65535"),
    (["--port", "-1"], "port = -1: not a whole number from 0 to 65535"),
    (["--host", "x" * 70], "cannot listen there"),
    (["--host", "no such host"], "cannot listen there"),
]


def test_the_page_refuses_an_address_that_is_none_in_one_sentence(tmp_path: Path) -> None:
    # In one process, which can be ended if it listens after all.
    code = (
        "import sys, percuss.cli\n"
        f"for options in {[options for options, _ in ADDRESSES]!r}:\n"
        "    sys.argv[1:] = ['serve', '--no-open', *options]\n"
        "    try:\n        percuss.cli.main()\n"
        "    except SystemExit as end:\n        print(end.code)"
    )

    done = finished([sys.executable, "-c", code], cwd=tmp_path)

    assert done.stdout.splitlines() == ["2"] * len(ADDRESSES)
    lines = done.stderr.splitlines()
    assert len(lines) == len(ADDRESSES)
    assert all(said in line for line, (_, said) in zip(lines, ADDRESSES, strict=True))
