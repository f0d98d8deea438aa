#include "fmi3Functions.h"
#define FINISHED finished(m->environment, m->told, R(0));
static void finished(void *environment, void *told, double t) {
    fmi3Boolean early;
    fmi3Float64 until;
    if (told) ((fmi3IntermediateUpdateCallback)told)(environment, t, fmi3False, fmi3True, fmi3True, fmi3False, &early, &until);
}
#include "reference.h"

#define M_ M *m = (M *)c
#define NEED(test) if (!(test)) return fmi3Error

static M *made(int me, fmi3String name, fmi3String token, fmi3String resources, fmi3InstanceEnvironment e, fmi3LogMessageCallback log) {
    if (!name || !*name || strcmp(token, TOKEN)) { log(e, fmi3Error, "logStatusError", "The name or the instantiation token is wrong."); return NULL; }
    M *m = created(me);
    strcpy(m->resources, resources ? resources : "");
    m->environment = e;
    return m;
}
#ifndef ONLY_CO_SIMULATION
fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging, fmi3InstanceEnvironment e, fmi3LogMessageCallback log) {
    return made(1, name, token, resources, e, log);
}
#endif
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[], size_t n, fmi3InstanceEnvironment e, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update) {
#ifndef HAS_EVENTS
    if (events) { log(e, fmi3Error, "logStatusError", "Event Mode is not supported."); return NULL; }
#endif
    M *m = made(0, name, token, resources, e, log);
    if (m) { m->events = events; m->early = early; m->told = (void *)update; }
    return m;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3Terminate(fmi3Instance c) { M_; NEED(m->mode > INITIALIZATION); return fmi3OK; }
fmi3Status fmi3Reset(fmi3Instance c) {
    M_;
    M *fresh = created(m->me);
    strcpy(fresh->resources, m->resources);
    fresh->events = m->events; fresh->early = m->early; fresh->told = m->told; fresh->environment = m->environment;
    *m = *fresh;
    free(fresh);
    return fmi3OK;
}
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean td, fmi3Float64 tolerance, fmi3Float64 t, fmi3Boolean sd, fmi3Float64 stop) { M_; NEED(m->mode == INSTANTIATED); initialize(m, t, sd, stop); m->mode = INITIALIZATION; return fmi3OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) {
    M_; NEED(m->mode == INITIALIZATION && !compute(m));
    m->mode = m->me || m->events ? EVENT : STEP_MODE;
    refresh(m);
    return fmi3OK;
}
fmi3Status fmi3EnterEventMode(fmi3Instance c) { M_; NEED(m->mode == (m->me ? CONTINUOUS : STEP_MODE) && (m->me || m->events)); m->mode = EVENT; return fmi3OK; }
#ifndef ONLY_CO_SIMULATION
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) { M_; NEED(m->me && m->mode == EVENT); m->mode = CONTINUOUS; return fmi3OK; }
#endif
fmi3Status fmi3EnterStepMode(fmi3Instance c) { M_; NEED(m->events && m->mode == EVENT); m->mode = STEP_MODE; return fmi3OK; }
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *end, fmi3Boolean *nominals, fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    M_; NEED(m->mode == EVENT);
    m->changed = 0;
    event(m);
    *again = *nominals = fmi3False;
    *end = m->ends; *values = m->changed; *defined = m->timed; *next = m->next_event;
    return fmi3OK;
}
#ifndef ONLY_CO_SIMULATION
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no, fmi3Boolean *enter, fmi3Boolean *end) { M_; NEED(m->mode == CONTINUOUS); *enter = *end = fmi3False; return fmi3OK; }
fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 t) { M_; NEED(m->me); R(0) = t; return fmi3OK; }
fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n) { M_; NEED(m->mode == CONTINUOUS && n == NX); for (int i = 0; i < NX; i++) R(states[i]) = x[i]; return fmi3OK; }
fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) { M_; NEED(n == NX); for (int i = 0; i < NX; i++) x[i] = R(states[i]); return fmi3OK; }
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 dx[], size_t n) { M_; NEED(n == NX && !compute(m)); for (int i = 0; i < NX; i++) dx[i] = R(derivatives[i]); return fmi3OK; }
fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 z[], size_t n) { M_; NEED(n == NZ); if (NZ) z[0] = indicator(m); return fmi3OK; }
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) { NEED(n == NX); for (int i = 0; i < NX; i++) x[i] = 1; return fmi3OK; }
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n) { *n = NX; return fmi3OK; }
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n) { *n = NZ; return fmi3OK; }
#endif

