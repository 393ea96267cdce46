"""On-disk cache of compiled kernels, one file per kernel, stamp and signature.

numba's own cache lies beside the source file and is stamped with the content of that file alone: it misses edits of
callees, and every clone compiles anew. numba also compiles all callees into each kernel again, and adds a wrapper
through which Python can call it. This cache keeps large kernels as separate code that callers jump to, and makes a
wrapper only for kernels that Python calls: this halves the time to compile and changes no result.

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
from numba.core import compiler, runtime, serialize
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
from hcsearch.kernels.compiling.lent_types import lent_type
from hcsearch.kernels.compiling.numba_internals import use_compiler_settings
from hcsearch.kernels.compiling.own_folders import is_own_file
from hcsearch.kernels.compiling.stamps import kernel_stamp

if TYPE_CHECKING:
    from filelock import BaseFileLock

_Result: Any = compiler.CompileResult  # without types
_runtime: Any = runtime
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
        self._entries: dict[Any, Any] = {}
        self._compile, self._add = kernel.compile, kernel.add_overload
        self._fold = kernel._compiler.fold_argument_types

    @classmethod
    def attach(cls, kernel: Any) -> None:
        """Attach a new cache to a dispatcher."""
        cache = cls(kernel)
        kernel._cache, kernel.compile, kernel.add_overload = cache, cache.compile, cache.add_overload
        kernel._compiler._customize_flags = cache.set_flags
        kernel._compiler.fold_argument_types = cache.fold

    def compile(self, sig: Any) -> Any:
        """Compile a signature as the dispatcher does, and release the locks of its files even on failure.

        Kernels compiled on the way, as callees, get no Python wrapper; it is made alone if Python calls them.
        """
        with global_compiler_lock, use_compiler_settings():
            claim_count = len(self._claims)  # several signatures if a kernel calls itself
            KernelCache._depth += 1
            try:
                lent = tuple(map(lent_type, sig))
                entry_point = self._compile(lent)
                if KernelCache._depth == 1:
                    under_way.CALLED_BY_PYTHON.add(self._kernel)
                    entry_point = self._python_entry(lent) if lent in self._bare else entry_point
                    self._kernel._insert([kind._code for kind in sig], entry_point, False)
                return entry_point
            finally:
                KernelCache._depth -= 1
                if KernelCache._depth == 0:
                    under_way.end_compilation()
                while len(self._claims) > claim_count:
                    cache_folder.release_kernel(self._claims.pop())

    def fold(self, args: Any, kws: Any) -> Any:
        """Return the signature and the types by which a call from a kernel passes its arguments."""
        signature, kinds = self._fold(args, kws)
        return signature, tuple(map(lent_type, kinds))

    @staticmethod
    def set_flags(flags: Any) -> Any:
        """Set the compiler flags: no Python wrapper for callees."""
        flags.no_cpython_wrapper = KernelCache._depth > 1
        return flags

    def add_overload(self, result: Any) -> None:
        """Register a compile result for calls from kernels and, if it has a wrapper, from Python."""
        if KernelCache._depth > 1 or result.signature.args in self._bare:
            self._kernel.overloads[result.signature.args] = result
        else:
            self._add(result)

    @property
    def cache_path(self) -> str:
        """The folder of the cache."""
        return str(wanted_folder())

    def _files(self, signature: Any, codegen: Any) -> tuple[str, str]:
        """Return the file names of a signature on this processor: with a Python wrapper, and without."""
        stamp = kernel_stamp(self._kernel)
        text = f"{stamp} {signature} {codegen.magic_tuple()}"
        name = f"{hashlib.blake2b(text.encode(), digest_size=16).hexdigest()}-{stamp}-{self._kernel.__name__}"
        return f"{name}.kernel", f"{name}.bare.kernel"

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the cached compile result of a signature; None if this process must compile it."""
        # a refresh, which numba's cache makes here, loads all that can be compiled: 0.4 s
        _runtime.rtsys.initialize(target_context)
        result = self._load(readable_folder(), sig, target_context)
        if result is not None:
            return result
        under_way.set_current_kernel(self._kernel)
        if KernelCache._depth == 1:
            under_way.start_compilation(self._kernel)
        folder = writable_folder()
        if folder is not None:
            with suppress(OSError):  # without locks, two processes may compile the same kernel
                self._claims.append(cache_folder.claim_kernel(folder, self._files(sig, target_context.codegen())[0]))
        return self._load(folder, sig, target_context)  # another process may have compiled it meanwhile

    def _load(self, folder: Path | None, sig: Any, target_context: Any) -> Any:
        if folder is None:
            return None
        whole, bare = self._files(sig, target_context.codegen())
        for name in (whole, bare) if KernelCache._depth == 1 else (bare, whole):
            result = _read(folder, name, target_context)
            if result is not None:
                if name == bare:
                    self._bare.add(sig)
                return result
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write the compile result of a signature to the cache."""
        whole, bare = self._files(sig, data.codegen)
        if KernelCache._depth > 1:
            self._bare.add(sig)
        name = bare if sig in self._bare else whole
        entry_points = []
        if _is_large(data):
            entry_points = _entry_points(data)
            _register_separate(data, name)
            _empty_for_linking(data)
        self._write(name, entry_points, data)

    def _write(self, name: str, entry_points: list[str], data: Any) -> None:
        folder = writable_folder()
        try:
            if folder is not None and not data.library.has_dynamic_globals:  # dynamic globals are addresses
                constants = data.environment.consts
                content = _dumps((entry_points, _separate_callees(data), constants, data._reduce()))
                write_atomically(folder / name, _checksum(content) + content)
                if not KernelCache._pruned:
                    KernelCache._pruned = True
                    prune_folder(folder)
        except OSError as error:
            warn_once(f"compiled kernels cannot be kept in {folder} ({error.strerror or error}); make room there")

    def _python_entry(self, sig: Any) -> Any:
        """Return the function by which Python calls a kernel that has none yet: a wrapper that calls its code."""
        if sig not in self._entries:
            result = self._kernel.overloads[sig]
            name, folder = self._files(sig, result.codegen)[0], readable_folder()
            entry = None if folder is None else _read(folder, name, result.target_context)
            if entry is None:
                entry = _with_wrapper(result)
                self._write(name, [], entry)
            self._entries[sig] = entry
        return self._entries[sig].entry_point


def _with_wrapper(result: Any) -> Any:
    """Return a compile result with a library of its own: a wrapper for Python around the code of another result."""
    result.target_context.refresh()  # nothing may have been compiled in this process before
    context = result.target_context.subtarget(enable_nrt=True)
    library = result.codegen.create_library(f"wrapper of {result.fndesc.qualname}")
    library.enable_object_caching()
    for linked in (result.library, _runtime.rtsys.library):
        library.add_linking_library(linked)
    about = result.fndesc, result.environment
    context.create_cpython_wrapper(library, *about, result.call_helper, release_gil=True)
    library.finalize()
    return result._replace(library=library, entry_point=context.get_executable(library, *about))


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
        entry_points, callees, constants, state = pickle.loads(payload)
        for callee_file, symbol in callees:
            if symbol not in _SEPARATE_KERNELS:
                _read(folder, callee_file, target_context)
            if symbol not in _SEPARATE_KERNELS:
                raise ValueError("made for other code than there is now")
        target_context.codegen()._engine._defined_symbols.update(entry_points)
        result = _Result._rebuild(target_context, *state)
        known = result.environment.consts  # those of the kernel if its code was read before this wrapper of it
        known.extend(constants[len(known) :])
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
