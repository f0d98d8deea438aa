/* A counter that begins with 1, counts the seconds by time events, and ends the simulation when it reaches 10. */
enum { COUNTER = 1 };
#define NX 0
#define NZ 0
#define STEP 0.2
static const int states[1], derivatives[1];
static int near(double a, double b);
static int rule(int k) { return k == COUNTER ? BEFORE_START : NEVER; }
static void begin(M *m) { m->v[COUNTER].number = 1; m->next_event = 1; m->timed = 1; }
static int compute(M *m) { return 0; }
static double indicator(M *m) { return 0; }
static void event(M *m) {
    if (near(R(0), m->next_event)) { m->v[COUNTER].number++; m->next_event += 1; }
    m->ends = m->v[COUNTER].number >= 10;
}
