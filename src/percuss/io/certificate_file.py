"""Certificates of proofs as JSON files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from percuss.io.files import OutputFiles

if TYPE_CHECKING:
    # Needs python-flint.
    from percuss.certified import (
        CertifiedBasins,
        CertifiedBranch,
        CertifiedChaos,
        CertifiedOrbit,
        CertifiedPoint,
        CertifiedRun,
        CompleteList,
    )


def save_certificate(
    result: CertifiedRun
    | CertifiedOrbit
    | CertifiedPoint
    | CertifiedBranch
    | CertifiedChaos
    | CompleteList
    | CertifiedBasins,
    path: Path | str,
    *,
    force: bool = False,
) -> None:
    """Save what a proof claims, which ``python tools/check_certificate FILE`` proves again.

    Parameters
    ----------
    result
        Of `certify`, or of `percuss.certified.prove_chaos`, `percuss.certified.list_orbits` or
        `percuss.certified.prove_basins`.
    path
        The file.
    force
        Whether a file of this name may be replaced.

    Raises
    ------
    OutputError
        If the file exists and `force` is false, or cannot be written.
    ParameterError
        As `percuss.certified.certificate` does: if there is no certificate of the result.

    Examples
    --------
    >>> import tempfile
    >>> import percuss as pc
    >>> file = Path(tempfile.mkdtemp()) / "run.json"
    >>> run = pc.simulate(pc.impact_oscillator("4/5"), v0=1, max_impacts=3)
    >>> pc.save_certificate(pc.certify(run), file)
    >>> json.loads(file.read_text())["kind"]
    'run'
    """
    from percuss.certified import certificate

    text = json.dumps(certificate(result), indent=1)
    with OutputFiles(path, force=force) as files:
        files[path].write_text(f"{text}\n", encoding="utf-8")
