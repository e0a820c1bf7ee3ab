"""The same bits under each choice of BLAS kernels, vector level, libm variant and processor."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest
from tests.reproducible.results import QUICK, digest

OLD_LIBM = "glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4,-AVX2_Usable,-FMA_Usable"
# Names that this machine does not have are passed over by all four.
PLAIN = {
    "OPENBLAS_CORETYPE": "Prescott",
    "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL",
    "GLIBC_TUNABLES": OLD_LIBM,
}
SETTINGS = {
    "haswell": {"OPENBLAS_CORETYPE": "Haswell"},
    "skylake": {"OPENBLAS_CORETYPE": "SkylakeX"},
    "plain": PLAIN,
    "generic": PLAIN | {"NUMBA_CPU_NAME": "generic"},
}


def digests(setting: dict[str, str], *words: str) -> dict[str, str]:
    """Return the digests that a process under a setting prints."""
    own = {name for changed in SETTINGS.values() for name in changed}
    around = {name: value for name, value in os.environ.items() if name not in own}
    command = [sys.executable, "-m", "tests.reproducible.results", *words]
    done = subprocess.run(
        command, env=around | setting, capture_output=True, text=True, check=False, timeout=600
    )
    assert done.returncode == 0, done.stderr
    found: dict[str, str] = json.loads(done.stdout)
    return found


def test_without_fused_products_and_vectors_motions_and_orbits_have_the_same_bits() -> None:
    expected = {name: digest(value) for part in QUICK for name, value in part().items()}

    assert digests(PLAIN, "quick") == expected


@pytest.mark.nightly
@pytest.mark.parametrize("setting", SETTINGS)
def test_all_results_have_the_same_bits_under_each_setting(setting: str) -> None:
    assert digests(SETTINGS[setting]) == digests({})
