from __future__ import annotations

import numpy as np
import pytest
from tests.reference.measures import Case, load_cases

import percuss as pc


@pytest.mark.parametrize("case", load_cases(), ids=lambda case: case.id)
def test_run_gives_the_reference_values(case: Case) -> None:
    x0, v0, t0 = case.start()

    run = pc.simulate(case.oscillator(), case.force(), x0, v0, t0, **case.limits())

    np.testing.assert_allclose(case.measured(run), case.expected, rtol=0, atol=case.tolerance)
