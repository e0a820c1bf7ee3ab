"""Films of runs: everything stands where the run is at that time, and files play."""

from __future__ import annotations

import base64
import functools
import io
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.patches import Rectangle
from PIL import Image

import percuss as pc
from percuss import plotting
from percuss.errors import OutputError, ParameterError
from percuss.plotting.animation import FLASH
from percuss.studies import parse_study, run_study

STOPS = (
    pc.Wall(at="0.2", side="below", restitution="0.8"),
    pc.SoftStop(at="1.2", side="above", stiffness=30),
)
OSC = pc.Oscillator(stiffness=1, damping="0.05", stops=STOPS)
PAIR = pc.chain(
    [1, 1],
    [0, 1, 1],
    [0, "0.03", "0.03"],
    [pc.SoftStop(at="0.4", side="above", stiffness=100, on=0)],
)


@functools.cache
def run() -> pc.Trajectory:
    return pc.simulate(OSC, pc.cosine(2), x0="0.3", v0=0, periods=6)


@functools.cache
def motion() -> Any:
    return pc.simulate(PAIR, pc.Loads({1: pc.cosine("0.75", "0.3")}), t_end=40)


def n_frames(image: Image.Image) -> int:
    return int(getattr(image, "n_frames", 1))


def test_mass_pin_and_cursors_are_where_the_run_is() -> None:
    film = plotting.animate(run(), duration=2)
    track, curve, portrait = film.figure.axes
    (block,) = (it for it in track.patches if isinstance(it, Rectangle) and it.get_zorder() == 4)

    for i in (0, 17, 50):
        film.show(i)
        x, v = run()(film.times[i])
        assert block.get_x() + 0.5 * block.get_width() == pytest.approx(x, abs=1e-12)
        assert (film.times[i], x) in [tuple(line.get_xydata()[0]) for line in curve.lines]
        assert (x, v) in [tuple(line.get_xydata()[0]) for line in portrait.lines]


def test_a_soft_stop_is_pressed_in_and_an_impact_flashes() -> None:
    film = plotting.animate(run(), duration=8)
    track = film.figure.axes[0]
    plates = [line for line in track.lines if line.get_zorder() == 3 and line.get_linewidth() == 3]
    (star,) = (line for line in track.lines if line.get_marker() == "*")
    seen = FLASH * (film.times[1] - film.times[0])
    pressed = flashed = 0

    for i, time in enumerate(film.times):
        film.show(i)
        x = float(run()(time)[0])
        assert plates[0].get_xdata()[0] == max(x, 1.2)
        pressed += x > 1.2
        recent = bool(np.any((run().impacts.t <= time) & (run().impacts.t >= time - seen)))
        assert len(star.get_xdata()) == recent
        flashed += int(recent)

    assert pressed > 5
    assert 5 < flashed < film.times.size


def test_a_structure_has_a_line_for_each_displacement_to_one_scale() -> None:
    film = plotting.animate(motion(), on=[0, 1, (1, -1)], duration=1)
    tracks = film.figure.axes[::2]

    assert len({axes.get_xlim() for axes in tracks}) == 1
    assert [axes.get_ylabel() for axes in tracks] == ["$x_{0}$", "$x_{1}$", "$x_{0} - x_{1}$"]
    film.show(10)
    blocks = [next(it for it in axes.patches if it.get_zorder() == 4) for axes in tracks]
    centres = [block.get_x() + 0.5 * block.get_width() for block in blocks]
    x = motion()(film.times[10])[0]
    np.testing.assert_allclose(centres, [x[0], x[1], x[0] - x[1]], rtol=0, atol=1e-12)
    film.show()
    x = motion()(film.times[0])[0]
    assert blocks[0].get_x() + 0.5 * blocks[0].get_width() == pytest.approx(x[0], abs=1e-12)


def test_a_gif_plays_at_its_rate(tmp_path: Path) -> None:
    film = plotting.animate(run(), window=(0, 6), duration=1, fps=20)

    film.write(tmp_path / "film.gif")

    with Image.open(tmp_path / "film.gif") as image:
        assert n_frames(image) == film.times.size == 21
        assert image.info["duration"] == 50
        assert image.info["loop"] == 0
        assert image.width == 880
    with pytest.raises(OutputError, match=r"film\.gif: exists already"):
        film.write(tmp_path / "film.gif")


def test_a_page_holds_all_frames_and_asks_for_nothing_else(tmp_path: Path) -> None:
    film = plotting.animate(run(), window=(0, 6), duration=1, fps=10)

    film.write(tmp_path / "film.html")

    text = (tmp_path / "film.html").read_text()
    assert not re.search(r"https?:|src=\"(?!\")|href=", text)
    frames = json.loads(re.search(r"images = (\[.*?\])", text)[1])  # type: ignore[index]
    shown = [Image.open(io.BytesIO(base64.b64decode(it))).convert("RGBA") for it in frames]
    assert len(shown) == 11
    # The first frame with a later one on it is that later frame.
    whole = np.asarray(Image.alpha_composite(shown[0], shown[7]).convert("RGB")).astype(int)
    true = np.asarray(list(film.frames())[7]).astype(int)
    assert np.mean(np.abs(whole - true) > 40) < 1e-4


def test_a_film_that_is_stopped_ends_there(tmp_path: Path) -> None:
    film = plotting.animate(run(), duration=1)

    film.write(tmp_path / "film.gif", progress=lambda done, _: done < 7)

    with Image.open(tmp_path / "film.gif") as image:
        assert n_frames(image) == 7


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"duration": 0}, "duration = 0: not a positive number"),
        ({"fps": float("nan")}, "fps = nan: not a positive number"),
        ({"duration": 500}, "12501 frames at 25 a second; a film has 2 to 5000"),
        ({"window": (90, 99)}, "window = .*outside the run"),
        ({"on": [0]}, r"on = \[0\]: given for the run of an oscillator"),
    ],
)
def test_what_is_no_film_is_one_sentence(options: dict[str, object], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        plotting.animate(run(), **options)


def test_formats_that_cannot_be_written_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    film = plotting.animate(run(), duration=1)
    with pytest.raises(OutputError, match=r"not one of \.gif, \.html, \.mp4"):
        film.write(tmp_path / "film.avi")
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(OutputError, match=r"MP4 needs the program ffmpeg; choose \.gif or \.html"):
        film.write(tmp_path / "film.mp4")
    with pytest.raises(ParameterError, match="7 lines; give 1 to 6"):
        plotting.animate(motion(), on=[0] * 7)


def test_a_study_has_its_film_drawn(tmp_path: Path) -> None:
    study = parse_study(
        '[oscillator]\nstiffness = 1\n[[oscillator.stops]]\ntype = "wall"\nat = 0\n'
        'side = "below"\n[start]\nx0 = 0\nv0 = 1\n[run]\nt_end = 9\n'
        "[save]\ncsv = false\nnetcdf = false\n[draw]\npng = false\nsvg = false\n"
        'animation = "gif"\nwindow = [0, 5]\n'
    )

    result = run_study(study, tmp_path)

    assert [file.name for file in result.files] == ["motion.gif"]
    with Image.open(tmp_path / "motion.gif") as image:
        assert n_frames(image) == 251
