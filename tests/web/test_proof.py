"""What the page says is proven is what `percuss.certify` proves."""

from __future__ import annotations

import re
import time
from typing import Any

import pytest
from tests.web.frames import read_frame

import percuss as pc
from percuss.certified import prove_chaos
from percuss.web import proof
from percuss.web.proof import answer_certify
from percuss.web.request import BadRequest, PageRequest, RunningRequest


def certified(study: dict[str, Any], digits: Any = 12) -> dict[str, Any]:
    frames = list(
        answer_certify(PageRequest(4, "certify", study, {"digits": digits}), RunningRequest())
    )
    assert len(frames) == 1
    return read_frame(frames[0])[0]


def test_a_run_is_proven_to_its_end(study: dict[str, Any]) -> None:
    header = certified(study, 20)
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    run = pc.simulate(osc, pc.cosine("2.8"), v0="0.5", periods=40)
    proven = pc.certify(run, 20)

    assert header["done"]
    assert header["complete"]
    assert header["n_impacts"] == len(proven.impacts) == len(run.impacts)
    assert header["until"] == pytest.approx(run.t_end)
    assert "20 asked for" in header["report"]["digits"]
    number, t, v = header["lines"][-1]
    assert int(number) == len(run.impacts)
    middle, radius = re.findall(r"[-\d.e]+", t.replace("+/-", ""))
    assert proven.impacts.t[-1].contains(middle) or float(radius) < 1e-18
    assert float(middle) == pytest.approx(run.impacts.t[-1], rel=1e-12)
    assert "+/-" in v
    assert header["followed"] == {
        "n": len(run.impacts),
        "t": pytest.approx(run.impacts.t[-1]),
        "whole": True,
    }


def chaotic(study: dict[str, Any], periods: int) -> dict[str, Any]:
    study["oscillator"] |= {"damping": 0}
    study["oscillator"]["stops"][0]["at"] = 0
    study["start"] = {"x0": 0, "v0": -1}
    return study | {"run": {"periods": periods}}


def test_it_is_told_up_to_where_double_precision_follows_chaos(study: dict[str, Any]) -> None:
    header = certified(chaotic(study, 200))

    assert header["complete"]
    followed = header["followed"]
    assert not followed["whole"]
    assert 10 < followed["n"] < header["n_impacts"]
    assert followed["t"] < header["until"]


