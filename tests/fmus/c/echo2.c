/* Co-Simulation, FMI 2.0: every input of value reference k comes out at k + 100 after a step. */
#include <stdlib.h>
#include <string.h>
#include <stdio.h>
#include "fmi2Functions.h"

typedef struct { double r[256]; int i[256], b[256]; char *s[256]; } I;

#ifndef EXTRA
#define EXTRA
#endif
fmi2Component fmi2Instantiate(fmi2String n, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *f, fmi2Boolean v, fmi2Boolean l) {
    if (strcmp(guid, "g")) {
        if (l) f->logger(f->componentEnvironment, n, fmi2Error, "error", "found %s, %d letter(s); valid: %s", guid, (int)strlen(guid), "g");
        return NULL;
    }
    I *i = calloc(1, sizeof(I));
    for (int k = 0; k < 256; k++) i->s[k] = "";
    EXTRA
    return i;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
#define ACCESS(T, m)                                                                                                   \
    fmi2Status fmi2Set##T(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2##T v[]) {               \
        for (size_t k = 0; k < n; k++) ((I *)c)->m[vr[k]] = v[k];                                                      \
        return fmi2OK;                                                                                                 \
    }                                                                                                                  \
    fmi2Status fmi2Get##T(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2##T v[]) {                     \
        for (size_t k = 0; k < n; k++) v[k] = ((I *)c)->m[vr[k]];                                                      \
        return fmi2OK;                                                                                                 \
    }
ACCESS(Real, r) ACCESS(Integer, i) ACCESS(Boolean, b)
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String v[]) {
    for (size_t k = 0; k < n; k++) ((I *)c)->s[vr[k]] = strdup(v[k]);
    return fmi2OK;
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String v[]) {
    for (size_t k = 0; k < n; k++) v[k] = ((I *)c)->s[vr[k]];
    return fmi2OK;
}
#ifndef STATUS
#define STATUS fmi2OK
#endif
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no) {
    I *i = c;
    for (int k = 0; k < 100; k++) {
        i->r[k + 100] = i->r[k]; i->i[k + 100] = i->i[k]; i->b[k + 100] = i->b[k]; i->s[k + 100] = i->s[k];
    }
    return STATUS;
}
const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
