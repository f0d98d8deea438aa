within MacroStep.Interfaces;
record Motion "Accelerations of the centre of gravity, resolved in the body frame"
  Real a_x(unit = "m/s2") "longitudinal acceleration";
  Real a_y(unit = "m/s2") "lateral acceleration, to the left";
  Real r_dot(unit = "rad/s2") "yaw acceleration";
end Motion;
