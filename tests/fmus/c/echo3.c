/* Co-Simulation, FMI 3.0: every input of value reference k comes out at k + 100 after a step. 20 has 3 elements, 21 is
   2 x 3, 22 is 2 x 3 x 4, 23 has as many as the structural parameter 90 says, 24 is twice that; the others are scalar. */
#include <stdlib.h>
#include <string.h>
#include <stdio.h>
#include "fmi3Functions.h"

#define N 256
typedef struct { size_t n; void *data; size_t item; size_t *sizes; } Slot;
typedef struct { Slot slots[N]; int mode; } I;

static size_t length(I *i, unsigned vr) {
    size_t n = i->slots[90].data ? *(fmi3UInt64 *)i->slots[90].data : 2;
    switch (vr % 100) {
        case 20: return 3;
        case 21: return 6;
        case 22: return 24;
        case 23: return n;
        case 24: return 2 * n;
        default: return 1;
    }
}
static void *room(Slot *s, size_t n, size_t item) {
    if (s->n != n || s->item != item) { free(s->data); s->data = calloc(n, item); s->n = n; s->item = item; }
    return s->data;
}

#ifndef EXTRA
#define EXTRA
#endif
fmi3Instance fmi3InstantiateCoSimulation(fmi3String n, fmi3String token, fmi3String resources, fmi3Boolean v, fmi3Boolean l, fmi3Boolean e, fmi3Boolean early, const fmi3ValueReference r[], size_t nr, fmi3InstanceEnvironment env, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback u) {
    if (strcmp(token, "g")) { log(env, fmi3Error, "error", "the token is \"g\""); return NULL; }
    I *i = calloc(1, sizeof(I));
    EXTRA
    return i;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { ((I *)c)->mode = 1; return fmi3OK; }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { ((I *)c)->mode = 0; return fmi3OK; }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean d, fmi3Float64 tol, fmi3Float64 t, fmi3Boolean sd, fmi3Float64 s) { ((I *)c)->mode = 2; return fmi3OK; }
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { ((I *)c)->mode = 3; return fmi3OK; }

#define ACCESS(T)                                                                                                     \
    fmi3Status fmi3Set##T(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3##T v[], size_t nv) {     \
        size_t at = 0;                                                                                                 \
        for (size_t i = 0; i < n; i++) {                                                                               \
            if (vr[i] == 90 && ((I *)c)->mode != 1) return fmi3Error;                                                  \
            size_t each = length(c, vr[i]);                                                                                      \
            memcpy(room(((I *)c)->slots + vr[i], each, sizeof(fmi3##T)), v + at, each * sizeof(fmi3##T));              \
            at += each;                                                                                                \
        }                                                                                                              \
        return fmi3OK;                                                                                                 \
    }                                                                                                                  \
    fmi3Status fmi3Get##T(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3##T v[], size_t nv) {           \
        size_t at = 0;                                                                                                 \
        for (size_t i = 0; i < n; i++) {                                                                               \
            size_t each = length(c, vr[i]);                                                                            \
            memcpy(v + at, room(((I *)c)->slots + vr[i], each, sizeof(fmi3##T)), each * sizeof(fmi3##T));              \
            at += each;                                                                                                \
        }                                                                                                              \
        if (at != nv) return fmi3Error;                                                                                \
        return fmi3OK;                                                                                                 \
    }
ACCESS(Float64) ACCESS(Float32) ACCESS(Int8) ACCESS(UInt8) ACCESS(Int16) ACCESS(UInt16) ACCESS(Int32) ACCESS(UInt32)
ACCESS(Int64) ACCESS(UInt64) ACCESS(Boolean)

fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3String v[], size_t nv) {
    size_t at = 0;
    for (size_t i = 0; i < n; i++) {
        size_t each = length(c, vr[i]);
        char **to = room(((I *)c)->slots + vr[i], each, sizeof(char *));
        for (size_t k = 0; k < each; k++, at++) to[k] = strdup(v[at]);
    }
    return fmi3OK;
}
fmi3Status fmi3GetString(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3String v[], size_t nv) {
    size_t at = 0;
    for (size_t i = 0; i < n; i++) {
        size_t each = length(c, vr[i]);
        char **from = room(((I *)c)->slots + vr[i], each, sizeof(char *));
        for (size_t k = 0; k < each; k++, at++) v[at] = from[k] ? from[k] : "";
    }
    return fmi3OK;
}
typedef struct { size_t n; unsigned char *data; } Bytes;
fmi3Status fmi3SetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const size_t sizes[], const fmi3Binary v[], size_t nv) {
    size_t at = 0;
    for (size_t i = 0; i < n; i++) {
        size_t each = length(c, vr[i]);
        Bytes *to = room(((I *)c)->slots + vr[i], each, sizeof(Bytes));
        for (size_t k = 0; k < each; k++, at++) {
            to[k].n = sizes[at];
            to[k].data = malloc(to[k].n + 1);
            memcpy(to[k].data, v[at], to[k].n);
        }
    }
    return fmi3OK;
}
fmi3Status fmi3GetBinary(fmi3Instance c, const fmi3ValueReference vr[], size_t n, size_t sizes[], fmi3Binary v[], size_t nv) {
    size_t at = 0;
    for (size_t i = 0; i < n; i++) {
        size_t each = length(c, vr[i]);
        Bytes *from = room(((I *)c)->slots + vr[i], each, sizeof(Bytes));
        for (size_t k = 0; k < each; k++, at++) { sizes[at] = from[k].n; v[at] = from[k].data; }
    }
    return fmi3OK;
}
#ifndef STATUS
#define STATUS fmi3OK
#endif
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no, fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last) {
    I *i = c;
    *event = *terminate = *early = 0;
    *last = t + h;
    for (int k = 0; k < 100; k++) {
        Slot *s = i->slots + k;
        if (s->data) memcpy(room(s + 100, s->n, s->item), s->data, s->n * s->item);
    }
    return STATUS;
}
const char *fmi3GetVersion(void) { return "3.0"; }
