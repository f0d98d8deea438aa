within MacroStep.Interfaces;
record Tyre "How hard the tyres work"
  Real alpha_f(unit = "rad") "front slip angle";
  Real alpha_r(unit = "rad") "rear slip angle";
  Real F_cf(unit = "N") "lateral force of one front tyre, to the left";
  Real F_cr(unit = "N") "lateral force of one rear tyre, to the left";
  Real mu_f(unit = "1") "share of the friction limit in use at the front axle";
  Real mu_r(unit = "1") "share of the friction limit in use at the rear axle";
end Tyre;