def test_the_time_is_bounded_and_what_is_proven_by_then_is_told(
    study: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(proof, "PATIENCE", 0.2)
    began = time.process_time()
    header = certified(chaotic(study, 4000))

    assert time.process_time() - began < 5.0
    assert not header["complete"]
    assert "interrupted" in header["report"]["proof"]
    assert header["n_impacts"] > 0
    assert 0.0 < header["until"] < 4000 * 2.25


def chaos_of(study: dict[str, Any]) -> dict[str, Any]:
    request = PageRequest(4, "certify", study, {"of": "chaos"})
    (answer,) = answer_certify(request, RunningRequest())
    return read_frame(answer)[0]


def test_chaos_is_proven_as_prove_chaos_does(study: dict[str, Any]) -> None:
    header = chaos_of(chaotic(study, 40))

    assert header["complete"]
    proven = prove_chaos(pc.impact_oscillator("0.8", wall=0, side="above"), pc.cosine("2.8"))
    assert proven
    assert f"at least {proven.entropy.mid():.6g} an impact" in header["report"]["entropy"]
    assert str(len(proven.loops[-1])) in header["report"]["certified"]
    assert f"between {len(proven.sets)} sets" in header["report"]["proof"]


def test_where_chaos_is_not_proven_it_says_why(study: dict[str, Any]) -> None:
    study["forcing"]["harmonics"][0]["omega"] = "2.5"
    calm = chaos_of(chaotic(study, 40))
    free = {key: table for key, table in study.items() if key != "forcing"}
    still = chaos_of(free | {"run": {"t_end": 40}})

    assert not calm["complete"]
    assert "no saddle with one impact a period was found" in calm["report"]["certified"]
    assert "saddle=" not in calm["report"]["certified"]
    assert not still["complete"]
    assert "without forcing" in still["report"]["certified"]
    request = PageRequest(4, "certify", study, {"of": "peace"})
    with pytest.raises(BadRequest, match="of is none of run, chaos, orbits, basins"):
        list(answer_certify(request, RunningRequest()))


def of_system(study: dict[str, Any], of: str, **options: Any) -> dict[str, Any]:
    request = PageRequest(4, "certify", study, {"of": of, **options})
    (answer,) = answer_certify(request, RunningRequest())
    return read_frame(answer)[0]


def test_all_orbits_are_proven_as_list_orbits_does(study: dict[str, Any]) -> None:
    header = of_system(chaotic(study, 40), "orbits")

    assert header["complete"]
    (orbit,) = pc.find_orbits(
        pc.impact_oscillator("0.8", wall=0, side="above"), pc.cosine("2.8"), 1, 1
    )
    assert "1 orbit with 1 impact in 1 forcing period" in header["report"]["certified"]
    v = float(re.findall(r"v_after = \[?(-?[\d.]+)", header["report"]["orbit 1"])[0])
    assert v == pytest.approx(orbit.impacts.v_after[0], rel=1e-9)
    assert header["report"]["orbit 1"].endswith("unstable")
    free = {key: table for key, table in study.items() if key != "forcing"}
    still = of_system(free | {"run": {"t_end": 40}}, "orbits")
    assert not still["some"]
    assert "without forcing" in still["report"]["certified"]


def test_basins_are_proven_in_the_square_of_starts(
    study: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(proof, "CELLS", 3)
    study = chaotic(study, 40)
    study["oscillator"]["stops"][0] |= {"side": "below", "restitution": "0.6"}
    study["forcing"]["harmonics"][0]["omega"] = "2.2"
    study["start"] = {"x0": "0.2", "v0": 0}
    square = {"x_low": 0.1, "x_high": 0.3, "v_low": 0.25, "v_high": 0.4}

    header = of_system(study, "basins", **square)
    wide = of_system(study, "basins", **square | {"x_low": -0.1})
    grazing = of_system(study, "basins", x_low=0.001, x_high=0.002, v_low=-0.001, v_high=9)

    assert header["complete"]
    assert "of 9 cells of starts all motions go to one orbit" in header["report"]["certified"]
    assert header["report"]["attractor 0"].startswith("1 impact in 1 period: 100.0% of the area")
    assert wide["some"]
    assert not wide["complete"]
    assert not grazing["some"]
    assert grazing["report"]["certified"].startswith("nothing: of no cell")
    with pytest.raises(BadRequest, match="is not below"):
        of_system(study, "basins", x_low=1, x_high=0)


def test_where_nothing_can_be_decided_it_says_why(study: dict[str, Any]) -> None:
    # At V0 = 1/2 the elastic motion under sin 3t grazes the wall.
    study["oscillator"] = {
        "stiffness": 1,
        "stops": [{"type": "wall", "at": 0, "side": "below", "restitution": 1}],
    }
    study["forcing"] = {"harmonics": [{"amplitude": 1, "omega": 3, "phase": "-pi/2"}]}
    study["start"] = {"x0": 0, "v0": "1/2"}
    header = certified(study)

    assert not header["complete"]
    assert len(header["report"]["proof"]) > 20


@pytest.mark.parametrize("digits", [0, 101, "12", True, float("nan")])
def test_digits_are_a_number_in_bounds(study: dict[str, Any], digits: Any) -> None:
    with pytest.raises(BadRequest, match="digits"):
        certified(study, digits)


def test_a_proof_that_nobody_wants_is_not_told(study: dict[str, Any]) -> None:
    request = PageRequest(4, "certify", study, {"digits": 12})
    assert list(answer_certify(request, RunningRequest(is_cancelled=True))) == []
