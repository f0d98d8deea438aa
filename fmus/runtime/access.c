#include "core.h"

#include <math.h>

static const char *type_name(Type type) {
    switch (type) {
        case FLOAT64: return "Float64";
        case INT32: return "Int32";
        case BOOLEAN: return "Boolean";
        case ENUMERATION: return "Enumeration";
        case CLOCK: return "Clock";
    }
    return "of no type";
}

/* The variable a reference names, or NULL after a logged error. */
static const Variable *find(Instance *self, const char *call, Granularity granularity, uint32_t reference) {
    if (reference < 1 + model.n_p + model.n_u + model.n_y + model.sampled) {
        const Variable *variable = &model.variables[model.variable_of[reference]];
        bool in_fmi2 = variable->role != TIME && variable->role != INPUT_CLOCK;
        bool named = granularity == BY_VARIABLE ? reference == variable->reference : in_fmi2;
        if (named) return variable;
    }
    core_error(&self->host, call, "found the value reference %lu; valid: those in the modelDescription.xml",
               (unsigned long)reference);
    return NULL;
}

static bool right_type(Instance *self, const char *call, const Variable *variable, unsigned types) {
    if (variable->type & types) return true;
    core_error(&self->host, call, "found `%s` of type %s; valid: variables of the type this function is for",
               variable->name, type_name(variable->type));
    return false;
}

static bool readable(Instance *self, const char *call, const Variable *variable) {
    if (self->state->mode == INSTANTIATED) {
        core_error(&self->host, call, "found `%s` before initialization mode; valid: from initialization mode on",
                   variable->name);
        return false;
    }
    return variable->role != OUTPUT || core_refresh_outputs(self, call) == STATUS_OK;
}

static bool writable(Instance *self, const char *call, const Variable *variable) {
    int32_t mode = self->state->mode;
    if (variable->role == OUTPUT || variable->role == TIME) {
        core_error(&self->host, call, "found `%s`, which is not to be set; valid: parameters and inputs",
                   variable->name);
        return false;
    }
    if (mode == FAILED || mode == TERMINATED) {
        core_error(&self->host, call, "found `%s` after the end of the simulation; valid: before, or after a reset",
                   variable->name);
        return false;
    }
    if ((mode == STEPPING || mode == EVENTS) && variable->role == FIXED_PARAMETER) {
        core_error(&self->host, call,
                   "found fixed parameter `%s` after initialization; valid: inputs and tunable parameters",
                   variable->name);
        return false;
    }
    return true;
}

typedef bool Permission(Instance *self, const char *call, const Variable *variable);

static Access begin(Access access, unsigned types, size_t n_values, Permission *permitted) {
    size_t n_elements = 0;
    access.status = STATUS_ERROR;
    for (size_t i = 0; i < access.n_references; ++i) {
        const Variable *variable = find(access.self, access.call, access.granularity, access.references[i]);
        if (!variable || !right_type(access.self, access.call, variable, types)) return access;
        if (!permitted(access.self, access.call, variable)) return access;
        n_elements += access.granularity == BY_VARIABLE ? variable->size : 1;
    }
    if (n_elements != n_values) {
        core_error(&access.self->host, access.call, "found %lu values; valid: %lu, one for each element",
                   (unsigned long)n_values, (unsigned long)n_elements);
        return access;
    }
    access.status = STATUS_OK;
    return access;
}

Access access_to_read(Instance *self, const char *call, Granularity granularity, unsigned types,
                      const uint32_t *references, size_t n_references, size_t n_values) {
    Access access = {self, call, granularity, references, n_references, STATUS_OK, NULL, NULL, 0};
    return begin(access, types, n_values, readable);
}

Access access_to_write(Instance *self, const char *call, Granularity granularity, unsigned types,
                       const uint32_t *references, size_t n_references, size_t n_values) {
    Access access = {self, call, granularity, references, n_references, STATUS_OK, NULL, NULL, 0};
    return begin(access, types, n_values, writable);
}

bool access_next(Access *access) {
    if (access->status != STATUS_OK) return false;
    if (access->n_remaining > 0) {
        --access->n_remaining;
        ++access->element;
        return true;
    }
    if (access->n_references == 0) return false;
    uint32_t reference = *access->references++;
    --access->n_references;
    access->variable = &model.variables[model.variable_of[reference]];
    access->element = access->self->state->values + reference;
    access->n_remaining = access->granularity == BY_VARIABLE ? access->variable->size - 1 : 0;
    return true;
}

void access_write(Access *access, double value) {
    State *state = access->self->state;
    double before = *access->element;
    *access->element = value;
    if (state->mode != INSTANTIATED && state->mode != INITIALIZING && access->variable->role == TUNABLE_PARAMETER
        && !core_in_range(access->self, access->call, access->variable, access->element)) {
        *access->element = before;
        access->status = STATUS_ERROR;
        return;
    }
    if (state->outputs == OUTPUTS_FRESH) state->outputs = OUTPUTS_STALE;
}

int32_t access_int32(double value) {
    if (isnan(value)) return 0;
    return (int32_t)fmax(INT32_MIN, fmin(INT32_MAX, nearbyint(value)));
}
