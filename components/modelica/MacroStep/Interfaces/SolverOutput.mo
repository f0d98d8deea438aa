within MacroStep.Interfaces;
connector SolverOutput = output Solver "Solver as output";
