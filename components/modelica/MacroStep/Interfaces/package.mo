within MacroStep;
package Interfaces "Buses (records, and connectors made of them) and sockets (partial blocks)"
  constant Integer slots = 8 "obstacles that fit the bus of obstacles";
  constant Integer waypoints = 15 "waypoints P0 to P14 of the path";
end Interfaces;
