within MacroStep.Traffic;
block EmptyRoad "Traffic without any obstacle: the empty plug of the traffic socket"
  extends Interfaces.Traffic;
equation
  obstacles.valid = fill(false, Interfaces.slots);
  obstacles.id = fill(0, Interfaces.slots);
  obstacles.x = zeros(Interfaces.slots);
  obstacles.y = zeros(Interfaces.slots);
  obstacles.psi = zeros(Interfaces.slots);
  obstacles.v = zeros(Interfaces.slots);
  obstacles.length = zeros(Interfaces.slots);
  obstacles.width = zeros(Interfaces.slots);
end EmptyRoad;
