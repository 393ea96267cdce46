"""Compiled kernels on disk, one file for each kernel, stamp and signature.

numba's own cache is stamped with one file's content and lies beside it: it does not see edits of what a kernel calls,
and every clone compiles anew. numba also compiles all that a kernel calls once more into it, and a part through which
Python would call it. This cache keeps what is large apart, called where it is, and leaves that part out of kernels that
only others call: that halves the time to compile, and changes no result.

It rests on private API of numba, which `numba_internals` lists.
"""

from __future__ import annotations

import hashlib
import pickle
import time
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import llvmlite.binding as llvm
from numba.core import compiler, serialize, types
from numba.core.caching import NullCache
from numba.core.compiler_lock import global_compiler_lock

from hcsearch.kernels.compiling import cache_folder, under_way
from hcsearch.kernels.compiling.cache_folder import (
    prune_folder,
    wanted_folder,
    warn_once,
    writable_folder,
    write_atomically,
)
from hcsearch.kernels.compiling.numba_internals import use_compiler_settings
from hcsearch.kernels.compiling.stamps import kernel_stamp

if TYPE_CHECKING:
    from filelock import BaseFileLock

_Result: Any = compiler.CompileResult  # without types
_Tuple: Any = types.BaseTuple
_dumps: Any = serialize.dumps
_DAY = 86400.0
_CHECKED = 16
"""Bytes of the checksum before what is kept."""


class KernelCache(NullCache):
    """What numba asks for the code of a dispatcher before it compiles, and gives it to afterwards."""

    _pruned = False
    _depth = 0

    def __init__(self, kernel: Any) -> None:
        self._kernel = kernel
        self._claims: list[BaseFileLock] = []
        self._bare: set[Any] = set()
        self._compile, self._add = kernel.compile, kernel.add_overload

    @classmethod
    def attach(cls, kernel: Any) -> None:
        """Give a dispatcher such a cache."""
        own = cls(kernel)
        kernel._cache, kernel.compile, kernel.add_overload = own, own.compile, own.add_overload
        kernel._compiler._customize_flags = own.set_flags

    def compile(self, sig: Any) -> Any:
        """Compile, as the dispatcher does; whatever comes of it, other processes need not wait any more.

        What is compiled on the way, for another kernel, is made without the part that Python would call, which takes as
        long again: it is compiled once more when Python does.
        """
        with global_compiler_lock, use_compiler_settings():
            held = len(self._claims)  # of more signatures where a kernel calls itself
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
                while len(self._claims) > held:
                    cache_folder.release_kernel(self._claims.pop())

    @staticmethod
    def set_flags(flags: Any) -> Any:
        """Flags with which the compilation begins."""
        flags.no_cpython_wrapper = KernelCache._depth > 1
        return flags

    def add_overload(self, result: Any) -> None:
        """Hand a compile result to those who call: kernels, and Python where it can."""
        if KernelCache._depth > 1:
            self._bare.add(result.signature.args)
            self._kernel.overloads[result.signature.args] = result
        else:
            self._add(result)

    @property
    def cache_path(self) -> str:
        """The folder."""
        return str(wanted_folder())

    @cached_property
    def _stamp(self) -> str:
        return kernel_stamp(self._kernel)

    def _file(self, signature: Any, codegen: Any) -> str:
        """The name of the file of a signature, on this processor."""
        bare = ".bare" if KernelCache._depth > 1 else ""
        text = f"{self._stamp} {_spelled(signature)} {codegen.magic_tuple()} {bare}"
        digest = hashlib.blake2b(text.encode(), digest_size=16).hexdigest()
        return f"{digest}-{self._stamp}-{self._kernel.__name__}{bare}.kernel"

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compile result of a signature; None where this process is to compile it."""
        target_context.refresh()
        name = self._file(sig, target_context.codegen())
        result = _read(wanted_folder(), name, target_context)
        folder = None if result is not None else writable_folder()
        if result is None:
            under_way.set_current_kernel(self._kernel)
            if KernelCache._depth == 1:
                under_way.start_compilation(self._kernel)
        if folder is None:
            return result
        with suppress(OSError):  # without locks, two processes may do the same work
            self._claims.append(cache_folder.claim_kernel(folder, name))
        return _read(folder, name, target_context)  # another process may have made it meanwhile

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep the compile result of a signature."""
        name = self._file(sig, data.codegen)
        folder = writable_folder()
        apart = []
        if not self._kernel.targetoptions.get("forceinline") and _is_large(data):
            apart = _callable(data)
            _set_apart(data, name)
            _empty_for_linking(data)
        try:
            if folder is not None and not data.library.has_dynamic_globals:  # which are addresses
                content = _dumps((apart, _needed(data), data._reduce()))
                write_atomically(folder / name, _checksum(content) + content)
                if not KernelCache._pruned:
                    KernelCache._pruned = True
                    prune_folder(folder)
        except OSError as error:
            warn_once(f"compiled kernels cannot be kept in {folder} ({error.strerror or error}); make room there")


