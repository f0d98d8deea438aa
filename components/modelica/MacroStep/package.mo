within;
package MacroStep "Buses, sockets and blocks of macrostep, to write vehicles, traffic and controllers in Modelica"
  annotation (
    version = "0.1.0",
    uses(),
    Documentation(info = "<html>
<p>A block that extends one of the three sockets in <code>Interfaces</code> takes that place in a system of macrostep:
<code>macrostep run static --plant FILE.mo</code> makes an FMU of it. In any other Modelica tool the package is read as
it is; it needs no library.</p>
<p>Axes after ISO 8855: x forward, y left, z up; yaw and steering positive to the left. All values in SI units.
Positions are the centre of gravity for the ego vehicle and the box centre for obstacles, in the road frame. Physical
parameters have no default values: <code>Examples</code> gives those of the paper.</p>
</html>"));
end MacroStep;
