"""Where the machine code of kernels is kept between processes.

numba keeps the machine code of a function beside a stamp of the one file that holds it, but that
machine code has its callees inlined: an edit of a callee's file leaves the caller stale, silently.
Here the name of each cache file carries a hash of all kernel files instead, so code that was
compiled from other text is never found (docs/decisions/002-compile-cache.md).
"""

from __future__ import annotations

import builtins
import contextlib
import functools
import hashlib
import sys
from importlib import resources
from pathlib import Path

from numba.core.caching import CompileResultCacheImpl, FunctionCache


@functools.cache
def _sources_hash() -> str:
    """Hash the names and contents of all Python files of this folder, once a process."""
    digest = hashlib.sha256()
    for file in sorted(resources.files(__package__).iterdir(), key=lambda entry: entry.name):
        if file.name.endswith(".py"):
            content = file.read_bytes()
            digest.update(f"{file.name} {len(content)}\n".encode())
            digest.update(content)
    return digest.hexdigest()[:20]


@functools.cache
def _tell_of_the_wait() -> None:
    """Say once a process, to someone who sits there, why the first call takes its time."""
    terminal = sys.stderr is not None and sys.stderr.isatty()
    if terminal or hasattr(builtins, "__IPYTHON__"):
        sys.stderr.write("percuss: compiling (some ten seconds, once for an installation)\n")


class _NamedBySources(CompileResultCacheImpl):
    """Puts the hash of the sources into the names of a kernel's cache files."""

    def get_filename_base(self, fullname: str, abiflags: str) -> str:
        return str(super().get_filename_base(f"{fullname}-{_sources_hash()}", abiflags))


class KernelCache(FunctionCache):
    """The cache of one kernel: a help that never fails a computation."""

    _impl_class = _NamedBySources

    def load_overload(self, sig: object, target_context: object) -> object:
        """Load machine code; None where there is none that can be used."""
        try:
            found = super().load_overload(sig, target_context)
        except Exception:  # noqa: BLE001  a damaged file raises whatever unpickling it leads to
            with contextlib.suppress(OSError):
                self.flush()
            found = None
        if found is None:
            _tell_of_the_wait()
        return found

    def save_overload(self, sig: object, data: object) -> None:
        """Save machine code where that is possible, and remove what has become stale."""
        # The disk may be full, or the folder taken away since the function was decorated.
        with contextlib.suppress(OSError):
            super().save_overload(sig, data)
            self._remove_files_of_other_sources()

    def _remove_files_of_other_sources(self) -> None:
        name, _ = self._impl.filename_base.split(f"-{_sources_hash()}-")
        for file in Path(self.cache_path).glob(f"{name}-*-*.nb[ci]"):
            if not file.name.startswith(f"{name}-{_sources_hash()}-"):
                # Another process may have removed it first.
                file.unlink(missing_ok=True)
