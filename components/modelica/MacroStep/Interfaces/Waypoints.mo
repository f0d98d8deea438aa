within MacroStep.Interfaces;
record Waypoints "The waypoints P0 to P14 of the path"
  Real x[waypoints](each unit = "m") "waypoints along the road";
  Real y[waypoints](each unit = "m") "waypoints across the road, to the left";
end Waypoints;
