/* The core of a co-simulation FMU: one instance of `model`, independent of the version of FMI.
 *
 * The shims fmi2.c and fmi3.c translate the two versions of FMI to these functions and nothing else. Every function
 * that returns a Status has logged why when it is not STATUS_OK. `call` is always the name of the FMI function on
 * whose behalf the core acts; it opens the message.
 *
 * An instance is one allocation; nothing is allocated while it steps, and nothing is shared between instances.
 */
#ifndef MACROSTEP_CORE_H
#define MACROSTEP_CORE_H

#include "model.h"

#ifdef __GNUC__
#pragma GCC visibility push(hidden) /* see model.h */
#endif

/* The same numbers as in fmi2Status and fmi3Status. */
typedef enum { STATUS_OK = 0, STATUS_WARNING = 1, STATUS_ERROR = 3 } Status;

/* Who uses the instance, and how to reach its log. `callback` is the logger of FMI, which `log` knows to call. */
typedef struct Host Host;
struct Host {
    void (*log)(const Host *host, Status status, const char *message);
    void (*callback)(void);
    void *environment;
    const char *instance_name;
};

typedef enum { INSTANTIATED, INITIALIZING, STEPPING, EVENTS, FAILED, TERMINATED } Mode;

/* Whether the outputs match the state, the inputs and the parameters of this instant. */
typedef enum {
    OUTPUTS_STALE, /* to be evaluated when somebody reads them */
    OUTPUTS_FRESH,
    OUTPUTS_HELD /* those of the last sample, whatever is set meanwhile */
} Outputs;

/* When a sampled model acts, if event mode is in use: at the ticks of its clock. The first tick is at the start; an
 * importer that steps without it uses event mode but not the clock, and gets a sample with every step, as without
 * event mode, until the clock ticks after all. */
typedef enum { TICK_EXPECTED, TICK_MISSED, TICKED } Ticks;

/* All that makes up the state of an instance, in one piece, so that a copy of it is the FMU state. */
typedef struct {
    int32_t mode;
    int32_t outputs;
    int32_t events; /* whether event mode is in use; decided with the instance */
    int32_t ticks;
    double interval; /* [s] from one tick of the clock to the next */
    double tick;     /* time of the last tick */
    double values[]; /* time | p | u | y | clock | x, as in model.h, and then the next x */
} State;

typedef struct {
    Host host;
    State *state;
    double *time, *p, *u, *y, *clock, *x; /* where they stand in state->values */
    double *x_next; /* there too: a sample read in event mode goes with the state that it leads to */

    /* scratch: what CasADi's functions work on */
    double *doubles;
    Integer *integers;
    const double **arguments;
    double **results;
} Instance;

/* --- instance.c: the life of an instance, and what it says --- */

enum { MESSAGE_SIZE = 512, NAME_SIZE = 128 }; /* longer texts are cut off */

/* Number of doubles in state->values. */
size_t core_n_values(void);

/* A new instance, or NULL when `token` is not the model's. */
Instance *core_instantiate(const Host *host, const char *call, const char *token);
void core_free(Instance *self);

/* The start values again, as after instantiation. */
Status core_reset(Instance *self);

/* Logs a message (printf style) and returns STATUS_ERROR. */
Status core_error(const Host *host, const char *call, const char *format, ...);
void core_warning(const Host *host, const char *call, const char *format, ...);

/* The answer of a function that this FMU does not support. */
Status core_unsupported(Instance *self, const char *call);

/* --- core.c: modes and steps --- */

Status core_enter_initialization(Instance *self, const char *call, double start_time);

/* Checks all parameters, and begins with the start state. */
Status core_exit_initialization(Instance *self, const char *call);

/* Advances to time + h with the inputs held. Anything that is not a finite number ends the instance in FAILED. */
Status core_step(Instance *self, const char *call, double time, double h);

/* Ends a tick of the clock, if there is one: takes the sample unless its outputs were read, and the state from it. */
Status core_finish_tick(Instance *self, const char *call);

Status core_terminate(Instance *self, const char *call);

/* Logs which mode the instance is in and what would be valid; returns STATUS_ERROR. */
Status core_wrong_mode(Instance *self, const char *call, const char *valid);

/* Whether a parameter's element lies in its range; otherwise logs its name, value and range. */
bool core_in_range(Instance *self, const char *call, const Variable *variable, const double *element);

/* Evaluates the outputs if they are stale. */
Status core_refresh_outputs(Instance *self, const char *call);

/* --- events.c: event mode and its clock (FMI 3.0) --- */

Status core_enter_events(Instance *self, const char *call);
Status core_leave_events(Instance *self, const char *call);
Status core_update_discrete_states(Instance *self, const char *call);

Status core_set_clock(Instance *self, const char *call, const Variable *clock, bool active);
Status core_set_interval(Instance *self, const char *call, const Variable *clock, double interval);

/* Whether the clock's interval and shift can be asked for in this mode. */
Status core_may_get_interval(Instance *self, const char *call);

/* --- access.c: reading and writing the variables behind value references --- */

/* What a value reference names: one element (FMI 2.0) or a whole variable (FMI 3.0). */
typedef enum { BY_ELEMENT, BY_VARIABLE } Granularity;

/* A walk over the elements of several variables of the given types. It begins with every check, so that it either
 * fails before the first element or visits all of them:
 *
 *     Access access = access_to_read(self, __func__, BY_VARIABLE, FLOAT64, references, n, n_values);
 *     while (access_next(&access)) *values++ = *access.element;
 *     return access.status;
 */
typedef struct {
    Instance *self;
    const char *call;
    Granularity granularity;
    const uint32_t *references;
    size_t n_references;

    Status status;
    const Variable *variable;
    double *element;     /* the one visited now */
    uint32_t n_remaining; /* elements of this variable still to come */
} Access;

Access access_to_read(Instance *self, const char *call, Granularity granularity, unsigned types,
                      const uint32_t *references, size_t n_references, size_t n_values);
Access access_to_write(Instance *self, const char *call, Granularity granularity, unsigned types,
                       const uint32_t *references, size_t n_references, size_t n_values);

/* Goes on to the next element; false after the last, or after an error. */
bool access_next(Access *access);

/* Writes the element visited now; refuses a tunable parameter out of its range while stepping. */
void access_write(Access *access, double value);

/* A value as a whole number, rounded and kept within 32 bits; 0 when it is not a number. */
int32_t access_int32(double value);

/* --- snapshot.c: the FMU state as one block of bytes, which is also its serialized form --- */

/* Copies the state to `*snapshot`, which is allocated when it is NULL. */
Status snapshot_take(Instance *self, const char *call, void **snapshot);
Status snapshot_restore(Instance *self, const char *call, const void *snapshot);
void snapshot_free(void **snapshot);

size_t snapshot_size(void);
Status snapshot_serialize(Instance *self, const char *call, const void *snapshot, void *bytes, size_t size);
Status snapshot_deserialize(Instance *self, const char *call, const void *bytes, size_t size, void **snapshot);

#ifdef __GNUC__
#pragma GCC visibility pop
#endif

#endif
