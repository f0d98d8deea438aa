within MacroStep.Interfaces;
connector WaypointsOutput = output Waypoints "Waypoints as output";
