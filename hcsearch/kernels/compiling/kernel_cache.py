"""On-disk cache of compiled kernels, one file per kernel, stamp and signature.

numba's own cache lies beside the source file and is stamped with the content of that file alone: it misses edits of
callees, and every clone compiles anew. numba also compiles all callees into each kernel again, and adds a wrapper
through which Python can call it. This cache keeps large kernels as separate code that callers jump to, and omits the
wrapper of kernels called only by others: this halves the time to compile and changes no result.

It relies on private API of numba, listed in `numba_internals`.
"""

from __future__ import annotations

import hashlib
import pickle
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import llvmlite.binding as llvm
from numba.core import compiler, runtime, serialize, types
from numba.core.caching import NullCache
from numba.core.compiler_lock import global_compiler_lock

from hcsearch.kernels.compiling import cache_folder, under_way
from hcsearch.kernels.compiling.cache_folder import (
    prune_folder,
    readable_folder,
    wanted_folder,
    warn_once,
    writable_folder,
    write_atomically,
)
from hcsearch.kernels.compiling.numba_internals import use_compiler_settings
from hcsearch.kernels.compiling.own_folders import is_own_file
from hcsearch.kernels.compiling.stamps import kernel_stamp

if TYPE_CHECKING:
    from filelock import BaseFileLock

_Result: Any = compiler.CompileResult  # without types
_runtime: Any = runtime
_Tuple: Any = types.BaseTuple
_dumps: Any = serialize.dumps
_DAY = 86400.0
_CHECKED = 16
"""Length (bytes) of the checksum that precedes the content of a file."""


class KernelCache(NullCache):
    """The cache of one dispatcher: numba loads overloads from it before compiling, and saves them afterwards."""

    _pruned = False
    _depth = 0

    def __init__(self, kernel: Any) -> None:
        self._kernel = kernel
        self._claims: list[BaseFileLock] = []
        self._bare: set[Any] = set()
        self._compile, self._add = kernel.compile, kernel.add_overload

    @classmethod
    def attach(cls, kernel: Any) -> None:
        """Attach a new cache to a dispatcher."""
        cache = cls(kernel)
        kernel._cache, kernel.compile, kernel.add_overload = cache, cache.compile, cache.add_overload
        kernel._compiler._customize_flags = cache.set_flags

    def compile(self, sig: Any) -> Any:
        """Compile a signature as the dispatcher does, and release the locks of its files even on failure.

        Kernels compiled on the way, as callees, get no Python wrapper, which would double the time; they are compiled
        again if Python calls them.
        """
        with global_compiler_lock, use_compiler_settings():
            claim_count = len(self._claims)  # several signatures if a kernel calls itself
            KernelCache._depth += 1
            try:
                if KernelCache._depth == 1 and sig in self._bare:
                    self._bare.remove(sig)
                    del self._kernel.overloads[sig]
                return self._compile(sig)
            finally:
                KernelCache._depth -= 1
                if KernelCache._depth == 0:
                    under_way.end_compilation()
                while len(self._claims) > claim_count:
                    cache_folder.release_kernel(self._claims.pop())

    @staticmethod
    def set_flags(flags: Any) -> Any:
        """Set the compiler flags: no Python wrapper for callees."""
        flags.no_cpython_wrapper = KernelCache._depth > 1
        return flags

    def add_overload(self, result: Any) -> None:
        """Register a compile result for calls from kernels and, if it has a wrapper, from Python."""
        if KernelCache._depth > 1:
            self._bare.add(result.signature.args)
            self._kernel.overloads[result.signature.args] = result
        else:
            self._add(result)

    @property
    def cache_path(self) -> str:
        """The folder of the cache."""
        return str(wanted_folder())

    def _file(self, signature: Any, codegen: Any) -> str:
        """Return the file name of a signature on this processor."""
        bare, stamp = ".bare" if KernelCache._depth > 1 else "", kernel_stamp(self._kernel)
        text = f"{stamp} {_signature_text(signature)} {codegen.magic_tuple()} {bare}"
        digest = hashlib.blake2b(text.encode(), digest_size=16).hexdigest()
        return f"{digest}-{stamp}-{self._kernel.__name__}{bare}.kernel"

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the cached compile result of a signature; None if this process must compile it."""
        # a refresh, which numba's cache makes here, loads all that can be compiled: 0.4 s
        _runtime.rtsys.initialize(target_context)
        name = self._file(sig, target_context.codegen())
        filled = readable_folder()
        result = None if filled is None else _read(filled, name, target_context)
        folder = None if result is not None else writable_folder()
        if result is None:
            under_way.set_current_kernel(self._kernel)
            if KernelCache._depth == 1:
                under_way.start_compilation(self._kernel)
        if folder is None:
            return result
        with suppress(OSError):  # without locks, two processes may compile the same kernel
            self._claims.append(cache_folder.claim_kernel(folder, name))
        return _read(folder, name, target_context)  # another process may have compiled it meanwhile

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write the compile result of a signature to the cache."""
        name = self._file(sig, data.codegen)
        folder = writable_folder()
        entry_points = []
        if not self._kernel.targetoptions.get("forceinline") and _is_large(data):
            entry_points = _entry_points(data)
            _register_separate(data, name)
            _empty_for_linking(data)
        try:
            if folder is not None and not data.library.has_dynamic_globals:  # dynamic globals are addresses
                content = _dumps((entry_points, _separate_callees(data), data._reduce()))
                write_atomically(folder / name, _checksum(content) + content)
                if not KernelCache._pruned:
                    KernelCache._pruned = True
                    prune_folder(folder)
        except OSError as error:
            warn_once(f"compiled kernels cannot be kept in {folder} ({error.strerror or error}); make room there")


