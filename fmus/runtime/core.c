#include "core.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MESSAGE_SIZE = 512, NAME_SIZE = 128, LARGEST_NUMBER_OF_PARTS = 1000000000 };

static const char *const mode_names[] = {"instantiated", "in initialization mode", "in step mode",
                                         "failed; reset it, or restore an earlier state", "terminated"};

static void report(const Host *host, Status status, const char *call, const char *format, va_list values) {
    char message[MESSAGE_SIZE];
    int n = snprintf(message, sizeof message, "%s: ", call);
    if (n >= 0 && (size_t)n < sizeof message) {
        vsnprintf(message + n, sizeof message - (size_t)n, format, values);
    }
    host->log(host, status, message);
}

Status core_error(const Host *host, const char *call, const char *format, ...) {
    va_list values;
    va_start(values, format);
    report(host, STATUS_ERROR, call, format, values);
    va_end(values);
    return STATUS_ERROR;
}

static void warn(const Host *host, const char *call, const char *format, ...) {
    va_list values;
    va_start(values, format);
    report(host, STATUS_WARNING, call, format, values);
    va_end(values);
}

Status core_unsupported(Instance *self, const char *call) {
    return core_error(&self->host, call, "not supported by this FMU");
}

static Status wrong_mode(Instance *self, const char *call, const char *valid) {
    return core_error(&self->host, call, "the instance is %s; valid: %s", mode_names[self->state->mode], valid);
}

/* --- life of an instance --- */

/* The work arrays for any function of the model. */
typedef struct {
    size_t arguments, results, integers, doubles;
} Work;

enum { MOST_ARGUMENTS = 4, MOST_RESULTS = 2 }; /* of a function of the model, see model.h */

static void grow(size_t *size, Integer wanted) {
    if ((size_t)wanted > *size) *size = (size_t)wanted;
}

static Work work_for_all(void) {
    const Function functions[] = {model.initial, model.output, model.step};
    Work work = {MOST_ARGUMENTS, MOST_RESULTS, 0, 0};
    for (size_t i = 0; i < sizeof functions / sizeof *functions; ++i) {
        Integer arguments = 0, results = 0, integers = 0, doubles = 0;
        if (!functions[i].work_sizes) continue;
        functions[i].work_sizes(&arguments, &results, &integers, &doubles);
        grow(&work.arguments, arguments);
        grow(&work.results, results);
        grow(&work.integers, integers);
        grow(&work.doubles, doubles);
    }
    return work;
}

/* Finds each column its place in the block; every part is a multiple of 8 bytes long, so each begins where it may.
 * Returns the end of the last. */
static char *lay_out(Instance *self, Work work) {
    self->state = (State *)(self + 1);
    self->time = self->state->values;
    self->p = self->time + 1;
    self->u = self->p + model.n_p;
    self->y = self->u + model.n_u;
    self->x = self->y + model.n_y;
    self->x_next = self->x + model.n_x;
    self->doubles = self->x_next + model.n_x;
    self->integers = (Integer *)(self->doubles + work.doubles);
    self->arguments = (const double **)(self->integers + work.integers);
    self->results = (double **)(self->arguments + work.arguments);
    return (char *)(self->results + work.results);
}

Instance *core_instantiate(const Host *host, const char *call, const char *token) {
    if (!token || strcmp(token, model.token) != 0) {
        core_error(host, call, "found the token \"%s\"; valid: \"%s\", as in the modelDescription.xml of this binary",
                   token ? token : "", model.token);
        return NULL;
    }
    const char *name = host->instance_name ? host->instance_name : model.name;
    Work work = work_for_all();
    size_t n_doubles = 1 + model.n_p + model.n_u + model.n_y + 2 * model.n_x + work.doubles;
    size_t size = sizeof(Instance) + sizeof(State) + n_doubles * sizeof(double) + work.integers * sizeof(Integer)
        + (work.arguments + work.results) * sizeof(double *) + strlen(name) + 1;
    Instance *self = calloc(1, size);
    if (!self) {
        core_error(host, call, "no memory for %lu bytes", (unsigned long)size);
        return NULL;
    }
    self->host = *host;
    self->host.instance_name = strcpy(lay_out(self, work), name);
    core_reset(self);
    return self;
}

void core_free(Instance *self) {
    free(self);
}

