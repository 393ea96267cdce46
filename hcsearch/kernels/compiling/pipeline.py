"""The steps by which numba compiles a kernel, with one more: references are counted only where arrays are made."""

from __future__ import annotations

from typing import Any

from numba.core import compiler, compiler_machinery, ir, typed_passes, types

from hcsearch.kernels.compiling.lent_types import kept_type

_MAKING = ("call", "binop", "inplace_binop", "unary", "arrayexpr", "build_list", "build_set", "build_map")
"""Expressions whose value may be a new array; all others give parts of arrays, or their arguments."""


class KernelCompiler(compiler.CompilerBase):
    """numba's compiler of functions without Python objects, with `CountReferences` before the lowering to LLVM."""

    def define_pipelines(self) -> list[Any]:
        """Return the passes."""
        passes = compiler.DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.add_pass_after(CountReferences, typed_passes.NoPythonSupportedFeatureValidation)
        passes.finalize()
        return [passes]


@compiler_machinery.register_pass(mutates_CFG=False, analysis_only=False)
class CountReferences(compiler_machinery.FunctionPass):
    """Leave reference counting out of kernels that neither make arrays nor receive any from their callees.

    All arrays in such a kernel are its arguments or parts of them, which its caller keeps. Counting takes longer than a
    small kernel itself.
    """

    _name = "count_references"

    def __init__(self) -> None:
        super().__init__()

    def run_pass(self, state: Any) -> bool:
        """Switch reference counting off where it is not needed; return tables as named tuples."""
        kept = kept_type(state.return_type)
        if kept != state.return_type:
            for block in state.func_ir.blocks.values():
                if isinstance(block.terminator, ir.Return):  # of a variable of its own
                    name = block.terminator.value.name
                    del state.typemap[name]
                    state.typemap[name] = kept
            state.return_type = kept
        if not _makes_arrays(state):
            state.targetctx = state.targetctx.subtarget(enable_nrt=False)
        return True


def _makes_arrays(state: Any) -> bool:
    def is_counted(kind: Any) -> bool:
        return bool(state.targetctx.data_model_manager[kind].contains_nrt_meminfo())

    if is_counted(state.return_type):
        return True
    for block in state.func_ir.blocks.values():
        for step in block.body:
            if isinstance(step, ir.SetItem | ir.StaticSetItem) and is_counted(state.typemap[step.value.name]):
                return True  # they may share memory, so numba copies the source
            if (
                isinstance(step, ir.Assign)
                and isinstance(step.value, ir.Expr)
                and is_counted(state.typemap[step.target.name])
            ):
                value = step.value
                if value.op in _MAKING and not (
                    value.op == "call" and isinstance(state.typemap[value.func.name], types.NamedTupleClass)
                ):
                    return True
                if value.op == "getitem" and is_counted(state.typemap[value.index.name]):
                    return True
    return False
