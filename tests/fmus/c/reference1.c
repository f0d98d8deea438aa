/* The models of reference.h for FMI 1.0, Co-Simulation or Model Exchange; ID is the model identifier, which every
   function has in front of its name. */
#include "reference.h"
#include "fmi1Functions.h"

#define M_ M *m = (M *)c
#define NEED(test) if (!(test)) return fmi1Error
#define PASTED(a, b) a##_fmi##b
#define NAMED(a, b) PASTED(a, b)
#define F(name) NAMED(ID, name)

static void update(M *m, fmi1EventInfo *info) {
    m->changed = 0;
    event(m);
    info->iterationConverged = 1;
    info->stateValueReferencesChanged = 0;
    info->stateValuesChanged = m->changed;
    info->terminateSimulation = m->ends;
    info->upcomingTimeEvent = m->timed;
    info->nextEventTime = m->next_event;
}
fmi1Component F(InstantiateModel)(fmi1String name, fmi1String guid, fmi1CallbackFunctions f, fmi1Boolean logging) { return strcmp(guid, TOKEN) ? NULL : created(1); }
fmi1Component F(InstantiateSlave)(fmi1String name, fmi1String guid, fmi1String location, fmi1String type, fmi1Real timeout, fmi1Boolean visible, fmi1Boolean interactive, fmi1CallbackFunctions f, fmi1Boolean logging) { return strcmp(guid, TOKEN) ? NULL : created(0); }
void F(FreeModelInstance)(fmi1Component c) { free(c); }
void F(FreeSlaveInstance)(fmi1Component c) { free(c); }
fmi1Status F(Initialize)(fmi1Component c, fmi1Boolean td, fmi1Real tolerance, fmi1EventInfo *info) { M_; NEED(m->mode == INSTANTIATED); m->mode = CONTINUOUS; update(m, info); return fmi1OK; }
fmi1Status F(InitializeSlave)(fmi1Component c, fmi1Real t, fmi1Boolean sd, fmi1Real stop) { M_; NEED(m->mode == INSTANTIATED); initialize(m, t, sd, stop); refresh(m); m->mode = STEP_MODE; return fmi1OK; }
fmi1Status F(ResetSlave)(fmi1Component c) { M_; M *fresh = created(0); *m = *fresh; free(fresh); return fmi1OK; }
fmi1Status F(EventUpdate)(fmi1Component c, fmi1Boolean steps, fmi1EventInfo *info) { M_; NEED(m->mode == CONTINUOUS); update(m, info); return fmi1OK; }
fmi1Status F(CompletedIntegratorStep)(fmi1Component c, fmi1Boolean *call) { *call = 0; return fmi1OK; }
fmi1Status F(SetTime)(fmi1Component c, fmi1Real t) { M_; R(0) = t; return fmi1OK; }
fmi1Status F(SetContinuousStates)(fmi1Component c, const fmi1Real x[], size_t n) { M_; NEED(m->mode == CONTINUOUS && n == NX); for (int i = 0; i < NX; i++) R(states[i]) = x[i]; return fmi1OK; }
fmi1Status F(GetContinuousStates)(fmi1Component c, fmi1Real x[], size_t n) { M_; NEED(m->mode == CONTINUOUS && n == NX); for (int i = 0; i < NX; i++) x[i] = R(states[i]); return fmi1OK; }
fmi1Status F(GetDerivatives)(fmi1Component c, fmi1Real dx[], size_t n) { M_; NEED(n == NX && !compute(m)); for (int i = 0; i < NX; i++) dx[i] = R(derivatives[i]); return fmi1OK; }
fmi1Status F(GetNominalContinuousStates)(fmi1Component c, fmi1Real x[], size_t n) { for (int i = 0; i < NX; i++) x[i] = 1; return fmi1OK; }
fmi1Status F(GetEventIndicators)(fmi1Component c, fmi1Real z[], size_t n) { M_; NEED(n == NZ); if (NZ) z[0] = indicator(m); return fmi1OK; }
fmi1Status F(DoStep)(fmi1Component c, fmi1Real t, fmi1Real h, fmi1Boolean fresh) {
    M_; NEED(m->mode == STEP_MODE);
    int pending;
    return advance(m, t, h, &pending) == DONE ? fmi1OK : fmi1Error;
}
#define ACCESS(T)                                                                                                      \
    fmi1Status F(Get##T)(fmi1Component c, const fmi1ValueReference vr[], size_t n, fmi1##T v[]) {                      \
        M_; NEED(m->mode != INSTANTIATED && !compute(m));                                                              \
        for (size_t i = 0; i < n; i++) memcpy(v + i, m->v + AT(T, vr[i]), sizeof *v);                                  \
        return fmi1OK;                                                                                                 \
    }                                                                                                                  \
    fmi1Status F(Set##T)(fmi1Component c, const fmi1ValueReference vr[], size_t n, const fmi1##T v[]) {                \
        M_;                                                                                                            \
        for (size_t i = 0; i < n; i++) { NEED(may_set(m, AT(T, vr[i]))); memcpy(m->v + AT(T, vr[i]), v + i, sizeof *v); } \
        return fmi1OK;                                                                                                 \
    }
ACCESS(Real) ACCESS(Integer) ACCESS(Boolean)
const char *F(GetVersion)() { return "1.0"; }
const char *F(GetModelTypesPlatform)() { return "standard32"; }
const char *F(GetTypesPlatform)() { return "standard32"; }
