within MacroStep.Interfaces;
partial block Traffic
  "Socket of the traffic around the vehicle; it may ignore the ego vehicle"
  VehicleStateInput ego "state of the ego vehicle";
  ObstacleListOutput obstacles "the traffic";
end Traffic;
