"""The report of ``percuss doctor``: versions, cores, caches, a browser, and optional packages."""

from __future__ import annotations

import os
import platform
import shutil
import sys
from collections.abc import Callable, Iterator
from importlib import metadata, resources
from importlib.util import find_spec
from pathlib import Path

from percuss.version import __version__

# Optional packages: the extra, the modules it needs, and what they are for.
EXTRAS: dict[str, tuple[tuple[str, ...], str]] = {
    "certified": (("flint",), "proofs in ball arithmetic"),
    "cluster": (("distributed",), "many motions on a Dask cluster"),
    "design": (("scipy",), "designs by SciPy's optimisers"),
    "netcdf": (("h5netcdf", "h5py"), "NetCDF files of results"),
    "notebook": (("anywidget",), "the workbench in a notebook"),
    "paper": (("flint", "sympy", "typst"), "percuss paper"),
    "stores": (("zarr", "google_crc32c", "h5netcdf", "h5py"), "stores of long studies"),
    "web": (("starlette", "uvicorn", "websockets"), "percuss serve"),
}
NEEDED = ("numpy", "numba", "llvmlite", "xarray", "pydantic", "typer", "rich", "matplotlib",
          "pillow")  # fmt: skip
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "firefox", "msedge", "safari")


def facts() -> dict[str, str]:
    """Return the facts about this machine, in words by their names."""
    return dict(_facts())


def _facts() -> Iterator[tuple[str, str]]:
    place = str(resources.files("percuss"))
    yield "percuss", f"{__version__}, in {place}"
    yield "python", f"{platform.python_version()}, {sys.executable}"
    yield "system", f"{platform.system()} {platform.release()}, {platform.machine()}"
    yield "packages", ", ".join(f"{name} {_version(name)}" for name in NEEDED)
    from percuss.ensembles.engines import cores
    from percuss.ensembles.job import in_gigabytes, memory

    yield "cores", f"{cores()} for this process, of {os.cpu_count()}"
    yield "memory", f"{in_gigabytes(memory())} to be had"
    yield "kernels", _kernels()
    yield "film", _found(("ffmpeg",), "MP4 films too", "GIF and HTML films; MP4 needs ffmpeg")
    yield "browser", _found(BROWSERS, "percuss serve opens it", "none found; open the address")
    for extra, (modules, use) in EXTRAS.items():
        lacking = [name for name in modules if find_spec(name) is None]
        state = "there" if not lacking else f"{' and '.join(lacking)} missing; {advice(extra)}"
        yield extra, f"{use}: {state}"


def advice(extra: str) -> str:
    """Return how to install an extra; pip takes the percuss that is there, wherever it came from."""
    return f'pip install "percuss[{extra}]"'


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "missing"


def _kernels() -> str:
    """Return where the compiled kernels lie, and how many there are."""
    from percuss.kernels.march import march

    if not hasattr(march, "stats"):
        return "not compiled: NUMBA_DISABLE_JIT is set, and all is slow"
    where = march.stats.cache_path
    if where is None:
        return "each process compiles anew: no folder for them can be written; set NUMBA_CACHE_DIR"
    files = list(Path(where).glob("*.nbc"))
    if not files:
        return f"none compiled yet, the first run takes some ten seconds; they will lie in {where}"
    size = sum(file.stat().st_size for file in files) / 1e6
    return f"{len(files)} compiled, {size:.0f} MB, in {where}"


def _found(names: tuple[str, ...], use: str, otherwise: str) -> str:
    which: Callable[[str], str | None] = shutil.which
    program = next(filter(None, map(which, names)), None)
    return otherwise if program is None else f"{program}: {use}"
