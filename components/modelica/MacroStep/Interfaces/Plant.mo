within MacroStep.Interfaces;
partial block Plant
  "Socket of the vehicle. A plant may also show `TyreOutput tyre` and `MotionOutput motion`"
  ActuationInput actuation "what the controller asks for";
  VehicleStateOutput state "where the vehicle is and how it moves";
end Plant;
