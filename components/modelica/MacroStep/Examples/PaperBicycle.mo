within MacroStep.Examples;
block PaperBicycle "The vehicle of the paper, driving at 10 m/s"
  extends Vehicle.Bicycle(
    // paper, Table 1
    m = 2000,
    I_z = 1300,
    l_f = 1.2,
    l_r = 1.05,
    C_alpha_f = 12000,
    C_alpha_r = 12000,
    mu = 0.5,
    // ours: Table 1 leaves them out
    R_w = 0.3,
    g = 9.81,
    // paper: P0 = (0, 0), 10 m/s; straight running along the road
    x_start = 0,
    y_start = 0,
    psi_start = 0,
    v_x_start = 10,
    v_y_start = 0,
    r_start = 0);
end PaperBicycle;
