within MacroStep.Controller;
block Coast "Controller that lets the vehicle roll straight on: the empty plug of the controller socket"
  extends Interfaces.Controller;
equation
  actuation.delta_f = 0;
  actuation.T_r = 0;
end Coast;
