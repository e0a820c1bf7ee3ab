"""``python -m percuss``: the same as the command ``percuss``."""

from __future__ import annotations

from percuss.cli import main

if __name__ == "__main__":
    main()
