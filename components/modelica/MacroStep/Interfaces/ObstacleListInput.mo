within MacroStep.Interfaces;
connector ObstacleListInput = input ObstacleList "ObstacleList as input";
