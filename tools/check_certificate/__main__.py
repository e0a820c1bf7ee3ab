"""Check a certificate of percuss, of an oscillator with stops.

Of a run, an orbit, a branch or a special point of one, a complete list, basins or chaos:

    python tools/check_certificate certificate.json

The file says what is claimed; this program proves it anew or refuses it. It uses Python's integers
and fractions alone: no percuss, no library, no floating point. The folder can be copied anywhere.
It prints the theorem and ends with status 0, or says in a sentence what is not proven and ends with
status 1.

Modules use those before them: `arithmetic`, `words`, `flights`, `reading` and `parts`, then one for
each kind of certificate: `runs`, `orbits`, `branches`, `lists`, `basins` and `chaos`. Of these
`branches`, `lists` and `basins` use `orbits`; who reads one of the others needs none but it.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from arithmetic import NotProvenError
from theorems import theorem


def main(arguments: Sequence[str]) -> int:
    if len(arguments) != 1:
        print("python check_certificate certificate.json", file=sys.stderr)
        return 2
    try:
        print(f"PROVEN. {theorem(Path(arguments[0]).read_text(encoding='utf-8'))}")
    except (OSError, UnicodeDecodeError, NotProvenError) as error:
        print(f"NOT PROVEN: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
