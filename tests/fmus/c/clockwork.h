/* Time, state, step and input events without states that move by themselves.
   1 x, 2 x' = rate, 3 rate (doubled at t = 0.25 and every 0.5 after), 4 gate (Boolean input), 5 number of times that
   the gate opened, 6 number of integrator steps, 7 end (the FMU asks to stop there), 8 iterations wanted at each event,
   9 left to iterate, 10 gate before, 11 next time event, 12 x at which the derivative fails */
#define NX 1
#define NZ 0
static void start(M *m) { m->v[3] = 1; m->v[7] = 1e9; m->v[11] = 0.25; m->v[12] = 1e9; }
static int compute(M *m) { m->v[2] = m->v[3]; return m->v[1] > m->v[12]; }
static void indicators(M *m, double *z) {}
static void event(M *m, Event *e) {
    if (m->v[9] == 0) m->v[9] = m->v[8] + 1;
    m->v[9]--;
    e->again = m->v[9] > 0;
    if (m->v[4] > m->v[10]) m->v[5]++;
    m->v[10] = m->v[4];
    if (m->v[0] >= m->v[11] - 1e-12) { m->v[3] *= 2; m->v[11] += 0.5; }
    e->terminate = m->v[0] >= m->v[7] - 1e-12;
    e->next_defined = 1;
    e->next = m->v[11] < m->v[7] ? m->v[11] : m->v[7];
}
static int step_event(M *m) { m->v[6]++; return 0; }
static double nominal(M *m, int i) { return 1; }
