within MacroStep.Interfaces;
connector MotionOutput = output Motion "Motion as output";
