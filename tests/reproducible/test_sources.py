"""No result goes through a function that differs between machines."""

from __future__ import annotations

import ast
import re
from importlib import resources
from pathlib import Path

import pytest

# Pictures may differ in a last digit; ball arithmetic rounds outwards, whatever it is given.
OUTSIDE = ("plotting", "web", "certified", "paper/figures", "paper/report")
ELEMENTARY = re.findall(
    r"\w+",
    "sin cos tan exp expm1 exp2 log log2 log10 log1p pow power float_power arctan2 atan2 arctan "
    "atan arcsin asin arccos acos cbrt sinh cosh tanh sinc dot vdot inner matmul einsum tensordot "
    "polyfit roots geomspace logspace angle convolve correlate",
)
# NumPy's hypot is the C library's; that of `math` is Python's own, from sums and products.
DIFFERENT = {("np", name) for name in [*ELEMENTARY, "hypot", "linalg"]}
DIFFERENT |= {(module, name) for module in ("math", "cmath") for name in ELEMENTARY}

# Products here are those of `numerics.wide.Wide`, which are percuss's own, and not of arrays.
PRODUCTS_OF_WIDE = ("model/structure_frames.py", "numerics/modes.py", "numerics/wide.py")


def calls_that_differ(text: str) -> list[str]:
    """Return what in a module is not the same to the bit on each machine."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
            found.append(f"line {node.lineno}: a product of matrices by BLAS")
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            name = node.value.id, node.attr
            if name in DIFFERENT:
                found.append(f"line {node.lineno}: {name[0]}.{name[1]}")
    return found


def modules() -> list[Path]:
    root = Path(str(resources.files("percuss")))
    files = (file.relative_to(root) for file in sorted(root.rglob("*.py")))
    return [file for file in files if not file.as_posix().startswith(OUTSIDE)]


@pytest.mark.parametrize("file", modules(), ids=str)
def test_a_module_takes_functions_from_numerics(file: Path) -> None:
    text = (Path(str(resources.files("percuss"))) / file).read_text(encoding="utf-8")

    differ = calls_that_differ(text)
    if file.as_posix() in PRODUCTS_OF_WIDE:
        differ = [call for call in differ if not call.endswith("BLAS")]
    assert differ == []


def test_what_differs_is_found() -> None:
    text = "import math\nimport numpy as np\na @ b\nnp.linalg.norm(a)\nmath.exp(1.0)\nnp.sin(a)\n"

    assert len(calls_that_differ(text)) == 4
