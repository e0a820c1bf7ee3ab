"""The studies of the records: each loads, opens in the workbench, and runs."""

from __future__ import annotations

import pytest

from percuss.execution import Execution
from percuss.paper.collection import items, statement_with_id
from percuss.studies import Motion, Response, Study, parse_study
from percuss.studies.link import link_of

RECORDS = {item.name: item for item in items() if item.kind == "statement"}
# Records that speak of no single motion, and why.
WITHOUT = {
    "eq24-other-root": "a root of an equation, which is no impact",
    "nonperiodic-others": "a deduction for all frequencies at once",
    "chain": "the derivation itself",
    "resonance-strength": "averages over flights of infinitely fast motions",
    "resonance-twist": "averages over thousands of flights",
}
# Fast ones of all kinds: forced and free, with walls, soft stops, losses, late starts; a chart.
QUICK = (
    "eq1", "eq9", "eq12", "eq14", "property2", "eq18", "fig5", "fig9", "eq29", "eq39",
    "periodicity-fig6b-times", "fig2-intervals", "smoothed-grazing", "losses-curve",
)  # fmt: skip
# Events of a run that the test follows.
MOST_EVENTS = 5000


def study_of(record: str) -> Study | None:
    text = statement_with_id(RECORDS[record]).find().study
    return parse_study(text, record) if text else None


def check(record: str, study: Study) -> None:
    """Open the study in the workbench, and follow its motion to the end that it names."""
    assert link_of(study)
    if isinstance(study.question, Response):
        result = study.question.answer(study, Execution())
        assert any(family.stable_ranges for family in result.families), record
    if isinstance(study.question, Motion):
        limits = study.question.limits
        run = study.question.answer(study, Execution())
        if limits.max_impacts is None:
            assert run.t_end == study.question.t_end(study.forcing), record
        elif limits.max_impacts <= MOST_EVENTS:
            assert len(run.impacts) == limits.max_impacts, record


@pytest.mark.parametrize("record", QUICK)
def test_the_study_of_a_record_opens_and_runs(record: str) -> None:
    study = study_of(record)

    assert study is not None
    check(record, study)


@pytest.mark.nightly
@pytest.mark.parametrize("record", RECORDS)
def test_every_record_has_a_study_that_opens_and_runs_or_a_reason(record: str) -> None:
    study = study_of(record)

    assert (study is None) == (record in WITHOUT)
    if study is not None:
        check(record, study)
