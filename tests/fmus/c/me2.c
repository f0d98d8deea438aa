#include "me.h"
#include "fmi2Functions.h"

#define M_ M *m = (M *)c
#define MODE(test) if (!(test)) return fmi2Error

fmi2Component fmi2Instantiate(fmi2String n, fmi2Type type, fmi2String guid, fmi2String r, const fmi2CallbackFunctions *f, fmi2Boolean v, fmi2Boolean l) {
    if (type != fmi2ModelExchange || strcmp(guid, "me")) return NULL;
    M *m = calloc(1, sizeof(M));
    start(m);
    return m;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2Reset(fmi2Component c) { M_; memset(m, 0, sizeof(M)); start(m); return fmi2OK; }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real tol, fmi2Real t, fmi2Boolean sd, fmi2Real s) { M_; m->v[0] = t; return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { M_; MODE(m->mode == 0); m->mode = 1; return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { M_; MODE(m->mode == 1); m->mode = 2; return fmi2OK; }
fmi2Status fmi2EnterEventMode(fmi2Component c) { M_; MODE(m->mode == 3); m->mode = 2; return fmi2OK; }
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { M_; MODE(m->mode == 2); m->mode = 3; return fmi2OK; }
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    M_; MODE(m->mode == 2);
    Event e = {0};
    event(m, &e);
    info->newDiscreteStatesNeeded = e.again;
    info->terminateSimulation = e.terminate;
    info->nominalsOfContinuousStatesChanged = e.nominals;
    info->valuesOfContinuousStatesChanged = e.values;
    info->nextEventTimeDefined = e.next_defined;
    info->nextEventTime = e.next;
    return fmi2OK;
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no, fmi2Boolean *enter, fmi2Boolean *terminate) {
    M_; MODE(m->mode == 3);
    *enter = step_event(m);
    *terminate = 0;
    return fmi2OK;
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) { M_; MODE(m->mode >= 2); m->v[0] = t; return fmi2OK; }
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) { M_; MODE(m->mode == 3 && n == NX); memcpy(m->v + 1, x, n * 8); return fmi2OK; }
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) { M_; MODE(n == NX); memcpy(x, m->v + 1, n * 8); return fmi2OK; }
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) { M_; m->calls++; if (compute(m)) return fmi2Error; memcpy(dx, m->v + 1 + NX, n * 8); return fmi2OK; }
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) { M_; MODE(n == NZ); compute(m); indicators(m, z); return fmi2OK; }
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) { M_; for (size_t i = 0; i < n; i++) x[i] = nominal(m, i); return fmi2OK; }
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[]) { M_; compute(m); for (size_t i = 0; i < n; i++) value[i] = m->v[vr[i]]; return fmi2OK; }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[]) { M_; for (size_t i = 0; i < n; i++) m->v[vr[i]] = value[i]; return fmi2OK; }
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]) { M_; MODE(m->mode != 3); for (size_t i = 0; i < n; i++) m->v[vr[i]] = value[i]; return fmi2OK; }
const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
