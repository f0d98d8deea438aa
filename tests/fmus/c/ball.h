/* A bouncing ball: h' = v, v' = -g; v := -e v where h = 0 and v < 0. 1 h, 2 v, 3 h', 4 v', 5 g, 6 e, 7 number of bounces */
#define NX 2
#define NZ 1
static void start(M *m) { m->v[1] = 1; m->v[5] = 9.81; m->v[6] = 0.7; }
static int compute(M *m) { m->v[3] = m->v[2]; m->v[4] = -m->v[5]; return 0; }
static void indicators(M *m, double *z) { z[0] = m->v[1] == 0 && m->v[2] == 0 ? 1 : m->v[1]; }
static void event(M *m, Event *e) {
    if (m->v[1] <= 0 && m->v[2] < 0) {
        m->v[1] = 1e-300; /* above the ground, so that the next crossing is seen */
        m->v[2] *= -m->v[6];
        m->v[7]++;
        e->values = 1;
    }
}
static int step_event(M *m) { return 0; }
static double nominal(M *m, int i) { return 1; }
