within MacroStep.Interfaces;
connector VehicleStateInput = input VehicleState "VehicleState as input";
