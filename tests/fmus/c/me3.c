#include "me.h"
#include "fmi3Functions.h"

#define M_ M *m = (M *)c
#define MODE(test) if (!(test)) return fmi3Error

fmi3Instance fmi3InstantiateModelExchange(fmi3String n, fmi3String token, fmi3String r, fmi3Boolean v, fmi3Boolean l, fmi3InstanceEnvironment e, fmi3LogMessageCallback log) {
    if (strcmp(token, "me")) return NULL;
    M *m = calloc(1, sizeof(M));
    start(m);
    return m;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3Reset(fmi3Instance c) { M_; memset(m, 0, sizeof(M)); start(m); return fmi3OK; }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean d, fmi3Float64 tol, fmi3Float64 t, fmi3Boolean sd, fmi3Float64 s) { M_; MODE(m->mode == 0); m->v[0] = t; m->mode = 1; return fmi3OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { M_; MODE(m->mode == 1); m->mode = 2; return fmi3OK; }
fmi3Status fmi3EnterEventMode(fmi3Instance c) { M_; MODE(m->mode == 3); m->mode = 2; return fmi3OK; }
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) { M_; MODE(m->mode == 2); m->mode = 3; return fmi3OK; }
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals, fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    M_; MODE(m->mode == 2);
    Event e = {0};
    event(m, &e);
    *again = e.again; *terminate = e.terminate; *nominals = e.nominals; *values = e.values; *defined = e.next_defined; *next = e.next;
    return fmi3OK;
}
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no, fmi3Boolean *enter, fmi3Boolean *terminate) {
    M_; MODE(m->mode == 3);
    *enter = step_event(m);
    *terminate = 0;
    return fmi3OK;
}
fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 t) { M_; MODE(m->mode >= 2); m->v[0] = t; return fmi3OK; }
fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n) { M_; MODE(m->mode == 3 && n == NX); memcpy(m->v + 1, x, n * 8); return fmi3OK; }
fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) { M_; MODE(n == NX); memcpy(x, m->v + 1, n * 8); return fmi3OK; }
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 dx[], size_t n) { M_; if (compute(m)) return fmi3Error; memcpy(dx, m->v + 1 + NX, n * 8); return fmi3OK; }
fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 z[], size_t n) { M_; MODE(n == NZ); compute(m); indicators(m, z); return fmi3OK; }
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) { M_; for (size_t i = 0; i < n; i++) x[i] = nominal(m, i); return fmi3OK; }
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n) { *n = NX; return fmi3OK; }
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n) { *n = NZ; return fmi3OK; }
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 value[], size_t nv) { M_; compute(m); for (size_t i = 0; i < n; i++) value[i] = m->v[vr[i]]; return fmi3OK; }
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 value[], size_t nv) { M_; for (size_t i = 0; i < n; i++) m->v[vr[i]] = value[i]; return fmi3OK; }
fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Boolean value[], size_t nv) { M_; MODE(m->mode != 3); for (size_t i = 0; i < n; i++) m->v[vr[i]] = value[i]; return fmi3OK; }
const char *fmi3GetVersion(void) { return "3.0"; }
