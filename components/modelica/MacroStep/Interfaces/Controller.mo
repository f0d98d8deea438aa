within MacroStep.Interfaces;
partial block Controller
  "Socket of the controller. A controller may also show `WaypointsOutput path`, `PlanOutput plan` and `SolverOutput solver`"
  VehicleStateInput ego "state of the ego vehicle";
  ObstacleListInput obstacles "the traffic";
  ActuationOutput actuation "what is asked of the vehicle";
end Controller;
