"""Study files changed at random: every fault is told with its key, nothing hangs or breaks."""

from __future__ import annotations

import time

import pytest
from tests.studies.mutant_runs import Runner
from tests.studies.mutants import Mutant, mutant

from percuss.errors import StudyError
from percuss.studies import StudyFault, parse_study

# Words of the libraries beneath, which know nothing of study files.
FOREIGN = ("input should", "value error", "traceback", "errors.pydantic")
# Reading computes nothing [s of the processor].
LONGEST = 10.0


def problem_of(made: Mutant) -> str | None:
    """Return what is wrong with how a mutant is read, None if nothing is."""
    begun = time.process_time()
    try:
        study = parse_study(made.text, "s.toml")
    except StudyError as error:
        problem = _of_faults(error.faults, made)
    else:
        again = parse_study(study.text(), "again")
        problem = f"not refused: {made.wrong}" if made.wrong else None
        problem = problem if again.text() == study.text() else "not read back as it was written"
    used = time.process_time() - begun
    return problem if used < LONGEST else f"{used:.0f} s to read it"


def _of_faults(faults: tuple[object, ...], made: Mutant) -> str | None:
    if not faults:
        return "no fault told"
    for fault in faults:
        assert isinstance(fault, StudyFault)
        text = str(fault)
        if not fault.reason or "\n" in text or len(text) > 600:
            return f"not one sentence: {text!r:.700}"
        if any(words in text.lower() for words in FOREIGN):
            return f"not in our words: {text}"
    reported = [fault.path for fault in faults if isinstance(fault, StudyFault)]
    for wrong in made.wrong:
        name = ".".join(map(str, wrong))
        around = [path for path in reported if f"{path}.".startswith(f"{name}.")]
        around += [path for path in reported if f"{name}.".startswith(f"{path}.")]
        if not around:
            return f"{name} is wrong and not named, only {reported}"
    return None


def problems(first: int, last: int) -> dict[int, tuple[tuple[str, ...], str]]:
    found = {}
    for seed in range(first, last):
        made = mutant(seed)
        problem = problem_of(made)
        if problem is not None:
            found[seed] = made.changes, problem
    return found


def test_every_fault_of_a_mutant_is_reported_with_its_key() -> None:
    assert problems(0, 1000) == {}


@pytest.mark.nightly
def test_every_fault_of_ten_thousand_mutants_is_reported_with_its_key() -> None:
    assert problems(1000, 11_000) == {}


@pytest.mark.nightly
def test_mutants_that_are_studies_end_in_results_or_in_one_sentence() -> None:
    found = {}
    with Runner() as run:
        for seed in range(3000):
            problem = run(seed).get("problem")
            if problem is not None:
                found[seed] = mutant(seed).changes, problem

    assert found == {}
