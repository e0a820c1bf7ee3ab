"""The sections of the report: what each is about, and which modules belong to it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ReportSection:
    """A section of the report.

    Parameters
    ----------
    name
        Its anchor in the page.
    title
        Its heading.
    about
        What it is about, for a reader who does not know the article. No result stands here.
    modules
        Modules of `percuss.paper` whose figures and statements it shows.
    """

    name: str
    title: str
    about: str
    modules: tuple[str, ...]


SECTIONS = (
    ReportSection(
        "model",
        "The oscillator",
        "A mass on a spring that is stiffer on one side of its equilibrium than on the other is a "
        "bilinear oscillator; with no limit to that stiffness it is an impact oscillator, which "
        "rebounds from a rigid wall. The article asks when its motion is periodic and when a "
        "periodic force makes it grow without bound.",
        ("figures.bilinear_motion",),
    ),
    ReportSection(
        "impact-times",
        "Sets of impact times, and an example",
        "Without a force the oscillator hits its wall at the times 0, π, 2π, ... whatever its "
        "speed: the eigenset. The article asks which forced motions share a set of impact times, and "
        "constructs a family of forces whose motions hit the wall at a subset of the eigenset only.",
        ("claims.family", "figures.family_figures"),
    ),
    ReportSection(
        "harmonics",
        "Forces commensurate with the oscillator",
        "Under sin nt with even n, the article says, the impact oscillator gains the same speed at "
        "every impact, a resonance; with odd n it keeps its speed as long as that is above a "
        "critical value, below which it meets the wall at other times.",
        (
            "claims.harmonics",
            "figures.multi_harmonic",
            "figures.third_harmonic",
            "figures.ninth_harmonic",
        ),
    ),
    ReportSection(
        "half-harmonic",
        "The half-harmonic",
        "Under sin t, at half the resonant frequency, the article finds impact times that are not "
        "periodic but approach the eigenset, while the speed grows as the square root of time.",
        ("claims.half_harmonic", "figures.half_harmonic_figures"),
    ),
    ReportSection(
        "cosine",
        "The same frequency at another phase",
        "Under cos t the article finds steady motions on the eigenset, and growth in the single case "
        "of a start from rest.",
        ("claims.cosine", "figures.cosine_figures"),
    ),
    ReportSection(
        "periodicity",
        "What the article concludes in words",
        "Statements of the introduction, the discussion and the conclusion.",
        ("claims.periodicity",),
    ),
    ReportSection(
        "limits",
        "From smooth to bilinear, from bilinear to rigid",
        "Beyond the article: how fast the motion of a stiff bilinear oscillator tends to that of the "
        "impact oscillator, and whether a rounded force law tends to the bilinear one.",
        ("claims.limits", "figures.limit_figures"),
    ),
    ReportSection(
        "resonances",
        "Which frequencies resonate",
        "Beyond the article: at which frequencies an elastic, undamped impact oscillator grows at all, "
        "and which peaks are left of that when impacts and damping take energy.",
        (
            "claims.resonances",
            "figures.resonance_figures",
            "claims.resonance_losses",
            "figures.loss_figures",
        ),
    ),
)
