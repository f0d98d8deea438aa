#include "core.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* --- messages --- */

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

void core_warning(const Host *host, const char *call, const char *format, ...) {
    va_list values;
    va_start(values, format);
    report(host, STATUS_WARNING, call, format, values);
    va_end(values);
}

Status core_unsupported(Instance *self, const char *call) {
    return core_error(&self->host, call, "not supported by this FMU");
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

size_t core_n_values(void) {
    return 1 + model.n_p + model.n_u + model.n_y + model.sampled + 2 * model.n_x;
}

/* Finds each column its place in the block; every part is a multiple of 8 bytes long, so each begins where it may.
 * Returns the end of the last. */
static char *lay_out(Instance *self, Work work) {
    self->state = (State *)(self + 1);
    self->time = self->state->values;
    self->p = self->time + 1;
    self->u = self->p + model.n_p;
    self->y = self->u + model.n_u;
    self->clock = self->y + model.n_y;
    self->x = self->clock + model.sampled;
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
    size_t n_doubles = core_n_values() + work.doubles;
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
    self->state->ticks = TICK_EXPECTED;
    self->state->interval = model.interval;
    self->state->tick = 0;
    memset(self->state->values, 0, core_n_values() * sizeof(double));
    memcpy(self->p, model.start, (model.n_p + model.n_u) * sizeof(double));
    return STATUS_OK;
}
