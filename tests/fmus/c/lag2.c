/* Co-Simulation, FMI 2.0: a lag x' = (u - x) / T, solved exactly: 1 u, 2 y = x, 3 T, 4 n (steps). s[4] are spare states.
   What is wrong with it is told by macros before this file is included. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2Functions.h"

typedef struct { double u, x, T, n, s[4]; } I;

#ifndef STEP /* one step of length h from t */
#define STEP i->x = i->u + (i->x - i->u) * exp(-h / i->T);
#endif
#ifndef SHOWN /* y */
#define SHOWN i->x
#endif
#ifndef ON_SET /* after inputs or parameters were set */
#define ON_SET
#endif
#ifndef ON_MAKING
#define ON_MAKING
#endif
#ifndef ON_RESET
#define ON_RESET begin(i);
#endif
#ifndef STATE /* what a state holds */
#define STATE I
#endif

static void begin(I *i) { memset(i, 0, sizeof(I)); i->T = 0.5; }

fmi2Component fmi2Instantiate(fmi2String n, fmi2Type type, fmi2String guid, fmi2String r, const fmi2CallbackFunctions *f, fmi2Boolean v, fmi2Boolean l) {
    ON_MAKING
    I *i = calloc(1, sizeof(I));
    begin(i);
    return i;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2Reset(fmi2Component c) { I *i = c; ON_RESET return fmi2OK; }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real v[]) {
    I *i = c;
    for (size_t k = 0; k < n; k++) { if (vr[k] == 1) i->u = v[k]; if (vr[k] == 3) i->T = v[k]; }
    ON_SET
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real v[]) {
    I *i = c;
    for (size_t k = 0; k < n; k++) v[k] = vr[k] == 1 ? i->u : vr[k] == 2 ? (SHOWN) : vr[k] == 3 ? i->T : i->n;
    return fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no) {
    I *i = c;
    i->n++;
    STEP
    return fmi2OK;
}
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *s) { if (!*s) *s = malloc(sizeof(I)); memcpy(*s, c, sizeof(STATE)); return fmi2OK; }
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate s) { memcpy(c, s, sizeof(STATE)); return fmi2OK; }
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *s) { free(*s); *s = NULL; return fmi2OK; }
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *n) { *n = sizeof(I); return fmi2OK; }
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte b[], size_t n) { memcpy(b, s, n); return fmi2OK; }
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte b[], size_t n, fmi2FMUstate *s) { *s = malloc(n); memcpy(*s, b, n); return fmi2OK; }
const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
