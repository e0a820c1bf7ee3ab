"""A run as a film: the mass moves between its stops, and its curves show the same time."""

from __future__ import annotations

import base64
import io
import json
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain
from pathlib import Path
from string import Template
from typing import Any, TypeVar, cast

import numpy as np
from matplotlib.animation import FFMpegWriter
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from PIL import Image

from percuss.arrays import Floats
from percuss.errors import OutputError, ParameterError
from percuss.io.files import OutputFiles
from percuss.model.exact import as_float
from percuss.model.oscillator import On, SoftStop
from percuss.model.units import Units
from percuss.motion.structures import StructureTrajectory
from percuss.motion.trajectory import Trajectory
from percuss.plotting.direction_view import (
    DirectionView,
    Drawable,
    direction_name,
    shown_lines,
    view_of,
)
from percuss.plotting.marks import draw_stops
from percuss.plotting.motion_plot import plot_displacement, plot_phase_portrait
from percuss.plotting.samples import sample_curve, window_of, within
from percuss.plotting.style import (
    BLACK,
    BLUE,
    GREY,
    ORANGE,
    VERMILION,
    fix_ticks,
    offscreen_figure,
    style,
    title_figure,
    units_of,
)
from percuss.progress import Progress, Report

# Suffixes of the files of films.
FORMATS = (".gif", ".html", ".mp4")
# More are minutes of drawing, and a file that no mail takes.
MOST_FRAMES = 5000
# More displacements would be too low to be read.
MOST_TRACKS = 6
# Width [inch] of a film and its pixels per inch.
WIDTH, DPI = 8.0, 110.0
# Of the height of the moving picture: the stops, and above them the mass with what holds it.
STOPS, BOTTOM, TOP, SPRING, DASHPOT = (0.0, 0.42), 0.5, 0.94, 0.82, 0.62
# Of the range of displacements: the width of the mass, and the room on the left for its spring.
BLOCK, ROOM = 0.1, 0.3
# A spring: its coils, and how high they swing as a part of the height.
COILS, SWING = 7, 0.07
# Colours of a film, and the number of one more, through which the first frame is seen.
COLOURS, CLEAR = 200, 255
# An impact is seen for so many frames.
FLASH = 3


