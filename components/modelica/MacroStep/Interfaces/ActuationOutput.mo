within MacroStep.Interfaces;
connector ActuationOutput = output Actuation "Actuation as output";
