"""The passes of numba's compiler that kernels need: most others look for what no kernel has.

A kernel has no closures, array expressions, literal loops, exceptions or inlined overloads, and no references that
end with a variable. Without the passes for them a first run takes less time.
"""

from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import PassManager

IN_VAIN = frozenset(
    "WithLifting InlineClosureLikes RewriteDynamicRaises MakeFunctionToJitFunction InlineInlinables FindLiterallyCalls "
    "LiteralUnroll LiteralPropagationSubPipelinePass InlineOverloads NopythonRewrites "
    "NoPythonSupportedFeatureValidation DumpParforDiagnostics IRLegalization AnnotateTypes".split()
)


class KernelCompiler(CompilerBase):
    """numba's compiler with fewer passes."""

    def define_pipelines(self):
        """Return the passes, as a list of one PassManager."""
        needed = PassManager("kernel")
        for of, what in DefaultPassBuilder.define_nopython_pipeline(self.state).passes:
            if of.__name__ not in IN_VAIN:
                needed.add_pass(of, what)
        needed.finalize()
        return [needed]