class Film:
    """A run as a film, which notebooks show with a slider.

    Attributes
    ----------
    times
        (n,) the times of the run that its frames show [time].
    fps
        Frames a second.
    figure
        The figure, as `show` has left it.

    Examples
    --------
    >>> import percuss as pc
    >>> osc = pc.Oscillator(stiffness=1, stops=[pc.Wall(at=0, side="below")])
    >>> film = animate(pc.simulate(osc, v0=1, t_end=9), duration=2)
    >>> film
    <Film: 51 frames, 25 a second, t = 0 to 9>
    """

    def __init__(self, figure: Figure, actors: Sequence[_Actor], times: Floats, fps: float) -> None:
        self.times, self.fps = times, fps
        self.figure, self._actors = figure, actors

    def __repr__(self) -> str:
        span = f"t = {self.times[0]:.6g} to {self.times[-1]:.6g}"
        return f"<Film: {self.times.size} frames, {self.fps:g} a second, {span}>"

    def _repr_html_(self) -> str:
        page = _page(self.frames(), self.times, self.fps)
        text = page.replace("&", "&amp;").replace('"', "&quot;")
        width, height = (int(DPI * size) + 1 for size in self.figure.get_size_inches())
        return (
            f'<iframe srcdoc="{text}" title="film of a motion" '
            f'style="border:0;width:{width}px;height:{height + 60}px"></iframe>'
        )

    def frames(self) -> Iterator[Image.Image]:
        """Yield the frames, one after the other.

        Yields
        ------
        PIL.Image.Image
            A frame, 880 pixels wide.
        """
        canvas = FigureCanvasAgg(self.figure)
        self.figure.set_dpi(DPI)
        for actor in self._actors:
            for artist in actor.artists:
                artist.set_animated(True)
        # What stands still is drawn once.
        canvas.draw()  # type: ignore[no-untyped-call]
        still = canvas.copy_from_bbox(self.figure.bbox)  # type: ignore[no-untyped-call]
        for i in range(self.times.size):
            canvas.restore_region(still)  # type: ignore[no-untyped-call]
            self.show(i)
            for actor in self._actors:
                for artist in actor.artists:
                    actor.axes.draw_artist(artist)
            pixels = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
            yield Image.fromarray(pixels).convert("RGB")

    def show(self, i: int = 0) -> None:
        """Move everything to where it is in a frame, by default the first."""
        for actor in self._actors:
            actor.show(i)

    def write(
        self, path: Path | str, *, force: bool = False, progress: Report | bool | None = None
    ) -> None:
        """Write the film; the suffix is its format.

        Parameters
        ----------
        path
            The file: ``.gif``, ``.html`` (a page with a slider, which needs no network) or ``.mp4``
            (which needs the program ffmpeg).
        force
            Whether a file of that name may be replaced.
        progress
            As in `percuss.simulate`, counted in frames. A film that is stopped ends there.

        Raises
        ------
        OutputError
            If the format is another one, ffmpeg is missing, the file exists and `force` is false,
            or it cannot be written.
        """
        check_format(path)
        with OutputFiles(path, force=force) as files:
            self.render(files[path], Path(path).suffix, progress)

    def render(self, path: Path, suffix: str, progress: Report | bool | None = None) -> None:
        """Write the film in the format of `suffix` under the name `path`."""
        reported = Progress(progress, float(self.times.size), "frames")
        try:
            if suffix.lower() == ".gif":
                frames = _in_few_colours(_counted(self.frames(), reported))
                rate: dict[str, Any] = {"duration": round(1000.0 / self.fps), "loop": 0}
                next(frames).save(path, "GIF", save_all=True, append_images=frames, **rate)
            elif suffix.lower() == ".html":
                frames = _counted(self.frames(), reported)
                path.write_text(_page(frames, self.times, self.fps), encoding="utf-8")
            else:
                # The name of a part has no suffix from which ffmpeg could tell the format.
                writer = FFMpegWriter(fps=self.fps, extra_args=["-f", "mp4"])  # type: ignore[arg-type]
                with style(), writer.saving(self.figure, str(path), DPI):
                    for i in _counted(range(self.times.size), reported):
                        self.show(i)
                        writer.grab_frame()
        finally:
            reported.close()


@dataclass(frozen=True, slots=True)
class _Actor:
    """Artists of one axes that move, and what puts them where they are in frame i."""

    axes: Axes
    artists: tuple[Artist, ...]
    show: Callable[[int], None]


def check_format(path: Path | str) -> None:
    """Raise an OutputError if no film can be written under this name."""
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        raise OutputError(
            str(path), f"not one of {', '.join(FORMATS)}; choose one of these formats"
        )
    if suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise OutputError(str(path), "MP4 needs the program ffmpeg; choose .gif or .html")


def animate(
    run: Trajectory | StructureTrajectory,
    *,
    on: On | Sequence[On] | None = None,
    window: tuple[float, float] | None = None,
    duration: float = 10.0,
    fps: float = 25.0,
    units: Units | None = None,
    title: str | None = None,
) -> Film:
    """Make a film of a run: the mass between its stops to scale, and its curves at that time.

    Parameters
    ----------
    run
        The run.
    on
        Of a structure the coordinates, directions and names of points that are shown, each to
        scale on a line of its own with the stops on that line; default: all points, or where it
        has none all coordinates.
    window
        First and last time that are shown; default: the whole run.
    duration
        How long the film lasts [s].
    fps
        Frames a second.
    units
        Units on the axes; default: those of the model, or dimensionless.
    title
        Title of the film.

    Returns
    -------
    Film
        The film; `Film.write` makes a file of it.

    Raises
    ------
    ParameterError
        If the window lies outside the run, there is no such coordinate, there are more than 6 of
        them, or the film has no frame or more than 5000.

    Examples
    --------
    >>> import percuss as pc
    >>> osc = pc.Oscillator(stiffness=1, stops=[pc.Wall(at=0, side="below", restitution="0.8")])
    >>> animate(pc.simulate(osc, pc.cosine(1, 3), v0=1, t_end=30), window=(0, 12), fps=10)
    <Film: 101 frames, 10 a second, t = 0 to 12>
    """
    views = _views(run, on)
    model = run.structure if isinstance(run, StructureTrajectory) else run.oscillator
    units = units_of(units, model)
    low, high = window_of(views[0], window)
    times = np.linspace(low, high, _n_frames(duration, fps))
    with style():
        figure, tracks = _tracks(len(views))
        if title:
            title_figure(figure, title)
        limits = _draw_all_stops([track for track, _, _ in tracks], views, (low, high))
        actors: list[_Actor] = []
        for view, (track, curve, portrait) in zip(views, tracks, strict=True):
            x, v = view(times)
            actors.append(_mass_actor(track, view, limits, times, x))
            plot_displacement(run, curve, window=(low, high), units=units, on=_on(view))
            actors.append(_cursor(curve, times, x))
            if portrait is not None:
                plot_phase_portrait(run, portrait, window=(low, high), units=units, on=_on(view))
                actors.append(_dot(portrait, x, v))
                continue
            track.set_ylabel(_name(view), rotation=0, ha="right", va="center")
            curve.set_ylabel("")
            if curve is not tracks[-1][1]:
                curve.set_xlabel("")
        tracks[-1][0].set_xlabel(f"displacement ({units.displacement})")
    return Film(figure, actors, times, fps)


