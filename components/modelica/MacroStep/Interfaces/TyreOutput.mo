within MacroStep.Interfaces;
connector TyreOutput = output Tyre "Tyre as output";
