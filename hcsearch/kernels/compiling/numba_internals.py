"""Private API of numba that the kernel cache uses, a check that it is present, and LLVM settings of our kernels.

numba does not guarantee this API. If a part is missing, or takes other arguments, numba's own cache is used instead.
"""

from __future__ import annotations

import importlib
import inspect
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from typing import Any, NamedTuple

import numba
from numba.core import codegen


class NumbaInternal(NamedTuple):
    """A part of numba's private API, given by module and qualified name.

    arguments : names of the arguments that the cache passes; None if the part is not called. sets : attributes of
        instances that the part, an initialiser, must set.
    """

    module: str
    name: str
    arguments: tuple[str, ...] | None = None
    sets: tuple[str, ...] = ()

    @property
    def is_present(self) -> bool:
        """Whether the installed numba has this part in the form that the cache needs."""
        try:
            part: Any = importlib.import_module(self.module)
            for name in self.name.split("."):
                part = getattr(part, name)
        except (ImportError, AttributeError):
            return False
        if self.arguments is not None and not _accepts(part, self.arguments):
            return False
        return set(self.sets) <= set(getattr(getattr(part, "__code__", None), "co_names", ()))


NUMBA_INTERNALS = (
    NumbaInternal("numba.core.base", "BaseContext.subtarget"),
    NumbaInternal("numba.core.caching", "NullCache.cache_path"),
    NumbaInternal("numba.core.caching", "NullCache.load_overload", ("self", "sig", "target_context")),
    NumbaInternal("numba.core.caching", "NullCache.save_overload", ("self", "sig", "cres")),
    NumbaInternal("numba.core.codegen", "CPUCodegen._init", ("self", "llvm_module"), ("_engine",)),
    # the code of a library, and its part that is linked into callers
    NumbaInternal("numba.core.codegen", "CPUCodeLibrary.__init__", sets=("_final_module", "_shared_module")),
    NumbaInternal("numba.core.codegen", "CPUCodeLibrary._optimize_functions", ("self", "ll_module")),
    NumbaInternal("numba.core.codegen", "CPUCodegen.__init__", sets=("_data_layout",)),
    # names of all functions that can be called
    NumbaInternal("numba.core.codegen", "JitEngine.__init__", sets=("_defined_symbols",)),
    NumbaInternal("numba.core.compiler", "CompileResult._reduce", ("self",)),
    NumbaInternal("numba.core.compiler", "CompileResult._rebuild"),
    NumbaInternal("numba.core.compiler", "CompilerBase.define_pipelines", ("self",)),
    NumbaInternal("numba.core.compiler", "DefaultPassBuilder.define_nopython_pipeline", ("state",)),
    NumbaInternal("numba.core.compiler", "Flags.no_cpython_wrapper"),
    NumbaInternal("numba.core.compiler_machinery", "PassManager.add_pass_after", ("self", "pass_cls", "location")),
    NumbaInternal("numba.core.compiler_lock", "global_compiler_lock"),
    NumbaInternal("numba.core.config", "reload_config", ()),
    NumbaInternal(
        "numba.core.cpu", "CPUContext.create_cpython_wrapper", ("self", "library", "fndesc", "env", "call_helper")
    ),
    NumbaInternal("numba.core.cpu", "CPUTargetOptions.no_cfunc_wrapper"),
    NumbaInternal("numba.core.datamodel.models", "ArrayModel"),
    NumbaInternal("numba.core.datamodel.models", "PrimitiveModel"),
    NumbaInternal("numba.core.dispatcher", "Dispatcher.__init__", sets=("_cache", "_compiler")),
    NumbaInternal("numba.core.dispatcher", "Dispatcher._insert"),
    NumbaInternal("numba.core.dispatcher", "Dispatcher.add_overload", ("self", "cres")),
    NumbaInternal("numba.core.dispatcher", "Dispatcher.compile", ("self", "sig")),
    NumbaInternal("numba.core.dispatcher", "_FunctionCompiler._customize_flags", ("self", "flags")),
    NumbaInternal("numba.core.dispatcher", "_FunctionCompiler.fold_argument_types", ("self", "args", "kws")),
    NumbaInternal("numba.core.pythonapi", "PythonAPI.nrt_adapt_ndarray_from_python", ("self", "ary", "ptr")),
    NumbaInternal("numba.core.pythonapi", "PythonAPI.numba_array_adaptor", ("self", "ary", "ptr")),
    NumbaInternal("numba.core.runtime", "rtsys.initialize", ("ctx",)),
    NumbaInternal("numba.core.serialize", "dumps", ("obj",)),
    NumbaInternal("numba.core.typed_passes", "NoPythonSupportedFeatureValidation"),
    NumbaInternal("numba.core.types", "BaseTuple.from_types", ("tys", "pyclass")),
    NumbaInternal("numba.core.typing.templates", "AttributeTemplate.generic_resolve"),
)


@cache
def has_internals() -> bool:
    """Return whether the installed numba has all internals that the kernel cache needs."""
    return all(internal.is_present for internal in NUMBA_INTERNALS)


def _accepts(function: Callable[..., object], arguments: tuple[str, ...]) -> bool:
    """Return whether a function accepts exactly these positional arguments."""
    try:
        inspect.signature(function).bind(*arguments)
    except (TypeError, ValueError):
        return False
    return True


_OUR_SETTINGS: Mapping[str, int] = {"OPT": 1, "LOOP_VECTORIZE": 0}
"""With numba's defaults, 3 and 1, compilation takes nearly twice as long, and the kernels run no faster."""
_OTHER_SETTINGS = ("SLP_VECTORIZE", "BOUNDSCHECK", "ENABLE_AVX", "DEBUGINFO_DEFAULT")
"""Other configuration of numba that affects generated code; left unchanged, but part of the settings."""


def compiler_settings() -> dict[str, Any]:
    """Return compiler settings by names of numba's configuration; environment variables NUMBA_... take precedence."""
    config: Any = numba.config
    config.reload_config()  # as numba does when it compiles: variables may have been set after its import
    our_settings = {name: type(getattr(config, name))(value) for name, value in _OUR_SETTINGS.items()}
    overridden = {name for name in our_settings if f"NUMBA_{name}" in os.environ}
    return {name: our_settings[name] for name in our_settings.keys() - overridden} | {
        name: getattr(config, name, None) for name in (*sorted(overridden), *_OTHER_SETTINGS)
    }


@contextmanager
def use_compiler_settings() -> Iterator[None]:
    """Apply our compiler settings within a block, which must hold numba's compiler lock."""
    config: Any = numba.config
    chosen = compiler_settings()
    before = {name: getattr(config, name) for name in _OUR_SETTINGS}
    library: Any = codegen.CPUCodeLibrary
    optimise = library._optimize_functions
    for name in _OUR_SETTINGS:
        setattr(config, name, chosen[name])
    library._optimize_functions = _leave_functions
    try:
        yield
    finally:
        library._optimize_functions = optimise
        for name, value in before.items():
            setattr(config, name, value)


def _leave_functions(library: Any, module: Any) -> None:
    """Leave out the passes over single functions: those over the whole module follow, and do the same."""
    module.data_layout = library._codegen._data_layout