def _n_frames(duration: float, fps: float) -> int:
    """Return the number of frames of a film."""
    for name, value in (("duration", duration), ("fps", fps)):
        if not (math.isfinite(value) and value > 0.0):
            raise ParameterError(name, value, "not a positive number")
    frames = math.floor(duration * fps) + 1
    if not 2 <= frames <= MOST_FRAMES:
        reason = f"{frames} frames at {fps:g} a second; a film has 2 to {MOST_FRAMES}"
        raise ParameterError("duration", duration, reason)
    return frames


def _views(run: Trajectory | StructureTrajectory, on: On | Sequence[On] | None) -> list[Drawable]:
    """Return what has one displacement each: the run itself, or a structure along directions."""
    if isinstance(run, Trajectory):
        return [view_of(run, cast("On | None", on))]
    if not isinstance(run, StructureTrajectory):
        raise ParameterError("run", run, "neither a Trajectory nor a StructureTrajectory")
    shown = shown_lines(run.structure, on, MOST_TRACKS, "lines")
    return [view_of(run, direction) for direction in shown]


def _on(view: Drawable) -> On | None:
    return view.on if isinstance(view, DirectionView) else None


def _name(view: Drawable) -> str:
    return (
        f"${direction_name(view.run.structure, view.on)}$"
        if isinstance(view, DirectionView)
        else ""
    )


def _tracks(n: int) -> tuple[Figure, list[tuple[Axes, Axes, Axes | None]]]:
    """Return a figure, and for each displacement axes for the mass, the curve and the portrait.

    One displacement has the moving picture over the whole width, and below it the curve and the
    phase portrait; several have a line each, with the curve on the right.
    """
    if n == 1:
        figure = offscreen_figure(WIDTH, 4.6)
        grid = figure.add_gridspec(2, 2, height_ratios=(1.0, 2.2), width_ratios=(1.6, 1.0))
        axes = [figure.add_subplot(place) for place in (grid[0, :], grid[1, 0], grid[1, 1])]
        return figure, [(axes[0], axes[1], axes[2])]
    figure = offscreen_figure(WIDTH, 0.8 + 1.3 * n)
    panels = figure.subplots(n, 2, sharex="col", squeeze=False)
    for panel in panels[:-1].flat:
        panel.tick_params(labelbottom=False)
    return figure, [(left, right, None) for left, right in panels]


def _draw_all_stops(
    tracks: Sequence[Axes], views: Sequence[Drawable], window: tuple[float, float]
) -> tuple[float, float]:
    """Draw the stops on each line, all to one scale; return the range of displacements."""
    ends = []
    for ax, view in zip(tracks, views, strict=True):
        draw_stops(ax, view, sample_curve(view, window).x, "x", share=STOPS)
        ends.append(ax.get_xlim())
    low, high = min(end[0] for end in ends), max(end[1] for end in ends)
    room = ROOM if isinstance(views[0], Trajectory) else 0.6 * BLOCK
    for ax in tracks:
        ax.set_xlim(low - room * (high - low), high + 0.6 * BLOCK * (high - low))
    return low, high


