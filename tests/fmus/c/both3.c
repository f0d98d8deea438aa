#include <stdlib.h>
#include "fmi3Functions.h"
typedef struct { double x; } M;
fmi3Instance fmi3InstantiateCoSimulation(fmi3String n, fmi3String token, fmi3String r, fmi3Boolean v, fmi3Boolean l, fmi3Boolean e, fmi3Boolean early, const fmi3ValueReference vr[], size_t nr, fmi3InstanceEnvironment env, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback u) { return calloc(1, sizeof(M)); }
fmi3Instance fmi3InstantiateModelExchange(fmi3String n, fmi3String token, fmi3String r, fmi3Boolean v, fmi3Boolean l, fmi3InstanceEnvironment e, fmi3LogMessageCallback log) { return calloc(1, sizeof(M)); }
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no, fmi3Boolean *event, fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last) {
    ((M *)c)->x += 1;
    *event = *end = *early = 0;
    *last = t + h;
    return fmi3OK;
}
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 v[], size_t nv) { for (size_t k = 0; k < n; k++) v[k] = vr[k] == 1 ? ((M *)c)->x : 1; return fmi3OK; }
fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n) { ((M *)c)->x = *x; return fmi3OK; }
fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) { *x = ((M *)c)->x; return fmi3OK; }
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 x[], size_t n) { *x = 1; return fmi3OK; }
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) { *x = 1; return fmi3OK; }
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n) { *n = 1; return fmi3OK; }
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n) { *n = 0; return fmi3OK; }
const char *fmi3GetVersion(void) { return "3.0"; }