#define ACCESS(T)                                                                                                      \
    fmi3Status fmi3Get##T(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3##T v[], size_t nv) {           \
        M_; NEED(n == nv && !compute(m));                                                                              \
        for (size_t i = 0; i < n; i++) memcpy(v + i, m->v + vr[i], sizeof *v);                                         \
        return fmi3OK;                                                                                                 \
    }                                                                                                                  \
    fmi3Status fmi3Set##T(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3##T v[], size_t nv) {     \
        M_; NEED(n == nv);                                                                                             \
        for (size_t i = 0; i < n; i++) { NEED(may_set(m, vr[i])); memcpy(m->v + vr[i], v + i, sizeof *v); }            \
        return fmi3OK;                                                                                                 \
    }
ACCESS(Float64) ACCESS(Float32) ACCESS(Int8) ACCESS(UInt8) ACCESS(Int16) ACCESS(UInt16) ACCESS(Int32) ACCESS(UInt32)
ACCESS(Int64) ACCESS(UInt64) ACCESS(Boolean)
fmi3Status fmi3GetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3String v[], size_t nv) {
    M_; NEED(!compute(m));
    for (size_t i = 0; i < n; i++) v[i] = m->v[vr[i]].bytes;
    return fmi3OK;
}
fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3String v[], size_t nv) {
    M_;
    for (size_t i = 0; i < n; i++) { NEED(may_set(m, vr[i]) && strlen(v[i]) < sizeof(Slot)); strcpy(m->v[vr[i]].bytes, v[i]); }
    return fmi3OK;
}
fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[], fmi3Binary v[], size_t nv) {
    M_; NEED(!compute(m));
    for (size_t i = 0; i < n; i++) { v[i] = (fmi3Binary)m->v[vr[i]].bytes; sizes[i] = m->size[vr[i]]; }
    return fmi3OK;
}
fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t sizes[], const fmi3Binary v[], size_t nv) {
    M_;
    for (size_t i = 0; i < n; i++) {
        NEED(may_set(m, vr[i]) && sizes[i] <= sizeof(Slot));
        memcpy(m->v[vr[i]].bytes, v[i], sizes[i]);
        m->size[vr[i]] = sizes[i];
    }
    return fmi3OK;
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no, fmi3Boolean *event_needed, fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *reached) {
    M_; NEED(!m->me && m->mode == STEP_MODE);
    int pending;
    enum outcome outcome = advance(m, t, h, &pending);
    *event_needed = pending;
    *end = outcome == OVER;
    *early = m->early && outcome != DONE;
    *reached = R(0);
    return outcome == WRONG ? fmi3Error : fmi3OK;
}
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *s) { if (!*s) *s = malloc(sizeof(M)); memcpy(*s, c, sizeof(M)); return fmi3OK; }
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState s) { memcpy(c, s, sizeof(M)); return fmi3OK; }
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *s) { free(*s); *s = NULL; return fmi3OK; }
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState s, size_t *n) { *n = sizeof(M); return fmi3OK; }
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState s, fmi3Byte bytes[], size_t n) { NEED(n == sizeof(M)); memcpy(bytes, s, n); return fmi3OK; }
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte bytes[], size_t n, fmi3FMUState *s) { NEED(n == sizeof(M)); if (!*s) *s = malloc(n); memcpy(*s, bytes, n); return fmi3OK; }
const char *fmi3GetVersion(void) { return "3.0"; }
