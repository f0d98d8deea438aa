/* Co-Simulation, FMI 2.0: writes each call into the file TRACE, and shows what it was told.
   y = time reached, u input, k parameter; tolerance, start and stop as told, -1 for none. */
#include <stdio.h>
#include <stdlib.h>
#include "fmi2Functions.h"

enum { Y, U, K, TOLERANCE, START, STOP, N };
typedef struct { double r[N]; int ended; const fmi2CallbackFunctions *f; const char *name; } I;

static void trace(const char *call) {
    FILE *file = getenv("TRACE") ? fopen(getenv("TRACE"), "a") : NULL;
    if (file) { fprintf(file, "%s\n", call); fclose(file); }
}
static void start(I *i) { i->r[U] = 4; i->r[K] = 1; }
fmi2Component fmi2Instantiate(fmi2String n, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *f, fmi2Boolean v, fmi2Boolean l) {
    I *i = calloc(1, sizeof(I)); i->f = f; i->name = n; start(i); trace("instantiate"); return i;
}
void fmi2FreeInstance(fmi2Component c) { trace("free"); free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean td, fmi2Real tolerance, fmi2Real t, fmi2Boolean sd, fmi2Real stop) {
    I *i = c; trace("setup");
    i->r[TOLERANCE] = td ? tolerance : -1; i->r[Y] = i->r[START] = t; i->r[STOP] = sd ? stop : -1;
#ifdef LOADS_STARTS
    i->r[K] = 1;
#endif
#ifdef STOP_AT_SETUP
    if (!sd) return fmi2Error;
#endif
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { trace("enter"); return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    trace("exit");
#ifdef STOP_AT_EXIT
    if (((I *)c)->r[STOP] < 0) return fmi2Error;
#endif
    return fmi2OK;
}
fmi2Status fmi2Terminate(fmi2Component c) {
    trace("terminate");
#ifdef BAD_END
    return fmi2Error;
#endif
    return fmi2OK;
}
fmi2Status fmi2Reset(fmi2Component c) { trace("reset"); start(c); return fmi2OK; }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real v[]) {
    for (size_t k = 0; k < n; k++) { ((I *)c)->r[vr[k]] = v[k]; trace(vr[k] == U ? "set u" : "set k"); }
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real v[]) {
    for (size_t k = 0; k < n; k++) v[k] = ((I *)c)->r[vr[k]];
    return fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no) {
    I *i = c; trace("step");
    for (int k = 0; k < (int)i->r[K] - 1; k++)
        i->f->logger(i->f->componentEnvironment, i->name, fmi2Warning, "all", "%d warnings at %g s: %s", k, t, "it goes on");
#ifdef NEEDS_STOP
    if (t + h > i->r[STOP] + 1e-9) return fmi2Error;
#endif
#ifdef ENDS_AT
    if (t + h > ENDS_AT + 1e-9) { i->ended = 1; i->r[Y] = ENDS_AT; return fmi2Discard; }
#endif
#ifdef FAILS_AT
    if (t + h > FAILS_AT) return fmi2Error;
#endif
    i->r[Y] = t + h;
    return fmi2OK;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *v) {
    *v = kind == fmi2Terminated && ((I *)c)->ended; return fmi2OK;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *v) { *v = ((I *)c)->r[Y]; return fmi2OK; }
const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
