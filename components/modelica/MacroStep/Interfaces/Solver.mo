within MacroStep.Interfaces;
record Solver "How the optimal control problem was solved"
  SolverStatus status "how the solve ended";
  Integer iterations "iterations until the residual was small enough";
  Real cost(unit = "1") "value of the cost function";
  Real kkt(unit = "1") "residual of the optimality (KKT) conditions";
end Solver;