def _mass_actor(
    ax: Axes, view: Drawable, limits: tuple[float, float], times: Floats, x: Floats
) -> _Actor:
    """Draw the mass with its spring and dashpot, and the plates of soft stops."""
    width = BLOCK * (limits[1] - limits[0])
    ax.set_ylim(0.0, 1.0)
    ax.set_yticks([])
    ax.spines["left"].set_visible(False)
    fix_ticks(ax)
    block = Rectangle((0.0, BOTTOM), width, TOP - BOTTOM, facecolor=BLUE, edgecolor=BLACK, zorder=4)
    ax.add_patch(block)
    # What meets the stops: the displacement itself.
    (pin,) = ax.plot([], [], color=BLACK, linewidth=2.0, zorder=5, solid_capstyle="round")
    (flash,) = ax.plot([], [], "*", color=VERMILION, markersize=15.0, zorder=6, linestyle="none")
    held: list[tuple[Line2D, Callable[[float], tuple[Floats, Floats]]]] = []
    if isinstance(view, Trajectory):
        held = _holders(ax, view)
    soft = [stop for stop in view.oscillator.stops if isinstance(stop, SoftStop)]
    plates = [ax.plot([], [], color=ORANGE, linewidth=3.0, zorder=3)[0] for _ in soft]
    seen = FLASH * float(times[1] - times[0])
    impacts = view.impacts.t

    def show(i: int) -> None:
        here = float(x[i])
        block.set_x(here - 0.5 * width)
        pin.set_data([here, here], [0.1, BOTTOM])
        recent = bool(within(impacts, float(times[i]) - seen, float(times[i])).any())
        flash.set_data([here] if recent else [], [0.5 * STOPS[1]] if recent else [])
        for line, shape in held:
            line.set_data(*shape(here - 0.5 * width))
        for plate, stop in zip(plates, soft, strict=True):
            at = as_float(stop.at)
            pressed = min(here, at) if stop.side == "below" else max(here, at)
            plate.set_data([pressed, pressed], [STOPS[0], STOPS[1]])

    lines = (line for line, _ in held)
    return _Actor(ax, (*lines, *plates, block, pin, flash), show)


def _holders(
    ax: Axes, view: Trajectory
) -> list[tuple[Line2D, Callable[[float], tuple[Floats, Floats]]]]:
    """Return the spring and the dashpot that an oscillator has, and their shapes up to the mass."""
    left = ax.get_xlim()[0]
    shapes = []
    if as_float(view.oscillator.stiffness) != 0.0:
        shapes.append(_spring)
    if as_float(view.oscillator.damping) != 0.0:
        shapes.append(_dashpot)
    if shapes:
        ax.axvspan(left, left, BOTTOM, TOP, color=GREY, linewidth=3.0)
    return [
        (ax.plot([], [], color=GREY, linewidth=1.2, zorder=3)[0], partial(shape, left))
        for shape in shapes
    ]


def _spring(left: float, right: float) -> tuple[Floats, Floats]:
    """Return the line of a spring between two displacements."""
    ends = np.array([0.0, 0.08])
    coils = 0.08 + 0.84 * (np.arange(2 * COILS) + 0.5) / (2 * COILS)
    share = np.concatenate([ends, coils, 1.0 - ends[::-1]])
    swing = np.concatenate([[0.0, 0.0], SWING * (-1.0) ** np.arange(2 * COILS), [0.0, 0.0]])
    return left + share * (right - left), SPRING + swing


def _dashpot(left: float, right: float) -> tuple[Floats, Floats]:
    """Return the lines of a dashpot: a cylinder on the left, a piston on the right."""
    share = np.array(
        [0.0, 0.3, math.nan, 0.7, 0.3, 0.3, 0.7, math.nan, 0.55, 0.55, math.nan, 0.55, 1.0]
    )
    height = np.array(
        [0.0, 0.0, math.nan, 1.0, 1.0, -1.0, -1.0, math.nan, 0.7, -0.7, math.nan, 0.0, 0.0]
    )
    return left + share * (right - left), DASHPOT + SWING * height