Status core_reset(Instance *self) {
    self->state->mode = INSTANTIATED;
    self->state->outputs = OUTPUTS_STALE;
    *self->time = 0;
    memcpy(self->p, model.start, (model.n_p + model.n_u) * sizeof(double));
    memset(self->y, 0, (model.n_y + model.n_x) * sizeof(double));
    return STATUS_OK;
}

/* --- the model's functions --- */

/* Calls a function on columns of the instance; CasADi ignores those beyond its own number of them. */
static bool evaluate(Instance *self, Function function, const double *const arguments[MOST_ARGUMENTS],
                     double *const results[MOST_RESULTS]) {
    for (size_t i = 0; i < MOST_ARGUMENTS; ++i) self->arguments[i] = arguments[i];
    for (size_t i = 0; i < MOST_RESULTS; ++i) self->results[i] = results[i];
    return function.evaluate(self->arguments, self->results, self->integers, self->doubles, 0) == 0;
}

static bool evaluate_initial(Instance *self) {
    return evaluate(self, model.initial, (const double *[MOST_ARGUMENTS]){self->p}, (double *[MOST_RESULTS]){self->x});
}

static bool evaluate_output(Instance *self) {
    const double no_step = 0; /* a sample does not depend on the step */
    if (model.sampled) {
        return evaluate(self, model.step, (const double *[MOST_ARGUMENTS]){self->x, self->u, self->p, &no_step},
                        (double *[MOST_RESULTS]){NULL, self->y});
    }
    return evaluate(self, model.output, (const double *[MOST_ARGUMENTS]){self->x, self->u, self->p}, (double *[MOST_RESULTS]){self->y});
}

static bool evaluate_step(Instance *self, double h) {
    bool done = evaluate(self, model.step, (const double *[MOST_ARGUMENTS]){self->x, self->u, self->p, &h},
                         (double *[MOST_RESULTS]){self->x_next, self->y});
    memcpy(self->x, self->x_next, model.n_x * sizeof(double)); /* CasADi must not read where it writes */
    return done;
}

/* --- finite values, valid ranges --- */

static void element_name(char *name, size_t size, const Variable *variable, size_t element) {
    if (variable->size == 1) {
        snprintf(name, size, "%s", variable->name);
    } else {
        snprintf(name, size, "%s[%lu]", variable->name, (unsigned long)element + 1);
    }
}

/* The first element with one of the roles that is not a finite number; its name goes to `name`. */
static const double *not_finite(const Instance *self, Role first, Role last, char *name, size_t size) {
    for (size_t i = 0; i < model.n_variables; ++i) {
        const Variable *variable = &model.variables[i];
        const double *values = self->state->values + variable->reference;
        for (size_t k = 0; first <= variable->role && variable->role <= last && k < variable->size; ++k) {
            if (!isfinite(values[k])) {
                element_name(name, size, variable, k);
                return &values[k];
            }
        }
    }
    return NULL;
}

bool core_in_range(Instance *self, const char *call, const Variable *variable, const double *element) {
    char name[NAME_SIZE], low[40] = "", high[40] = "";
    if (isfinite(*element) && variable->min <= *element && *element <= variable->max) return true;

    element_name(name, sizeof name, variable, (size_t)(element - self->state->values) - variable->reference);
    if (isfinite(variable->min)) snprintf(low, sizeof low, "%.9g <= ", variable->min);
    if (isfinite(variable->max)) snprintf(high, sizeof high, " <= %.9g", variable->max);
    core_error(&self->host, call, "parameter `%s` is %.9g; valid: %sfinite number%s", name, *element, low, high);
    return false;
}

Status core_refresh_outputs(Instance *self, const char *call) {
    char name[NAME_SIZE];
    if (self->state->outputs != OUTPUTS_STALE) return STATUS_OK;

    bool done = self->state->mode != INITIALIZING || evaluate_initial(self);
    if (!done || !evaluate_output(self)) {
        return core_error(&self->host, call, "the outputs at time %.9g could not be computed", *self->time);
    }
    self->state->outputs = OUTPUTS_FRESH;
    const double *wrong = not_finite(self, OUTPUT, OUTPUT, name, sizeof name);
    if (wrong) warn(&self->host, call, "at time %.9g output `%s` is %g, not a finite number", *self->time, name, *wrong);
    return STATUS_OK;
}

/* --- modes and steps --- */

