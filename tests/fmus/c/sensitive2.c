/* FMI 2.0: y = RULE(u), computed when it is read; an input that the unit cannot take makes the call fail with FAILURE.
   Value references: 0 y, 1 u, 2 z (another output, of no input). */
#include <math.h>
#include <stdlib.h>
#include "fmi2Functions.h"

typedef struct { double r[3]; } I;
#ifndef FAILURE
#define FAILURE fmi2Error
#endif
fmi2Component fmi2Instantiate(fmi2String n, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *f, fmi2Boolean v, fmi2Boolean l) {
    I *i = calloc(1, sizeof(I)); i->r[1] = START; i->r[2] = 1; return i;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real v[]) {
    for (size_t k = 0; k < n; k++) ((I *)c)->r[vr[k]] = v[k];
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real v[]) {
    double *r = ((I *)c)->r, u = r[1];
    for (size_t k = 0; k < n; k++) {
        if (vr[k] == 0) {
            if (!(VALID)) return FAILURE;
            r[0] = RULE;
        }
        v[k] = r[vr[k]];
    }
    return fmi2OK;
}
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *e) {
    e->newDiscreteStatesNeeded = e->terminateSimulation = e->nominalsOfContinuousStatesChanged = fmi2False;
    e->valuesOfContinuousStatesChanged = e->nextEventTimeDefined = fmi2False;
    return fmi2OK;
}
const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
