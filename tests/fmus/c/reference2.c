#include "fmi2Functions.h"
#include "reference.h"

#define M_ M *m = (M *)c
#define NEED(test) if (!(test)) return fmi2Error

/* The folder of a URI such as file:///a%20b, or file:/a%20b, which is as good. */
static int folder_of(const char *uri, char *folder) {
    const char *p = strncmp(uri, "file:///", 8) ? uri + 5 : uri + 7;
    if (strncmp(uri, "file:/", 6)) return 0;
    for (; *p; p++) {
        char code[3] = {p[0] == '%' ? p[1] : 0, p[0] == '%' && p[1] ? p[2] : 0};
        *folder++ = code[1] ? (p += 2, (char)strtol(code, NULL, 16)) : *p;
    }
    strcpy(folder, "/");
    return 1;
}
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *f, fmi2Boolean visible, fmi2Boolean logging) {
    if (!name || !*name || strcmp(guid, TOKEN)) {
        f->logger(f->componentEnvironment, name, fmi2Error, "logStatusError", "The name or the GUID %s is wrong.", guid);
        return NULL;
    }
#ifdef ONLY_ONCE
    static int instances;
    if (instances++) return NULL;
#endif
    M *m = created(type == fmi2ModelExchange);
    if (resources && !folder_of(resources, m->resources)) { free(m); return NULL; }
    return m;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2Terminate(fmi2Component c) { M_; NEED(m->mode > INITIALIZATION); return fmi2OK; }
fmi2Status fmi2Reset(fmi2Component c) {
    M_;
    M *fresh = created(m->me);
    strcpy(fresh->resources, m->resources);
    *m = *fresh;
    free(fresh);
    return fmi2OK;
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean td, fmi2Real tolerance, fmi2Real t, fmi2Boolean sd, fmi2Real stop) {
    M_; NEED(m->mode == INSTANTIATED);
#ifdef LOADS_STARTS
    begin(m);
#endif
    initialize(m, t, sd, stop);
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { M_; NEED(m->mode == INSTANTIATED); m->mode = INITIALIZATION; return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    M_; NEED(m->mode == INITIALIZATION && !compute(m));
    m->mode = m->me ? EVENT : STEP_MODE;
    refresh(m);
    return fmi2OK;
}
fmi2Status fmi2EnterEventMode(fmi2Component c) { M_; NEED(m->me && m->mode == CONTINUOUS); m->mode = EVENT; return fmi2OK; }
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { M_; NEED(m->mode == EVENT); m->mode = CONTINUOUS; return fmi2OK; }
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    M_; NEED(m->mode == EVENT);
    m->changed = 0;
    event(m);
    info->newDiscreteStatesNeeded = info->nominalsOfContinuousStatesChanged = 0;
    info->terminateSimulation = m->ends;
    info->valuesOfContinuousStatesChanged = m->changed;
    info->nextEventTimeDefined = m->timed;
    info->nextEventTime = m->next_event;
    return fmi2OK;
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no, fmi2Boolean *enter, fmi2Boolean *end) { M_; NEED(m->mode == CONTINUOUS); *enter = *end = 0; return fmi2OK; }
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) { M_; NEED(m->me); R(0) = t; return fmi2OK; }
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) { M_; NEED(m->mode == CONTINUOUS && n == NX); for (int i = 0; i < NX; i++) R(states[i]) = x[i]; return fmi2OK; }
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) { M_; NEED(n == NX); for (int i = 0; i < NX; i++) x[i] = R(states[i]); return fmi2OK; }
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) { M_; NEED(n == NX && !compute(m)); for (int i = 0; i < NX; i++) dx[i] = R(derivatives[i]); return fmi2OK; }
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) { M_; NEED(n == NZ); if (NZ) z[0] = indicator(m); return fmi2OK; }
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) { NEED(n == NX); for (int i = 0; i < NX; i++) x[i] = 1; return fmi2OK; }

#define ACCESS(T)                                                                                                      \
    fmi2Status fmi2Get##T(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2##T v[]) {                     \
        M_; NEED(!compute(m));                                                                                         \
        for (size_t i = 0; i < n; i++) memcpy(v + i, m->v + AT(T, vr[i]), sizeof *v);                                  \
        return fmi2OK;                                                                                                 \
    }                                                                                                                  \
    fmi2Status fmi2Set##T(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2##T v[]) {               \
        M_;                                                                                                            \
        for (size_t i = 0; i < n; i++) { NEED(may_set(m, AT(T, vr[i]))); memcpy(m->v + AT(T, vr[i]), v + i, sizeof *v); } \
        return fmi2OK;                                                                                                 \
    }
ACCESS(Real) ACCESS(Integer) ACCESS(Boolean)
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String v[]) {
    M_; NEED(!compute(m));
    for (size_t i = 0; i < n; i++) v[i] = m->v[AT(String, vr[i])].bytes;
    return fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String v[]) {
    M_;
    for (size_t i = 0; i < n; i++) { NEED(may_set(m, AT(String, vr[i])) && strlen(v[i]) < sizeof(Slot)); strcpy(m->v[AT(String, vr[i])].bytes, v[i]); }
    return fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no) {
    M_; NEED(!m->me && m->mode == STEP_MODE);
    int pending;
    enum outcome outcome = advance(m, t, h, &pending);
    return outcome == WRONG ? fmi2Error : outcome == OVER ? fmi2Discard : fmi2OK;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *v) { M_; *v = m->ends; return kind == fmi2Terminated ? fmi2OK : fmi2Discard; }
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *v) { M_; *v = R(0); return kind == fmi2LastSuccessfulTime ? fmi2OK : fmi2Discard; }
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *s) { if (!*s) *s = malloc(sizeof(M)); memcpy(*s, c, sizeof(M)); return fmi2OK; }
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate s) { memcpy(c, s, sizeof(M)); return fmi2OK; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *s) { free(*s); *s = NULL; return fmi2OK; }
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *n) { *n = sizeof(M); return fmi2OK; }
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte bytes[], size_t n) { NEED(n == sizeof(M)); memcpy(bytes, s, n); return fmi2OK; }
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t n, fmi2FMUstate *s) { NEED(n == sizeof(M)); if (!*s) *s = malloc(n); memcpy(*s, bytes, n); return fmi2OK; }
const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