def _checksum(content: bytes) -> bytes:
    return hashlib.blake2b(content, digest_size=_CHECKED).digest()


def _read(folder: Path, name: str, target_context: Any) -> Any:
    """The compile result in a file; None where there is none. One that is damaged is deleted."""
    path = folder / name
    try:
        content = path.read_bytes()
    except OSError:
        return None
    kept = content[_CHECKED:]
    try:
        if content[:_CHECKED] != _checksum(kept):
            raise ValueError("damaged")
        apart, needed, reduced = pickle.loads(kept)
        for other, symbol in needed:
            if symbol not in _APART:
                _read(folder, other, target_context)
            if symbol not in _APART:
                raise ValueError("made for other code than there is now")
        target_context.codegen()._engine._defined_symbols.update(apart)
        result = _Result._rebuild(target_context, *reduced)
    except Exception:  # whatever is wrong with it, compiling it again is the remedy
        with suppress(OSError):
            path.unlink()
        return None
    if apart:
        _set_apart(result, name)
    with suppress(OSError):
        if path.stat().st_mtime < time.time() - _DAY:
            path.touch()  # the order of pruning
    return result


_APART: dict[str, tuple[str, Any]] = {}
"""Kernels whose code is called where it is, not linked into their callers, by symbol: their files, and themselves."""
_SIZE = 300
"""Instructions above which no compiler would put a kernel into its caller."""


def _is_large(result: Any) -> bool:
    function = result.library.get_function(result.fndesc.llvm_func_name)
    return sum(1 for block in function.blocks for _ in block.instructions) > _SIZE


def _callable(result: Any) -> list[str]:
    """The functions of a kernel that kernels call, and Python where it can."""
    names = {result.fndesc.llvm_func_name, result.fndesc.llvm_cpython_wrapper_name}
    return [function.name for function in result.library.get_defined_functions() if function.name in names]


def _needed(result: Any) -> list[tuple[str, str]]:
    """Files and symbols of the kernels that a new one calls where they are."""
    names = [function.name for function in result.library._final_module.functions if function.is_declaration]
    return [(_APART[name][0], name) for name in names if name in _APART]


def _set_apart(result: Any, name: str) -> None:
    """Note where a kernel is, which keeps its environment alive."""
    _APART[result.fndesc.llvm_func_name] = name, result


def _empty_for_linking(result: Any) -> None:
    """Give those that call a kernel nothing to link: the engine knows where its code is.

    The file then holds nothing to link either, which would take most of the time to read it.
    """
    layout, triple = result.library.codegen.target_data, llvm.get_process_triple()
    result.library._shared_module = llvm.parse_assembly(f'target datalayout = "{layout}"\ntarget triple = "{triple}"\n')


def _spelled(signature: Any) -> str:
    """Types written down; names of named tuples with their modules."""
    if isinstance(signature, tuple):
        return f"({', '.join(_spelled(part) for part in signature)})"
    if isinstance(signature, _Tuple):
        kind = getattr(signature, "instance_class", tuple)
        return f"{kind.__module__}.{kind.__qualname__}({', '.join(_spelled(part) for part in signature.types)})"
    return str(signature)
