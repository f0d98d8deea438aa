/* The Model Exchange FMU of me.h for FMI 1.0, which has no modes. */
#include "me.h"
#include "fmi1Functions.h"

#define M_ M *m = (M *)c
#define NEEDS(test) if (!(test)) return fmi1Error
#define F(name) m_fmi##name

static void update(M *m, fmi1EventInfo *info) {
    Event e = {0};
    do event(m, &e); while (e.again);
    info->iterationConverged = 1;
    info->stateValueReferencesChanged = 0;
    info->stateValuesChanged = e.values;
    info->terminateSimulation = e.terminate;
    info->upcomingTimeEvent = e.next_defined;
    info->nextEventTime = e.next;
}
fmi1Component F(InstantiateModel)(fmi1String n, fmi1String guid, fmi1CallbackFunctions f, fmi1Boolean l) {
    if (strcmp(guid, "me")) return NULL;
    M *m = calloc(1, sizeof(M));
    start(m);
    return m;
}
void F(FreeModelInstance)(fmi1Component c) { free(c); }
fmi1Status F(SetTime)(fmi1Component c, fmi1Real t) { M_; m->v[0] = t; return fmi1OK; }
fmi1Status F(Initialize)(fmi1Component c, fmi1Boolean controlled, fmi1Real tol, fmi1EventInfo *info) { M_; NEEDS(m->mode == 0); m->mode = 1; update(m, info); return fmi1OK; }
fmi1Status F(EventUpdate)(fmi1Component c, fmi1Boolean steps, fmi1EventInfo *info) { M_; NEEDS(m->mode == 1); update(m, info); return fmi1OK; }
fmi1Status F(CompletedIntegratorStep)(fmi1Component c, fmi1Boolean *call) { M_; NEEDS(m->mode == 1); *call = step_event(m); return fmi1OK; }
fmi1Status F(SetContinuousStates)(fmi1Component c, const fmi1Real x[], size_t n) { M_; NEEDS(m->mode == 1 && n == NX); memcpy(m->v + 1, x, n * 8); return fmi1OK; }
fmi1Status F(GetContinuousStates)(fmi1Component c, fmi1Real x[], size_t n) { M_; NEEDS(m->mode == 1 && n == NX); memcpy(x, m->v + 1, n * 8); return fmi1OK; }
fmi1Status F(GetDerivatives)(fmi1Component c, fmi1Real dx[], size_t n) { M_; if (compute(m)) return fmi1Error; memcpy(dx, m->v + 1 + NX, n * 8); return fmi1OK; }
fmi1Status F(GetEventIndicators)(fmi1Component c, fmi1Real z[], size_t n) { M_; NEEDS(n == NZ); compute(m); indicators(m, z); return fmi1OK; }
fmi1Status F(GetNominalContinuousStates)(fmi1Component c, fmi1Real x[], size_t n) { M_; for (size_t i = 0; i < n; i++) x[i] = nominal(m, i); return fmi1OK; }
fmi1Status F(GetReal)(fmi1Component c, const fmi1ValueReference vr[], size_t n, fmi1Real value[]) { M_; NEEDS(m->mode == 1); compute(m); for (size_t i = 0; i < n; i++) value[i] = m->v[vr[i]]; return fmi1OK; }
fmi1Status F(SetReal)(fmi1Component c, const fmi1ValueReference vr[], size_t n, const fmi1Real value[]) { M_; for (size_t i = 0; i < n; i++) m->v[vr[i]] = value[i]; return fmi1OK; }
fmi1Status F(SetBoolean)(fmi1Component c, const fmi1ValueReference vr[], size_t n, const fmi1Boolean value[]) { M_; for (size_t i = 0; i < n; i++) m->v[vr[i]] = value[i]; return fmi1OK; }
const char *F(GetVersion)() { return "1.0"; }
const char *F(GetModelTypesPlatform)() { return "standard32"; }