Status core_enter_initialization(Instance *self, const char *call, double start_time) {
    if (self->state->mode != INSTANTIATED) return wrong_mode(self, call, "once, after instantiation or reset");
    if (!isfinite(start_time)) {
        return core_error(&self->host, call, "found the start time %g; valid: a finite number", start_time);
    }
    *self->time = start_time;
    self->state->mode = INITIALIZING;
    return STATUS_OK;
}

Status core_exit_initialization(Instance *self, const char *call) {
    char name[NAME_SIZE];
    if (self->state->mode != INITIALIZING) return wrong_mode(self, call, "in initialization mode");

    bool valid = true;
    for (size_t i = 0; i < model.n_variables; ++i) {
        const Variable *variable = &model.variables[i];
        if (variable->role != FIXED_PARAMETER && variable->role != TUNABLE_PARAMETER) continue;
        const double *values = self->state->values + variable->reference;
        for (size_t k = 0; k < variable->size; ++k) valid = core_in_range(self, call, variable, &values[k]) && valid;
    }
    if (!valid) return STATUS_ERROR;
    if (!evaluate_initial(self)) return core_error(&self->host, call, "the start state could not be computed");
    const double *wrong = not_finite(self, STATE, STATE, name, sizeof name);
    if (wrong) return core_error(&self->host, call, "start state `%s` is %g, not a finite number", name, *wrong);
    self->state->outputs = OUTPUTS_STALE;
    self->state->mode = STEPPING;
    return STATUS_OK;
}

/* Divides h evenly into parts no longer than the model's longest step; a hair's breadth more is rounding. */
static double number_of_parts(double h) {
    return fmax(1, ceil(h / model.max_step - 1e-9));
}

/* The state at the end of the step, and the outputs that go with it (sampled: those of the sample). */
static bool advance(Instance *self, double h) {
    if (model.sampled) {
        self->state->outputs = OUTPUTS_HELD;
        return evaluate_step(self, h);
    }
    double n = number_of_parts(h);
    for (double part = 0; part < n; ++part) {
        if (!evaluate_step(self, h / n)) return false;
    }
    self->state->outputs = OUTPUTS_FRESH;
    return evaluate_output(self);
}

static Status check_step(Instance *self, const char *call, double time, double h) {
    if (self->state->mode != STEPPING) return wrong_mode(self, call, "in step mode, after initialization");
    if (!(h > 0) || !isfinite(h)) {
        return core_error(&self->host, call, "found the communication step size %g; valid: a finite number above 0", h);
    }
    if (number_of_parts(h) > LARGEST_NUMBER_OF_PARTS) {
        return core_error(&self->host, call, "found the communication step size %g; valid: at most %g", h,
                          LARGEST_NUMBER_OF_PARTS * model.max_step);
    }
    if (!(fabs(time - *self->time) <= 1e-6 * fmax(h, fabs(time)))) { /* masters that add up steps drift a little */
        return core_error(&self->host, call, "found the communication point %.9g; valid: %.9g, where the last step ended",
                          time, *self->time);
    }
    return STATUS_OK;
}

Status core_step(Instance *self, const char *call, double time, double h) {
    char name[NAME_SIZE], input[NAME_SIZE];
    Status status = check_step(self, call, time, h);
    if (status != STATUS_OK) return status;

    bool done = advance(self, h);
    *self->time = time + h;
    if (!done) {
        self->state->mode = FAILED;
        return core_error(&self->host, call, "the step to time %.9g could not be computed", *self->time);
    }
    const double *wrong = not_finite(self, OUTPUT, STATE, name, sizeof name);
    if (!wrong) return STATUS_OK;
    self->state->mode = FAILED;
    const double *cause = not_finite(self, INPUT, INPUT, input, sizeof input);
    if (!cause) {
        return core_error(&self->host, call, "at time %.9g `%s` is %g, not a finite number", *self->time, name, *wrong);
    }
    return core_error(&self->host, call, "at time %.9g `%s` is %g, not a finite number; so is input `%s`: %g",
                      *self->time, name, *wrong, input, *cause);
}

Status core_terminate(Instance *self, const char *call) {
    if (self->state->mode != STEPPING && self->state->mode != FAILED) {
        return wrong_mode(self, call, "in step mode, after initialization");
    }
    self->state->mode = TERMINATED;
    return STATUS_OK;
}
