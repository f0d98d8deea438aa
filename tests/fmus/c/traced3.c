/* Co-Simulation, FMI 3.0: writes each call into the file TRACE, and shows what it was told.
   y = time reached, tolerance, start, stop as told (-1: none); n = events so far, one at each whole second. */
#include <stdio.h>
#include <stdlib.h>
#include "fmi3Functions.h"

enum { Y = 1, TOLERANCE, START, STOP, COUNT, N };
typedef struct { double r[N], next; int events, early; } I;

static void trace(const char *call) {
    FILE *file = getenv("TRACE") ? fopen(getenv("TRACE"), "a") : NULL;
    if (file) { fprintf(file, "%s\n", call); fclose(file); }
}
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[], size_t n, fmi3InstanceEnvironment e, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
    trace(logging ? "instantiate, logging" : "instantiate");
#ifdef DEMANDS_EVENTS
    if (!events) { if (logging) log(e, fmi3Error, "logStatusError", "Event Mode is needed"); return NULL; }
#endif
    I *i = calloc(1, sizeof(I)); i->events = events; i->early = early; i->next = 1; return i;
}
void fmi3FreeInstance(fmi3Instance c) { trace("free"); free(c); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean td, fmi3Float64 tolerance, fmi3Float64 t, fmi3Boolean sd, fmi3Float64 stop) {
    I *i = c; trace("enter");
    i->r[TOLERANCE] = td ? tolerance : -1; i->r[Y] = i->r[START] = t; i->r[STOP] = sd ? stop : -1; i->next = t + 1;
    return fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { trace("exit"); return fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance c) { trace("terminate"); return fmi3OK; }
fmi3Status fmi3Reset(fmi3Instance c) { trace("reset"); return fmi3OK; }
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 v[], size_t m) {
    for (size_t k = 0; k < n; k++) v[k] = ((I *)c)->r[vr[k]];
    return fmi3OK;
}
static void happen(I *i) { while (i->r[Y] > i->next - 1e-9) { i->r[COUNT] += 1; i->next += 1; } }
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *end, fmi3Boolean *nominals, fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    I *i = c; happen(i);
    *again = *end = *nominals = *values = fmi3False; *defined = fmi3True; *next = i->next;
#ifdef ENDS_BY_EVENT
    *end = i->r[Y] > ENDS_BY_EVENT - 1e-9;
#endif
    return fmi3OK;
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no, fmi3Boolean *event, fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *reached) {
    I *i = c; trace("step");
#ifdef NEEDS_STOP
    if (t + h > i->r[STOP] + 1e-9) return fmi3Error;
#endif
    *event = *end = *early = fmi3False; *reached = i->r[Y] = t + h;
#ifdef ENDS_AT
    if (t + h > ENDS_AT + 1e-9) { *end = fmi3True; if (i->early) { *early = fmi3True; *reached = i->r[Y] = ENDS_AT; } }
#endif
#ifdef EARLY_UNASKED
    if (t + h > EARLY_UNASKED) { *early = fmi3True; *reached = i->r[Y] = t + h / 2; }
#endif
    if (i->events) *event = i->r[Y] > i->next - 1e-9;
    else happen(i);
#ifdef FLAGS_ANYWAY
    *event = fmi3True;
#endif
    return fmi3OK;
}
