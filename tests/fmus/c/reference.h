/* The equals of the Reference FMUs: their variables, flags and numbers, written anew. One struct for all of them, the
   model in functions of its own header, forward Euler in steps of STEP inside the Co-Simulation ones.
   Every variable has a slot by its value reference; 0 is the time. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef union { double real; int number; char bytes[128]; } Slot;

enum mode { INSTANTIATED, INITIALIZATION, EVENT, CONTINUOUS, STEP_MODE };
enum outcome { DONE, EARLY, OVER, WRONG };
enum settable { ALWAYS, AT_EVENTS, BEFORE_START, NEVER };

typedef struct {
    Slot v[64];
    size_t size[64];           /* of binary values */
    double start, stop, point; /* the communication point that comes next */
    double next_event, z_before;
    long steps;
    int me, mode, events, early, timed, ends, changed; /* timed: next_event is defined; changed: the states are others */
    char resources[4096];      /* the folder, with a slash at its end */
    void *environment, *told;  /* for what FINISHED calls */
} M;

#define R(k) (m->v[k].real)
#ifndef FINISHED
#define FINISHED
#endif

#include MODEL /* NX, NZ, STEP, states, derivatives, rule, begin, compute, indicator, event */
#ifndef AT /* the slot of a value reference of a type; some makers count each type for itself */
#define AT(T, reference) (reference)
#endif

static int near(double a, double b) {
    double d = fabs(a - b);
    return d <= 1e-5 || d <= 1e-5 * fmax(fabs(a), fabs(b));
}
static M *created(int me) {
    M *m = calloc(1, sizeof(M));
    m->me = me;
    begin(m);
    return m;
}
static void initialize(M *m, double start, int stop_defined, double stop) {
    R(0) = m->start = m->point = start;
    m->stop = stop_defined ? stop : INFINITY;
}
static int may_set(M *m, unsigned reference) {
    int before = m->mode <= INITIALIZATION;
    switch (rule(reference)) {
        case ALWAYS: return 1;
        case AT_EVENTS: return !m->me || before || m->mode == EVENT;
        case BEFORE_START: return before;
        default: return 0;
    }
}
/* One step of forward Euler; whether there is an event at its end. */
static int euler(M *m) {
    double dx[NX + 1], z;
    int crossed = 0;
    compute(m);
    for (int i = 0; i < NX; i++) dx[i] = R(derivatives[i]);
    for (int i = 0; i < NX; i++) R(states[i]) += STEP * dx[i];
    m->steps++;
    R(0) = m->start + m->steps * STEP;
    if (NZ) {
        z = indicator(m);
        crossed = (m->z_before > 0) != (z > 0);
        m->z_before = z;
    }
    FINISHED
    return crossed || (m->timed && R(0) >= m->next_event);
}
static void refresh(M *m) { if (NZ) m->z_before = indicator(m); }
/* Advance to t + h, as far as whole steps go; without an importer that handles events, they are handled here. */
static enum outcome advance(M *m, double t, double h, int *pending) {
    double end = t + h;
    *pending = 0;
    if (!near(t, m->point) || h <= 0 || (end > m->stop && !near(end, m->stop))) return WRONG;
    while (R(0) + STEP <= end || near(R(0) + STEP, end)) {
        if (*pending) event(m);
        *pending = euler(m);
        if (*pending) {
            if (!m->events) { event(m); refresh(m); *pending = 0; }
            if (m->early) { m->point = R(0); return m->ends ? OVER : EARLY; }
        }
        if (m->ends) { m->point = R(0); return OVER; }
    }
    m->point = end;
    return DONE;
}
