"""Study files read, written and read again; and the sentences of faults."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

from tests.studies.mutants import mutant

import percuss as pc
from percuss.errors import PercussError, StudyError
from percuss.studies import parse_study
from percuss.studies.templates import template_names, template_text

ROOT = Path(__file__).parents[2]
N_MUTANTS = 120
COCO = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
ORBIT = "forcing.omega"
CALLS: tuple[Callable[[], object], ...] = (
    lambda: pc.Oscillator(1, "-"),
    lambda: pc.Oscillator("1/0"),
    lambda: pc.Oscillator(1, 0, (pc.Wall(0, "below", 2),)),
    lambda: pc.Wall("a"),  # type: ignore[call-arg]
    lambda: pc.Wall(0, "left"),  # type: ignore[arg-type]
    lambda: pc.SoftStop(0, "above", -1),
    lambda: pc.Oscillator(1, 0, (pc.Wall(1, "below"), pc.Wall(-1, "above"))),
    lambda: pc.cosine(0),
    lambda: pc.cosine("nan"),
    lambda: pc.fourier(1, cos=(), sin=()),
    lambda: pc.simulate(COCO),
    lambda: pc.simulate(COCO, t_end=-1),
    lambda: pc.simulate(COCO, periods=3),
    lambda: pc.simulate(COCO, pc.cosine(1), x0=2, t_end=1),
    lambda: pc.simulate(COCO, pc.cosine(1), max_impacts=-1),
    lambda: pc.simulate(COCO, pc.cosine(1), t_end=1, periods=2),
    lambda: pc.simulate(COCO, pc.cosine(1), t_end=9)(10.0),
    lambda: pc.find_orbit(COCO, pc.cosine(1), -1),
    lambda: pc.find_orbit(COCO, pc.cosine(1, amplitude="0.01"), 1),
    lambda: pc.find_orbits(COCO, pc.cosine(1), max_impacts=0),
    lambda: pc.continue_orbit(pc.find_orbit(COCO, pc.cosine(1)), over={}),
    lambda: pc.continue_orbit(pc.find_orbit(COCO, pc.cosine(1)), over={"forcing.omga": (1, 2)}),
    lambda: pc.continue_orbit(pc.find_orbit(COCO, pc.cosine(1)), over={"forcing.omega": (2, 3)}),
    lambda: pc.sweep("no_measure", COCO, pc.cosine(1), over={"forcing.omega": (1, 2)}),
    lambda: pc.sweep("period", COCO, pc.cosine(1), over={"oscillator.stops.4.at": (1, 2)}),
    lambda: pc.basins(COCO, pc.cosine(1), x0=(2, 3), v0=(0, 1)),
    lambda: pc.lyapunov_exponents(COCO, pc.cosine(1), periods=0),
    lambda: pc.spectrum(pc.simulate(COCO, pc.cosine(1), t_end=9), omega=[-1.0, 1.0]),
    lambda: pc.classify_impact_times(pc.simulate(COCO, t_end=9)),
    lambda: pc.load_store("/nowhere"),
    lambda: pc.certify(pc.find_orbit(COCO, pc.cosine(1)), 0),
)


def studies() -> dict[str, str]:
    """Return study files as they are written after they have been read."""
    files = sorted((ROOT / "examples").rglob("*.toml"))
    texts = {path.name: path.read_text(encoding="utf-8") for path in files}
    texts |= {f"template {name}": template_text(name) for name in template_names()}
    found = {}
    for name, text in texts.items():
        written = parse_study(text, name, folder=ROOT / "examples").text()
        assert parse_study(written, name).text() == written, name
        found[name] = written
    return found


def faults() -> dict[str, list[str]]:
    """Return what mutants of study files and wrong calls are told."""
    found = {}
    for seed in range(N_MUTANTS):
        try:
            parse_study(mutant(seed).text, "s.toml")
        except StudyError as error:
            found[f"mutant {seed}"] = [str(fault) for fault in error.faults]
    for k, call in enumerate(CALLS):
        with warnings.catch_warnings(record=True) as warned:
            warnings.simplefilter("always")
            try:
                call()
            except PercussError as error:
                found[f"call {k}"] = [str(error)]
            except TypeError as error:
                found[f"call {k}"] = [type(error).__name__]
            else:
                found[f"call {k}"] = ["accepted"]
        found[f"call {k}"] += [str(warning.message) for warning in warned]
    return found


def frozen() -> dict[str, object]:
    """Return studies and sentences."""
    return {**studies(), **faults()}
