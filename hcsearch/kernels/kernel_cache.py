"""Compiled kernels on disk, one file for each kernel, stamp and signature.

numba's own cache is stamped with one file's content and lies beside it: it does not see edits of what a kernel calls,
and every clone compiles anew. This one takes its place through few doors: `_cache` of a dispatcher (the interface of
`numba.core.caching.NullCache`), its method `compile`, and `CompileResult._reduce` and `_rebuild`.
"""

from __future__ import annotations

import hashlib
import pickle
import time
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Any

from numba.core import compiler, serialize, types
from numba.core.caching import NullCache

from hcsearch.kernels import cache_locks
from hcsearch.kernels.cache_folder import prune, say, wanted_folder, writable_folder, write
from hcsearch.kernels.stamps import stamp

numba_compiler: Any = compiler  # has no types
numba_types: Any = types
dumps: Any = serialize.dumps
_DAY = 86400.0
_CHECKED = 16
"""Bytes of the checksum before what is kept."""


class KernelCache(NullCache):
    """What numba asks for the code of a dispatcher before it compiles, and gives it to afterwards."""

    _pruned = False

    def __init__(self, kernel: Any) -> None:
        self._kernel = kernel
        self._claims: list[tuple[Path, str]] = []
        self._compile = kernel.compile

    @classmethod
    def attach(cls, kernel: Any) -> None:
        """Give a dispatcher such a cache."""
        kernel._cache = cls(kernel)
        kernel.compile = kernel._cache.compile

    def compile(self, sig: Any) -> Any:
        """Compile, as the dispatcher does; whatever comes of it, other processes need not wait any more."""
        held = len(self._claims)  # of more signatures where a kernel calls itself
        try:
            return self._compile(sig)
        finally:
            while len(self._claims) > held:
                cache_locks.release(*self._claims.pop())

    @property
    def cache_path(self) -> str:
        """The folder."""
        return str(wanted_folder())

    @cached_property
    def _stamp(self) -> str:
        return stamp(self._kernel)

    def _file(self, signature: Any, codegen: Any) -> str:
        """The name of the file of a signature, on this processor."""
        text = f"{self._stamp} {_spelled(signature)} {codegen.magic_tuple()}"
        digest = hashlib.blake2b(text.encode(), digest_size=16).hexdigest()
        return f"{digest}-{self._kernel.__name__}.kernel"

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compile result of a signature; None where this process is to compile it."""
        target_context.refresh()
        name = self._file(sig, target_context.codegen())
        found = _read(wanted_folder() / name, target_context)
        folder = None if found is not None else writable_folder()
        if folder is None:
            return found
        with suppress(OSError):  # without locks, two processes may do the same work
            cache_locks.claim(folder, name)
            self._claims.append((folder, name))
        return _read(folder / name, target_context)  # another process may have made it meanwhile

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep the compile result of a signature."""
        name = self._file(sig, data.codegen)
        folder = writable_folder()
        try:
            if folder is not None and not data.library.has_dynamic_globals:  # which are addresses
                content = dumps(data._reduce())
                write(folder / name, _checksum(content) + content)
                if not KernelCache._pruned:
                    KernelCache._pruned = True
                    prune(folder)
        except OSError as error:
            say(f"compiled kernels cannot be kept in {folder} ({error.strerror or error}); make room there")


def _checksum(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=_CHECKED).digest()


def _read(path: Path, target_context: Any) -> Any:
    """The compile result in a file; None where there is none. One that is damaged is deleted."""
    try:
        content = path.read_bytes()
    except OSError:
        return None
    kept = content[_CHECKED:]
    try:
        if content[:_CHECKED] != _checksum(kept):
            raise ValueError("damaged")
        found = numba_compiler.CompileResult._rebuild(target_context, *pickle.loads(kept))
    except Exception:  # whatever is wrong with it, compiling it again is the remedy
        with suppress(OSError):
            path.unlink()
        return None
    with suppress(OSError):
        if path.stat().st_mtime < time.time() - _DAY:
            path.touch()  # the order of pruning
    return found


def _spelled(signature: Any) -> str:
    """Types written down; names of named tuples with their modules."""
    if isinstance(signature, tuple):
        return f"({', '.join(_spelled(part) for part in signature)})"
    if isinstance(signature, numba_types.BaseTuple):
        kind = getattr(signature, "instance_class", tuple)
        return f"{kind.__module__}.{kind.__qualname__}({', '.join(_spelled(part) for part in signature.types)})"
    return str(signature)
