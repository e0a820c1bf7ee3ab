"""Certificates of a run, an orbit, chaos and a complete list, which several files change."""

from __future__ import annotations

import pytest
from tests.certified.checker import SOFT, WALL, Claims, run_of

import percuss as pc
from percuss.certified import certificate, list_orbits, prove_chaos


@pytest.fixture(scope="session")
def run() -> Claims:
    return certificate(run_of(SOFT, pc.cosine("11/10"), v0="1/2", t_end=12))


@pytest.fixture(scope="session")
def orbit() -> Claims:
    return certificate(pc.certify(pc.find_orbit(WALL, pc.cosine("14/5"))))


@pytest.fixture(scope="session")
def chaos() -> Claims:
    return certificate(prove_chaos(WALL, pc.cosine("14/5"), most_orbits=1))


@pytest.fixture(scope="session")
def complete() -> Claims:
    return certificate(list_orbits(WALL, pc.cosine("14/5"), speeds=("1/5", 3)))
