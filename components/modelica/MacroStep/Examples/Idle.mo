within MacroStep.Examples;
model Idle "The three sockets filled and connected: the vehicle rolls straight on"
  PaperBicycle plant "the vehicle";
  Traffic.EmptyRoad traffic "no obstacles";
  Controller.Coast controller "no actuation";
equation
  connect(controller.actuation, plant.actuation);
  connect(plant.state, traffic.ego);
  connect(plant.state, controller.ego);
  connect(traffic.obstacles, controller.obstacles);
  annotation (
    experiment(StartTime = 0, StopTime = 5, Interval = 0.1));
end Idle;
