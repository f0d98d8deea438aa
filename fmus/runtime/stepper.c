/* The native stepper: carries out the macro steps of a system whose schedule has been lowered to flat tables.
 *
 * It is compiled once per machine and loaded by orchestrator/stepping/native_stepper.py, whose tables have the layout
 * of the structures below; it is no part of any FMU. It gives the bits of the Python loop, which is the reference. What
 * it cannot do itself it asks Python for: other units, texts, and everything that is unusual.
 */
#define _POSIX_C_SOURCE 199309L /* clock_gettime */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <time.h>

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum { OK = 0, NOT_STARTED = -1 };

/* The same numbers as in native_stepper.py. */
typedef enum { ACCESS_FMI2, ACCESS_FMI3, STEP_FMI2, STEP_FMI3, COPY, GATHER, TABLE, ROW, LINEAR, CAST, PYTHON } Kind;

typedef struct {
    int32_t kind;
    int32_t call;            /* number of the call in Python that this is, or is a part of */
    int32_t width;           /* bytes of an element */
    int32_t from, to;        /* CAST: types of the elements, NumPy's letters in `CASTABLE` of native_stepper.py */
    int32_t earlier;         /* STEP: how many ticks before the present one it begins */
    int32_t multiple, parts; /* STEP: its length is a multiple or a part of the macro step; ROW: pace and 0 */
    void (*function)(void);
    void *component;
    const char *source;
    char *target;
    const int64_t *places; /* elements of the source, or of TABLE's target; NULL for the first ones */
    int64_t count;         /* elements */
    int64_t first;         /* ROW: the row at which the target begins */
    double factor, offset;
    char *results[4]; /* STEP_FMI3: event needed, terminate, early return, the time that is reached */
} Operation;

/* The floating-point numbers of one type, and which of them are expected to be finite. */
typedef struct {
    const void *values;
    const bool *expected;
    int64_t count;
    int32_t width;
} Watched;

typedef struct {
    const Operation *operations;
    const int32_t *bounds; /* by phase: where what leads from its tick to the next begins, then what completes that */
    const Operation *rows;
    const Watched *watched;
    int64_t n_rows, n_watched;
    int64_t period;
    int64_t tick;           /* the last that is complete, or in whose completion something failed */
    volatile int64_t *kept; /* number of ticks that have their row, which other threads read meanwhile */
    double start, h;
    double t, length; /* of the step that Python is asked about */
    double *step_times;
    int32_t (*python)(int32_t call, int32_t status); /* carries out a call or looks at its status; answers below */
    int32_t stop;                                    /* Python wants no further tick */
} Program;

/* What Python answers: something has failed, also where Ctrl-C came before Python could say so; the unit may go on; the
 * unit has come to its end, the others go on. */
enum { FAIL = 0, GO_ON = 1, ENDED = 2 };

/* What `advance` returns. */
enum { DONE = 0, FAILED = 1, NOT_FINITE = 2, STOPPED = 3, LATE = 4 };

typedef int (*AccessFmi2)(void *, const uint32_t *, size_t, const void *);
typedef int (*AccessFmi3)(void *, const uint32_t *, size_t, const void *, size_t);
typedef int (*StepFmi2)(void *, double, double, int);
typedef int (*StepFmi3)(void *, double, double, bool, bool *, bool *, bool *, double *);

static double now(void)
{
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return (double)at.tv_sec + 1e-9 * (double)at.tv_nsec;
}

#define GATHERED(TYPE)                                    \
    for (int64_t i = 0; i < o->count; ++i)                \
        ((TYPE *)target)[i] = ((const TYPE *)source)[o->places[i]];
#define SCATTERED(TYPE)                                   \
    for (int64_t i = 0; i < o->count; ++i)                \
        ((TYPE *)target)[o->places[i]] = ((const TYPE *)source)[i];

/* Copies the elements at `places` of the source, or its first ones. */
static void gather(const Operation *o, const char *source, char *target)
{
    if (!o->places) {
        memcpy(target, source, (size_t)(o->count * o->width));
        return;
    }
    switch (o->width) {
    case 1: GATHERED(uint8_t) break;
    case 2: GATHERED(uint16_t) break;
    case 4: GATHERED(uint32_t) break;
    default: GATHERED(uint64_t)
    }
}

static void scatter(const Operation *o, const char *source, char *target)
{
    switch (o->width) {
    case 1: SCATTERED(uint8_t) break;
    case 2: SCATTERED(uint16_t) break;
    case 4: SCATTERED(uint32_t) break;
    default: SCATTERED(uint64_t)
    }
}

static int64_t whole_number(const char *source, int32_t type, int64_t i)
{
    switch (type) {
    case '?': return ((const uint8_t *)source)[i] != 0;
    case 'b': return ((const int8_t *)source)[i];
    case 'B': return ((const uint8_t *)source)[i];
    case 'h': return ((const int16_t *)source)[i];
    case 'H': return ((const uint16_t *)source)[i];
    case 'i': return ((const int32_t *)source)[i];
    case 'I': return ((const uint32_t *)source)[i];
    default: return ((const int64_t *)source)[i];
    }
}

