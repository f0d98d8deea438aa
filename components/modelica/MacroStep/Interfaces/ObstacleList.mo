within MacroStep.Interfaces;
record ObstacleList "The traffic around the vehicle: one element per slot, box centres in the road frame"
  Boolean valid[slots] "whether the slot holds an obstacle";
  Integer id[slots] "identity of the obstacle";
  Real x[slots](each unit = "m") "position along the road";
  Real y[slots](each unit = "m") "position across the road, to the left";
  Real psi[slots](each unit = "rad") "yaw angle";
  Real v[slots](each unit = "m/s") "speed along the obstacle's heading";
  Real length[slots](each unit = "m") "length of the box";
  Real width[slots](each unit = "m") "width of the box";
end ObstacleList;
