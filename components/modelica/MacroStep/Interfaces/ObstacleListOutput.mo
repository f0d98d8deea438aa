within MacroStep.Interfaces;
connector ObstacleListOutput = output ObstacleList "ObstacleList as output";