/* Copies whole numbers and truth values to elements of another type, as NumPy converts them. */
static void cast(const Operation *o)
{
    for (int64_t i = 0; i < o->count; ++i) {
        const int64_t value = whole_number(o->source, o->from, i);
        switch (o->to) {
        case '?': ((uint8_t *)o->target)[i] = value != 0; break;
        case 'b': ((int8_t *)o->target)[i] = (int8_t)value; break;
        case 'B': ((uint8_t *)o->target)[i] = (uint8_t)value; break;
        case 'h': ((int16_t *)o->target)[i] = (int16_t)value; break;
        case 'H': ((uint16_t *)o->target)[i] = (uint16_t)value; break;
        case 'i': ((int32_t *)o->target)[i] = (int32_t)value; break;
        case 'I': ((uint32_t *)o->target)[i] = (uint32_t)value; break;
        case 'd': ((double *)o->target)[i] = (double)value; break;
        default: ((int64_t *)o->target)[i] = value;
        }
    }
}

static void linear(const Operation *o)
{
    for (int64_t i = 0; i < o->count; ++i)
        ((double *)o->target)[i] = o->factor * ((const double *)o->source)[i] + o->offset;
}

/* Whether the FMU says of a step to `end` what is usual: no flag is set, and its time is that one or never written. */
static bool is_usual(const Operation *o, double end)
{
    const double reached = *(const double *)o->results[3];
    return !(*o->results[0] || *o->results[1] || *o->results[2]) && (reached == end || reached == -1.7e308);
}

/* These return whether something has failed. */
static bool step(Program *p, const Operation *o)
{
    for (int32_t part = 0; part < o->parts; ++part) {
        double t = p->start + (double)p->tick * p->h, h = p->h;
        if (o->multiple > 1) {
            t = p->start + (double)(p->tick - o->earlier) * p->h;
            h = o->multiple * p->h;
        } else if (o->parts > 1) {
            h = p->h / o->parts;
            t = t + part * h;
        }
        bool usual = true;
        int status;
        if (o->kind == STEP_FMI2) {
            status = ((StepFmi2)o->function)(o->component, t, h, 1);
        } else {
            status = ((StepFmi3)o->function)(o->component, t, h, true, (bool *)o->results[0], (bool *)o->results[1],
                                             (bool *)o->results[2], (double *)o->results[3]);
            usual = is_usual(o, t + h);
        }
        if (status != OK || !usual) {
            p->t = t;
            p->length = h;
            const int32_t answer = p->python(o->call, status);
            if (answer != GO_ON)
                return answer == FAIL;
        }
    }
    return false;
}

static bool carry_out(Program *p, const Operation *o)
{
    int status = OK;
    switch ((Kind)o->kind) {
    case ACCESS_FMI2:
        status = ((AccessFmi2)o->function)(o->component, (const uint32_t *)o->places, (size_t)o->first, o->target);
        break;
    case ACCESS_FMI3:
        status = ((AccessFmi3)o->function)(o->component, (const uint32_t *)o->places, (size_t)o->first, o->target,
                                           (size_t)o->count);
        break;
    case STEP_FMI2:
    case STEP_FMI3:
        return step(p, o);
    case COPY:
    case GATHER:
        gather(o, o->source, o->target);
        return false;
    case TABLE:
        scatter(o, o->source + p->tick * o->count * o->width, o->target);
        return false;
    case ROW:
        if (p->tick % o->multiple == 0)
            gather(o, o->source, o->target + (p->tick / o->multiple - o->first) * o->count * o->width);
        return false;
    case LINEAR:
        linear(o);
        return false;
    case CAST:
        cast(o);
        return false;
    case PYTHON:
        return p->python(o->call, OK) == FAIL;
    }
    return status != OK && p->python(o->call, status) == FAIL;
}

static bool carry_out_all(Program *p, const Operation *first, const Operation *end)
{
    for (const Operation *o = first; o < end; ++o) {
        if (carry_out(p, o))
            return true;
    }
    return false;
}

#define UNEXPECTED(TYPE)                                  \
    for (int64_t i = 0; i < w->count; ++i)                \
        n += (isfinite(((const TYPE *)w->values)[i]) != 0) != w->expected[i];

/* Whether exactly those numbers are finite that are expected to be. */
static bool as_expected(const Program *p)
{
    int64_t n = 0;
    for (const Watched *w = p->watched; w < p->watched + p->n_watched; ++w) {
        if (w->width == 4) {
            UNEXPECTED(float)
        } else {
            UNEXPECTED(double)
        }
    }
    return n == 0;
}

/* The sizes of the structures, by which Python sees that its tables have their layout. */
EXPORT int64_t stepper_layout(void)
{
    return (int64_t)(sizeof(Operation) * 1000000 + sizeof(Watched) * 1000 + sizeof(Program));
}

/* Completes ticks up to `last`, or until `seconds` of wall time are over; then the last tick is complete, but for
 * FAILED. Signals of Python are dealt with between two calls of this. */
EXPORT int32_t stepper_advance(Program *p, int64_t last, double seconds)
{
    const double entered = now();
    double began = entered;
    while (p->tick < last) {
        const int64_t phase = p->tick == NOT_STARTED ? p->period - 1 : p->tick % p->period;
        const int32_t *bounds = p->bounds + 2 * phase;
        if (p->tick != NOT_STARTED && carry_out_all(p, p->operations + bounds[0], p->operations + bounds[1]))
            return FAILED;
        p->tick += 1;
        if (carry_out_all(p, p->operations + bounds[1], p->operations + bounds[2]))
            return FAILED;
        if (carry_out_all(p, p->rows, p->rows + p->n_rows))
            return FAILED;
        *p->kept = p->tick + 1;
        const bool fine = as_expected(p);
        const double ended = now();
        p->step_times[p->tick] = ended - began;
        began = ended;
        if (!fine)
            return NOT_FINITE;
        if (p->stop)
            return STOPPED;
        if (ended - entered > seconds)
            return LATE;
    }
    return DONE;
}
