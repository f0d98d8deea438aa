/* A shaft with inertia J, damper d and spring c, which a torque turns: phi' = w, J w' = r tau + p - d w - c sin(phi).
   r is the ratio of the gear (1 or 2 in its enumeration) where it is enabled; the push p is 0.5 in every second quarter
   of a second, which time events count. The factor of the ratio comes from the resources where TABLE is defined.
   With BY_TYPE a value reference counts within its type, and its lowest four bits are its place. */
enum { PHI = 1, DER_PHI, W, DER_W, TAU, J, D, C, A, POWER, DUMMY, DER_DUMMY, FACTOR, TAU2,
       GEAR = 32, COUNT, SPARE, ENABLED = 40, MOVING, NAME = 48, TEXT };
#ifdef DUMMY_STATE
#define NX 3
static const int states[] = {PHI, W, DUMMY}, derivatives[] = {DER_PHI, DER_W, DER_DUMMY};
#else
#define NX 2
static const int states[] = {PHI, W}, derivatives[] = {DER_PHI, DER_W};
#endif
#define NZ 0
#define STEP 1e-3
#ifdef BY_TYPE
enum { PLACE_Real, PLACE_Integer = GEAR, PLACE_Boolean = ENABLED, PLACE_String = NAME };
#define AT(T, reference) (PLACE_##T + ((reference) & 15))
#endif

static int near(double a, double b);
static int rule(int k) {
    switch (k) {
        case PHI: case W: case TAU: case TAU2: case DUMMY: case ENABLED: return ALWAYS;
        case J: case D: case C: case GEAR: case SPARE: case NAME: return BEFORE_START;
        default: return NEVER;
    }
}
static void begin(M *m) {
    R(PHI) = 0.5; R(J) = 2; R(D) = 0.3; R(C) = 5; R(FACTOR) = 1;
    m->v[GEAR].number = 1;
    *(char *)&m->v[ENABLED] = 1;
    strcpy(m->v[NAME].bytes, "shaft");
    m->next_event = 0.25; m->timed = 1;
}
static int compute(M *m) {
#ifdef TABLE
    char path[5000];
    snprintf(path, sizeof path, "%stable.txt", m->resources);
    FILE *file = m->v[COUNT + 5].number ? NULL : fopen(path, "r");
    if (file) { fscanf(file, "%lf", &R(FACTOR)); fclose(file); m->v[COUNT + 5].number = 1; }
    if (!m->v[COUNT + 5].number) return 1;
#endif
    double ratio = *(char *)&m->v[ENABLED] ? R(FACTOR) * m->v[GEAR].number : 0;
    double push = m->v[COUNT].number % 2 ? 0.5 : 0;
    R(DER_PHI) = R(W);
    R(DER_W) = R(A) = (ratio * (R(TAU) + R(TAU2)) + push - R(D) * R(W) - R(C) * sin(R(PHI))) / R(J);
    R(POWER) = R(TAU) * R(W);
    m->v[MOVING].number = 0;
    *(char *)&m->v[MOVING] = fabs(R(W)) > 0.1;
    strcpy(m->v[TEXT].bytes, m->v[NAME].bytes);
    return 0;
}
static double indicator(M *m) { return 0; }
static void event(M *m) {
    if (near(R(0), m->next_event)) { m->v[COUNT].number++; m->next_event = 0.25 * (m->v[COUNT].number + 1); }
}
