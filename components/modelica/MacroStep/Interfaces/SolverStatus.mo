within MacroStep.Interfaces;
type SolverStatus = enumeration(
    converged "the residual is small enough",
    iteration_limit "stopped before it was",
    fallback "the previous plan is followed") "How a solve ended";
