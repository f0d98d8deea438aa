/* Co-Simulation, FMI 1.0: x' = k (u - x), in 100 explicit Euler steps per communication step; counts its steps.
   Reals 0 x, 1 k, 2 u, 3 x at the start, 4 the stop time, 5 u + x; Integers 0 number of steps, 1 mode (echo of 2);
   Booleans 0 echo of 1; Strings 0 echo of 1. NEEDS_STOP refuses to be initialised without a stop time. */
#include <stdlib.h>
#include <string.h>
#include "fmi1Functions.h"

typedef struct { double r[8]; int i[8]; char b[8]; const char *s[8]; int initialized; fmi1CallbackFunctions f; } M;
#define M_ M *m = (M *)c
#define F(name) m_fmi##name

fmi1Component F(InstantiateSlave)(fmi1String name, fmi1String guid, fmi1String location, fmi1String type, fmi1Real timeout, fmi1Boolean visible, fmi1Boolean interactive, fmi1CallbackFunctions f, fmi1Boolean log) {
    if (strcmp(guid, "g")) {
        if (log) f.logger(NULL, name, fmi1Error, "error", "the GUID is %s, not %s", "g", guid);
        return NULL;
    }
    M *m = calloc(1, sizeof(M));
    m->f = f;
    m->r[1] = 1;
    m->s[0] = m->s[1] = "";
    return m;
}
void F(FreeSlaveInstance)(fmi1Component c) { free(c); }
fmi1Status F(ResetSlave)(fmi1Component c) { M_; m->initialized = 0; memset(m->i, 0, sizeof m->i); m->b[0] = 0; m->s[0] = ""; return fmi1OK; }
fmi1Status F(InitializeSlave)(fmi1Component c, fmi1Real t, fmi1Boolean defined, fmi1Real stop) {
    M_;
#ifdef NEEDS_STOP
    if (!defined) return fmi1Error;
#endif
    if (m->initialized) return fmi1Error;
    m->initialized = 1;
    m->r[0] = m->r[3];
    m->r[4] = defined ? stop : -1;
    return fmi1OK;
}
fmi1Status F(TerminateSlave)(fmi1Component c) { return fmi1OK; }
fmi1Status F(DoStep)(fmi1Component c, fmi1Real t, fmi1Real h, fmi1Boolean fresh) {
    M_;
    if (!fresh) return fmi1Error;
    for (int n = 0; n < 100; n++) m->r[0] += h / 100 * m->r[1] * (m->r[2] - m->r[0]);
    m->i[0]++;
    m->i[1] = m->i[2];
    m->b[0] = m->b[1];
    m->s[0] = m->s[1];
    return fmi1OK;
}
#define ACCESS(T, field)                                                                                               \
    fmi1Status F(Set##T)(fmi1Component c, const fmi1ValueReference vr[], size_t n, const fmi1##T v[]) {                \
        for (size_t k = 0; k < n; k++) ((M *)c)->field[vr[k]] = v[k];                                                  \
        return fmi1OK;                                                                                                 \
    }                                                                                                                  \
    fmi1Status F(Get##T)(fmi1Component c, const fmi1ValueReference vr[], size_t n, fmi1##T v[]) {                      \
        M_;                                                                                                            \
        if (!m->initialized) return fmi1Error;                                                                         \
        m->r[5] = m->r[2] + m->r[0];                                                                                   \
        for (size_t k = 0; k < n; k++) v[k] = m->field[vr[k]];                                                         \
        return fmi1OK;                                                                                                 \
    }
ACCESS(Real, r) ACCESS(Integer, i) ACCESS(Boolean, b)
fmi1Status F(SetString)(fmi1Component c, const fmi1ValueReference vr[], size_t n, const fmi1String v[]) {
    for (size_t k = 0; k < n; k++) ((M *)c)->s[vr[k]] = strdup(v[k]);
    return fmi1OK;
}
fmi1Status F(GetString)(fmi1Component c, const fmi1ValueReference vr[], size_t n, fmi1String v[]) {
    for (size_t k = 0; k < n; k++) v[k] = ((M *)c)->s[vr[k]];
    return fmi1OK;
}
const char *F(GetVersion)() { return "1.0"; }
const char *F(GetTypesPlatform)() { return "standard32"; }
