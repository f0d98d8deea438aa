"""Models written in Modelica become blocks: rumoca flattens them, CasADi carries their equations."""
