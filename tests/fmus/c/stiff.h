/* A stiff linear system with an input: x1' = -1000 x1 + 999 x2 + u, x2' = -x2 + u. 5 u, 6 y = x1 + 2 u */
#define NX 2
#define NZ 0
static void start(M *m) { m->v[1] = 2; m->v[2] = 1; }
static int compute(M *m) {
    double x1 = m->v[1], x2 = m->v[2], u = m->v[5];
    m->v[3] = -1000 * x1 + 999 * x2 + u;
    m->v[4] = -x2 + u;
    m->v[6] = x1 + 2 * u;
    return 0;
}
static void indicators(M *m, double *z) {}
static void event(M *m, Event *e) {}
static int step_event(M *m) { return 0; }
static double nominal(M *m, int i) { return i ? 1 : 10; }
