"""The tables of a study file to a study, with every fault of its shape and of its physics."""

from __future__ import annotations

from percuss.studies.faults import shown
from percuss.studies.kinds import kind_named, kind_names
from percuss.studies.model_building import engineers_model, forcing_of, oscillator_of, per_mass
from percuss.studies.parts import Parts, Table, exact_phase, table_of
from percuss.studies.schema import AnyDocument
from percuss.studies.shape import Found, shape_faults, unknown_value
from percuss.studies.study import Certify, Draw, Save, Study


def build(document: Table, found: Found) -> Study | None:
    """Return the study of a document, None if it has faults; add the faults to those found.

    Parameters
    ----------
    document
        The tables as `tomllib` reads them, faulty ones too.
    found
        The faults found so far.

    Returns
    -------
    Study or None
        The study.
    """
    head = table_of(document, "study")
    name = head.get("kind", "motion")
    kind = kind_named(name) if name in kind_names() else None
    if kind is None and isinstance(name, str):
        found.add(("study", "kind"), unknown_value(name, kind_names()), shown(name))
    shape_faults(document, AnyDocument if kind is None else kind.shape, found)
    oscillator = oscillator_of(table_of(document, "oscillator"), found)
    forcing = forcing_of(table_of(document, "forcing"), found) if "forcing" in document else None
    given = engineers_model(table_of(document, "oscillator"), oscillator, forcing, found)
    if given is not None:
        oscillator, forcing = per_mass(given, found)
    if kind is None:
        return None
    question = kind.build(Parts(document, oscillator, forcing, found))
    if found.faults or question is None:
        return None
    draw = {**table_of(document, "draw")}
    if "window" in draw:
        draw["window"] = tuple(exact_phase(time) for time in draw["window"])
    return Study(
        oscillator=oscillator,
        forcing=forcing,
        question=question,
        title=head.get("title", ""),
        save=Save(**table_of(document, "save")),
        draw=Draw(**draw),
        given=given,
        certify=Certify(**table_of(document, "certify")) if "certify" in document else None,
    )
