"""Compilation of kernels that only other kernels call.

A kernel that Python calls needs optimized machine code and a wrapper that converts its arguments.
A kernel that another kernel calls needs neither: LLVM optimizes its code together with the code of
the caller. LinkedCompiler therefore stops after numba's lowering and LLVM's passes for functions.
numba's own compiler would optimize the same function again at each level of calls, and emit machine
code that nothing executes.
"""

from __future__ import annotations

from typing import Any

from llvmlite.binding import Linkage
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


class LinkedLibrary(JITCodeLibrary):
    """Code of one function as LLVM bitcode, to be linked into the libraries of its callers."""

    def _optimize_final_module(self) -> None:
        """Do nothing, since the library of the outermost caller optimizes the code."""

    def _finalize_final_module(self) -> None:
        """Share all functions with callers as bitcode, without machine code."""
        module = self._final_module
        names = [one.name for one in module.functions if not one.is_declaration]
        self._shared_module = module.clone()
        for name in names:
            shared = self._shared_module.get_function(name)
            if shared.linkage == Linkage.external:
                shared.linkage = Linkage.linkonce_odr
            module.get_function(name).linkage = Linkage.available_externally
        super()._finalize_final_module()  # type: ignore[no-untyped-call]  # numba has no types


class LinkedCompiler(Compiler):
    """numba's compiler of kernels, with a LinkedLibrary."""

    def _compile_core(self) -> Any:
        state = self.state
        library: Any = LinkedLibrary  # numba has no types
        state.library = library(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        return super()._compile_core()  # type: ignore[no-untyped-call]  # numba has no types
