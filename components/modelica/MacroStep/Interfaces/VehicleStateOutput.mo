within MacroStep.Interfaces;
connector VehicleStateOutput = output VehicleState "VehicleState as output";
