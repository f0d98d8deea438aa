within MacroStep.Interfaces;
connector ActuationInput = input Actuation "Actuation as input";
