within MacroStep.Interfaces;
record VehicleState "Where the vehicle is and how it moves; position of the centre of gravity in the road frame"
  Real x(unit = "m") "position along the road";
  Real y(unit = "m") "position across the road, to the left";
  Real psi(unit = "rad") "yaw angle";
  Real v_x(unit = "m/s") "longitudinal speed in the body frame";
  Real v_y(unit = "m/s") "lateral speed in the body frame, to the left";
  Real r(unit = "rad/s") "yaw rate";
end VehicleState;
