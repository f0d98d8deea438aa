within MacroStep.Vehicle;
block Bicycle "Single-track vehicle with linear tyres, equations (1)-(3) of the paper"
  extends Interfaces.Plant;
  Interfaces.TyreOutput tyre "how hard the tyres work";
  Interfaces.MotionOutput motion "what the passengers feel";
  parameter Real m(unit = "kg", min = 1) "mass";
  parameter Real I_z(unit = "kg.m2", min = 1) "yaw inertia";
  parameter Real l_f(unit = "m", min = 0.1) "distance from the centre of gravity to the front axle";
  parameter Real l_r(unit = "m", min = 0.1) "distance from the centre of gravity to the rear axle";
  parameter Real C_alpha_f(unit = "N/rad", min = 0) "cornering stiffness of one front tyre";
  parameter Real C_alpha_r(unit = "N/rad", min = 0) "cornering stiffness of one rear tyre";
  parameter Real R_w(unit = "m", min = 0.01) "wheel radius";
  parameter Real mu(unit = "1", min = 0.01, max = 2) "friction coefficient of the road";
  parameter Real g(unit = "m/s2", min = 0.1) "gravity";
  parameter Real x_start(unit = "m") "initial position along the road";
  parameter Real y_start(unit = "m") "initial position across the road";
  parameter Real psi_start(unit = "rad") "initial yaw angle";
  parameter Real v_x_start(unit = "m/s", min = 0) "initial longitudinal speed";
  parameter Real v_y_start(unit = "m/s") "initial lateral speed";
  parameter Real r_start(unit = "rad/s") "initial yaw rate";
protected
  constant Real v_least(unit = "m/s") = 1 "speed from which on the slip angles are those of the paper";
  final parameter Real F_zf(unit = "N") = m*g*l_r/(l_f + l_r)/2 "static load of one front tyre";
  final parameter Real F_zr(unit = "N") = m*g*l_f/(l_f + l_r)/2 "static load of one rear tyre";
  Real F_xr(unit = "N") "driving force of one rear tyre";
initial equation
  state.x = x_start;
  state.y = y_start;
  state.psi = psi_start;
  state.v_x = v_x_start;
  state.v_y = v_y_start;
  state.r = r_start;
equation
  // (3); below v_least the wheels go over into rolling without slip
  tyre.alpha_f = (state.v_y + l_f*state.r)/max(abs(state.v_x), v_least)
    - actuation.delta_f*min(max(state.v_x/v_least, -1), 1);
  tyre.alpha_r = (state.v_y - l_r*state.r)/max(abs(state.v_x), v_least);
  // (2)
  tyre.F_cf = -C_alpha_f*tyre.alpha_f;
  tyre.F_cr = -C_alpha_r*tyre.alpha_r;
  // (1)
  F_xr = actuation.T_r/R_w;
  der(state.x) = state.v_x*cos(state.psi) - state.v_y*sin(state.psi);
  der(state.y) = state.v_x*sin(state.psi) + state.v_y*cos(state.psi);
  der(state.psi) = state.r;
  der(state.v_x) = state.r*state.v_y - 2/m*(tyre.F_cf*sin(actuation.delta_f) - F_xr);
  der(state.v_y) = -state.r*state.v_x + 2/m*(tyre.F_cf*cos(actuation.delta_f) + tyre.F_cr);
  der(state.r) = 2/I_z*(l_f*tyre.F_cf - l_r*tyre.F_cr);
  // accelerations of the centre of gravity
  motion.a_x = der(state.v_x) - state.r*state.v_y;
  motion.a_y = der(state.v_y) + state.r*state.v_x;
  motion.r_dot = der(state.r);
  // shares of the friction limit
  tyre.mu_f = abs(tyre.F_cf)/(mu*F_zf);
  tyre.mu_r = sqrt(tyre.F_cr^2 + F_xr^2)/(mu*F_zr);
  annotation (
    Documentation(info = "<html>
<p>The same vehicle as macrostep's block <code>bicycle</code>. Two tyres per axle, hence the factors 2. Leaves out load
transfer, drag and the saturation of the tyre: <code>tyre.mu_f</code> and <code>tyre.mu_r</code> say how much of the
friction limit the linear tyre claims to use, and pass 1 where a real tyre would slide.</p>
<p>Reference point: centre of gravity. Equations (3) hold for v_x &gt;= 1 m/s; below, and at rest, the wheels
go over into rolling without slip.</p>
<p>C. Huang, B. Li, M. Kishida: Model predictive approach to integrated path planning and tracking for autonomous
vehicles.</p>
</html>"));
end Bicycle;
