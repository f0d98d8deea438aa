/* A Co-Simulation FMU of FMI 3.0 with a clock of every kind, strict about modes; it counts and notes what ticks.
   Clocks: 10 constant, 11 fixed (its interval is set), 12 tunable (0.3 s, 0.2 s from its second tick on), 13 countdown
   (0.1 s after each early return), 14 triggered, 15 beat (output: ticks with the constant one).
   1 u; 20..24 ticks of 10..14, 25 early returns; 30..34 time of the last tick, 35 of the last early return;
   40 sampled = u + w at the tick of 11 and 41 w, both clocked by 11. Parameter 2: 1 to ask for the end at t = 0.5. */
#include <stdlib.h>
#include <string.h>
#include "fmi3Functions.h"

enum { CONSTANT = 10, FIXED, TUNABLE, COUNTDOWN, TRIGGERED, BEAT };
enum mode { INSTANTIATED, INITIALIZATION, EVENT, STEP };

typedef struct {
    enum mode mode;
    double t, u, w, sampled, interval, last[6];
    int active[6], n[6], countdown, end;
} Metronome;

#define M Metronome *m = (Metronome *)instance
#define IN(wanted) if (m->mode != (wanted)) return fmi3Error

static const double early[] = {0.33, 0.77};

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String path, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early_return, const fmi3ValueReference intermediate[], size_t n,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    Metronome *m = calloc(1, sizeof *m);
    m->interval = events ? -1 : 0;
    return m;
}
void fmi3FreeInstance(fmi3Instance instance) { free(instance); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean d, fmi3Float64 tol, fmi3Float64 t,
    fmi3Boolean sd, fmi3Float64 stop) { M; IN(INSTANTIATED); m->mode = INITIALIZATION; return fmi3OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    M; IN(INITIALIZATION);
    if (m->interval < 0) return fmi3Error; /* nobody has set the interval of the fixed clock */
    m->mode = EVENT;
    return fmi3OK;
}
fmi3Status fmi3EnterEventMode(fmi3Instance instance) { M; IN(STEP); m->mode = EVENT; return fmi3OK; }
fmi3Status fmi3EnterStepMode(fmi3Instance instance) { M; IN(EVENT); m->mode = STEP; return fmi3OK; }
fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 v[]) {
    M; IN(INITIALIZATION);
    if (n != 1 || vr[0] != FIXED) return fmi3Error;
    m->interval = v[0];
    return fmi3OK;
}
fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 v[],
    fmi3IntervalQualifier q[]) {
    M; IN(EVENT);
    for (size_t i = 0; i < n; i++) {
        q[i] = fmi3IntervalUnchanged;
        if (vr[i] == TUNABLE) { v[i] = m->n[2] >= 2 ? 0.2 : 0.3; q[i] = fmi3IntervalChanged; }
        else if (vr[i] == COUNTDOWN) { v[i] = 0.1; q[i] = m->countdown ? fmi3IntervalChanged : fmi3IntervalNotYetKnown; m->countdown = 0; }
        else return fmi3Error;
    }
    return fmi3OK;
}
fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 v[]) {
    for (size_t i = 0; i < n; i++) v[i] = 0.1;
    return fmi3OK;
}
fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Clock v[]) {
    M; IN(EVENT);
    for (size_t i = 0; i < n; i++) {
        int k = vr[i] - CONSTANT;
        if (k < 0 || k > 4 || !v[i] || m->active[k]) return fmi3Error;
        m->active[k] = 1;
        m->n[k]++;
        m->last[k] = m->t;
        if (vr[i] == CONSTANT) m->active[BEAT - CONSTANT] = 1;
    }
    return fmi3OK;
}
fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Clock v[]) {
    M; IN(EVENT);
    for (size_t i = 0; i < n; i++) v[i] = m->active[vr[i] - CONSTANT];
    return fmi3OK;
}
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again, fmi3Boolean *terminate,
    fmi3Boolean *nominals, fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    M; IN(EVENT);
    *again = *nominals = *values = *defined = fmi3False;
    *terminate = m->end && m->t >= 0.5 - 1e-9;
    memset(m->active, 0, sizeof m->active);
    return fmi3OK;
}
fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set, fmi3Boolean *event,
    fmi3Boolean *terminate, fmi3Boolean *early_return, fmi3Float64 *reached) {
    M; IN(STEP);
    *event = *terminate = *early_return = fmi3False;
    *reached = m->t = t + h;
    for (int i = 0; i < 2; i++)
        if (t < early[i] - 1e-12 && early[i] < t + h - 1e-12) {
            *event = *early_return = fmi3True;
            *reached = m->t = early[i];
            m->n[5]++;
            m->last[5] = early[i];
            m->countdown = 1;
            break;
        }
    return fmi3OK;
}
fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 v[], size_t nv) {
    M;
    for (size_t i = 0; i < n; i++)
        if (vr[i] == 1) m->u = v[i];
        else if (vr[i] == 2) m->end = v[i] != 0;
        else if (vr[i] == 41 && m->active[FIXED - CONSTANT]) m->w = v[i];
        else return fmi3Error;
    return fmi3OK;
}
fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 v[], size_t nv) {
    M;
    for (size_t i = 0; i < n; i++)
        if (vr[i] >= 30 && vr[i] < 36) v[i] = m->last[vr[i] - 30];
        else if (vr[i] == 40 && m->active[FIXED - CONSTANT]) v[i] = m->sampled = m->u + m->w;
        else return fmi3Error;
    return fmi3OK;
}
fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Int32 v[], size_t nv) {
    M;
    for (size_t i = 0; i < n; i++) v[i] = m->n[vr[i] - 20];
    return fmi3OK;
}
