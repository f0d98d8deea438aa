within MacroStep.Interfaces;
connector PlanOutput = output Plan "Plan as output";
