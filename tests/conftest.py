from __future__ import annotations

from hypothesis import settings

# The first call of a kernel compiles it, which breaks any per-example deadline.
settings.register_profile("percuss", deadline=None, derandomize=True)
settings.load_profile("percuss")
