#include "core.h"

#include <stdlib.h>
#include <string.h>

/* A snapshot is this heading and, after it, the bytes of State. The heading says whose state it is. */
typedef struct {
    char token[40];
    uint64_t size; /* of the whole snapshot */
} Heading;

static size_t state_size(void) {
    return sizeof(State) + core_n_values() * sizeof(double);
}

size_t snapshot_size(void) {
    return sizeof(Heading) + state_size();
}

static bool is_ours(const Heading *heading) {
    return strncmp(heading->token, model.token, sizeof heading->token) == 0 && heading->size == snapshot_size();
}

static bool allocated(Instance *self, const char *call, void **snapshot) {
    if (!*snapshot) *snapshot = calloc(1, snapshot_size());
    if (!*snapshot) core_error(&self->host, call, "no memory for %lu bytes", (unsigned long)snapshot_size());
    return *snapshot != NULL;
}

Status snapshot_take(Instance *self, const char *call, void **snapshot) {
    if (!allocated(self, call, snapshot)) return STATUS_ERROR;
    Heading *heading = *snapshot;
    strncpy(heading->token, model.token, sizeof heading->token - 1);
    heading->size = snapshot_size();
    memcpy(heading + 1, self->state, state_size());
    return STATUS_OK;
}

Status snapshot_restore(Instance *self, const char *call, const void *snapshot) {
    const Heading *heading = snapshot;
    if (!heading || !is_ours(heading)) {
        return core_error(&self->host, call, "found no state of this model; valid: a state taken from this FMU");
    }
    const State *state = (const State *)(heading + 1);
    if (state->events != self->state->events) {
        const char *with[] = {"without", "with"};
        return core_error(&self->host, call, "found a state of an instance %s event mode; valid: %s, as this instance",
                          with[state->events != 0], with[self->state->events != 0]);
    }
    memcpy(self->state, state, state_size());
    return STATUS_OK;
}

void snapshot_free(void **snapshot) {
    free(*snapshot);
    *snapshot = NULL;
}

Status snapshot_serialize(Instance *self, const char *call, const void *snapshot, void *bytes, size_t size) {
    if (!snapshot || size < snapshot_size()) {
        return core_error(&self->host, call, "found room for %lu bytes; valid: a state and %lu bytes",
                          (unsigned long)size, (unsigned long)snapshot_size());
    }
    memcpy(bytes, snapshot, snapshot_size());
    return STATUS_OK;
}

Status snapshot_deserialize(Instance *self, const char *call, const void *bytes, size_t size, void **snapshot) {
    Heading heading = {{0}, 0};
    if (size >= sizeof heading) memcpy(&heading, bytes, sizeof heading);
    if (size != snapshot_size() || !is_ours(&heading)) {
        return core_error(&self->host, call, "found a state of another model (%.39s, %lu bytes); valid: %s, %lu bytes",
                          heading.token, (unsigned long)size, model.token, (unsigned long)snapshot_size());
    }
    if (!allocated(self, call, snapshot)) return STATUS_ERROR;
    memcpy(*snapshot, bytes, size);
    return STATUS_OK;
}
