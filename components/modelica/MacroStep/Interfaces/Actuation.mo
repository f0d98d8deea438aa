within MacroStep.Interfaces;
record Actuation "What the controller asks of the vehicle"
  Real delta_f(unit = "rad") "front road-wheel angle, to the left";
  Real T_r(unit = "N.m") "torque on one rear wheel, driving positive";
end Actuation;