def _checksum(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=_CHECKED).digest()


def _read(folder: Path, name: str, target_context: Any) -> Any:
    """Load a compile result from a file in a folder of the user's; return None if there is none.

    Files that others might have written are not read, and damaged files are deleted.
    """
    path = folder / name
    try:
        if not is_own_file(path):
            warn_once(f"{folder} has kernels that others might have written: they are not run but compiled anew")
            return None
        content = path.read_bytes()
    except OSError:
        return None
    payload = content[_CHECKED:]
    try:
        if content[:_CHECKED] != _checksum(payload):
            raise ValueError("damaged")
        entry_points, callees, state = pickle.loads(payload)
        for callee_file, symbol in callees:
            if symbol not in _SEPARATE_KERNELS:
                _read(folder, callee_file, target_context)
            if symbol not in _SEPARATE_KERNELS:
                raise ValueError("made for other code than there is now")
        target_context.codegen()._engine._defined_symbols.update(entry_points)
        result = _Result._rebuild(target_context, *state)
    except Exception:  # whatever the error, recompilation is the remedy
        with suppress(OSError):
            path.unlink()
        return None
    if entry_points:
        _register_separate(result, name)
    with suppress(OSError):
        if path.stat().st_mtime < time.time() - _DAY:
            path.touch()  # last use, for pruning
    return result


_SEPARATE_KERNELS: dict[str, tuple[str, Any]] = {}
"""Kernels called as separate code, not linked into their callers, by symbol: file name and compile result."""
_SIZE = 300
"""Number of instructions above which no compiler would inline a kernel."""


def _is_large(result: Any) -> bool:
    function = result.library.get_function(result.fndesc.llvm_func_name)
    return sum(1 for block in function.blocks for _ in block.instructions) > _SIZE


def _entry_points(result: Any) -> list[str]:
    """Return the names of a kernel's entry points, for kernels and, if present, for Python."""
    names = {result.fndesc.llvm_func_name, result.fndesc.llvm_cpython_wrapper_name}
    return [function.name for function in result.library.get_defined_functions() if function.name in names]


def _separate_callees(result: Any) -> list[tuple[str, str]]:
    """Return files and symbols of the separate kernels that a compile result calls."""
    names = [function.name for function in result.library._final_module.functions if function.is_declaration]
    return [(_SEPARATE_KERNELS[name][0], name) for name in names if name in _SEPARATE_KERNELS]


def _register_separate(result: Any, name: str) -> None:
    """Register a kernel as separate code; the reference keeps its environment alive."""
    _SEPARATE_KERNELS[result.fndesc.llvm_func_name] = name, result


def _empty_for_linking(result: Any) -> None:
    """Replace the module that callers link by an empty one: the engine knows the address of the code.

    The file then contains no module to link either, which would take most of the time to read it.
    """
    layout, triple = result.library.codegen.target_data, llvm.get_process_triple()
    result.library._shared_module = llvm.parse_assembly(f'target datalayout = "{layout}"\ntarget triple = "{triple}"\n')


def _signature_text(signature: Any) -> str:
    """Return the text of a signature; named tuples include their modules."""
    if isinstance(signature, tuple):
        return f"({', '.join(_signature_text(part) for part in signature)})"
    if isinstance(signature, _Tuple):
        kind = getattr(signature, "instance_class", tuple)
        return f"{kind.__module__}.{kind.__qualname__}({', '.join(_signature_text(part) for part in signature.types)})"
    return str(signature)