def _cursor(ax: Axes, times: Floats, x: Floats) -> _Actor:
    """Draw the time in a curve over time."""
    line = ax.axvline(times[0], color=GREY, linewidth=0.8)
    (dot,) = ax.plot([], [], "o", color=VERMILION, markersize=6.0, zorder=7)

    def show(i: int) -> None:
        line.set_xdata([times[i], times[i]])
        dot.set_data([times[i]], [x[i]])

    return _Actor(ax, (line, dot), show)


def _dot(ax: Axes, x: Floats, v: Floats) -> _Actor:
    """Draw the state in the phase portrait."""
    (dot,) = ax.plot([], [], "o", color=VERMILION, markersize=6.0, zorder=7)
    return _Actor(ax, (dot,), lambda i: dot.set_data([x[i]], [v[i]]))


Counted = TypeVar("Counted")


def _counted(items: Iterable[Counted], progress: Progress) -> Iterator[Counted]:
    """Yield items, up to where the caller of the progress asks to stop."""
    for item in items:
        yield item
        if not progress.advance():
            return


def _in_few_colours(frames: Iterator[Image.Image]) -> Iterator[Image.Image]:
    """Yield frames in the colours of the first: only what moves differs then, and is stored."""
    first = next(frames)
    palette = first.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    for frame in chain([first], frames):
        yield frame.quantize(palette=palette, dither=Image.Dither.NONE)


def _page(frames: Iterator[Image.Image], times: Floats, fps: float) -> str:
    """Return a page that plays frames, with all of them in it: the first, and what differs."""
    few = _in_few_colours(frames)
    first = next(few)
    still = np.asarray(first)
    # Of all 256 numbers: also that of the clear one has a place.
    palette = ((first.getpalette() or []) + 768 * [0])[:768]
    pictures = [_png_text(first)]
    for frame in few:
        here = np.asarray(frame)
        patch = Image.fromarray(np.where(here == still, CLEAR, here).astype(np.uint8), "P")
        patch.putpalette(palette)
        pictures.append(_png_text(patch, transparency=CLEAR))
    return PAGE.substitute(
        images=json.dumps(pictures),
        times=json.dumps(times.tolist()),
        rate=f"{fps:g}",
        width=first.width,
    )


def _png_text(image: Image.Image, **options: int) -> str:
    buffer = io.BytesIO()
    image.save(buffer, "PNG", **options)
    return base64.b64encode(buffer.getvalue()).decode()


PAGE = Template(
    """<!doctype html>
<html lang="en"><meta charset="utf-8"><title>Film of a motion</title>
<style>body{margin:0;max-width:${width}px;font:14px sans-serif;background:#fff;color:#000}
figure{position:relative;margin:0}img{display:block;width:100%}#moving{position:absolute;inset:0}
div{display:flex;gap:.6em;align-items:center;padding:.4em}input{flex:1}
button{min-width:5em;min-height:24px}output{min-width:7em}</style>
<figure><img id="still" alt="The mass, its displacement over time and its phase portrait">
<img id="moving" alt=""></figure>
<div><button type="button">Pause</button><input type="range" min="0" value="0" aria-label="Time">
<output></output></div>
<script>
const images = $images, times = $times, rate = $rate;
const [still, moving, button, slider, output] =
  ["#still", "#moving", "button", "input", "output"].map((name) => document.querySelector(name));
const source = (i) => "data:image/png;base64," + images[i];
still.src = source(0);
slider.max = images.length - 1;
let playing = !matchMedia("(prefers-reduced-motion: reduce)").matches, begun = null;
function show(i) {
  slider.value = i;
  moving.src = source(i);
  output.textContent = "t = " + times[i].toPrecision(6);
}
function say() { button.textContent = playing ? "Pause" : "Play"; begun = null; }
function step(now) {
  if (playing) {
    begun ??= now - slider.value / rate * 1000;
    show(Math.floor((now - begun) / 1000 * rate) % images.length);
  }
  requestAnimationFrame(step);
}
button.onclick = () => { playing = !playing; say(); };
slider.oninput = () => { playing = false; say(); show(+slider.value); };
show(0); say(); requestAnimationFrame(step);
</script>
</html>
"""
)
