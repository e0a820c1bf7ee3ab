from __future__ import annotations

from hypothesis import settings
from tests.children import listen_to_ctrl_c

# The first call of a kernel compiles it, which breaks any per-example deadline.
settings.register_profile("percuss", deadline=None, derandomize=True)
settings.load_profile("percuss")

listen_to_ctrl_c()
