#include <stdlib.h>
#include "fmi2Functions.h"
typedef struct { double x; int integrated; } M;
fmi2Component fmi2Instantiate(fmi2String n, fmi2Type type, fmi2String guid, fmi2String r, const fmi2CallbackFunctions *f, fmi2Boolean v, fmi2Boolean l) {
    M *m = calloc(1, sizeof(M));
    m->integrated = type == fmi2ModelExchange;
    return m;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no) { ((M *)c)->x += 1; return ((M *)c)->integrated ? fmi2Error : fmi2OK; }
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real v[]) { for (size_t k = 0; k < n; k++) v[k] = vr[k] ? 1 : ((M *)c)->x; return fmi2OK; }
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) { ((M *)c)->x = *x; return fmi2OK; }
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) { *x = ((M *)c)->x; return fmi2OK; }
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real x[], size_t n) { *x = 1; return fmi2OK; }
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) { *x = 1; return fmi2OK; }
const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
