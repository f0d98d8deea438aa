within MacroStep.Interfaces;
record Plan "What the controller expects at its prediction steps 1 to N_p"
  parameter Integer N_p(min = 1) "prediction steps";
  Real x[N_p](each unit = "m") "predicted position along the road";
  Real y[N_p](each unit = "m") "predicted position across the road";
  Real x_d[N_p](each unit = "m") "desired point on the path, along the road";
  Real y_d[N_p](each unit = "m") "desired point on the path, across the road";
  Real y_upper[N_p](each unit = "m") "upper (left) boundary of the corridor at x_d";
  Real y_lower[N_p](each unit = "m") "lower (right) boundary of the corridor at x_d";
end Plan;
