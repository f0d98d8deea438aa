#include "core.h"

#include <math.h>

/* Whether the importer uses event mode; otherwise says why it cannot now. */
static bool events_in_use(Instance *self, const char *call) {
    if (!model.sampled) {
        core_unsupported(self, call);
    } else if (!self->state->events) {
        core_error(&self->host, call, "found event mode not in use; valid: with eventModeUsed at instantiation");
    }
    return self->state->events;
}

static bool in_event_mode(Instance *self, const char *call) {
    if (!events_in_use(self, call)) return false;
    if (self->state->mode != EVENTS) core_wrong_mode(self, call, "in event mode");
    return self->state->mode == EVENTS;
}

Status core_enter_events(Instance *self, const char *call) {
    if (!events_in_use(self, call)) return STATUS_ERROR;
    if (self->state->mode != STEPPING) return core_wrong_mode(self, call, "in step mode, after initialization");
    self->state->mode = EVENTS;
    return STATUS_OK;
}

Status core_leave_events(Instance *self, const char *call) {
    if (!in_event_mode(self, call)) return STATUS_ERROR;
    if (*self->clock != 0) {
        return core_error(&self->host, call,
                          "found the clock still active; valid: after fmi3UpdateDiscreteStates, which ends its tick");
    }
    self->state->mode = STEPPING;
    return STATUS_OK;
}

Status core_update_discrete_states(Instance *self, const char *call) {
    return in_event_mode(self, call) ? core_finish_tick(self, call) : STATUS_ERROR;
}

/* FMI 3.0.2, Clock Types: the interval of a periodic clock, "from the previous Clock tick to the current Clock tick",
 * is above 0, so there is one tick at a time. And it ends with fmi3UpdateDiscreteStates, not before: the attribute
 * canBeDeactivated is not set. */
Status core_set_clock(Instance *self, const char *call, const Variable *clock, bool active) {
    State *state = self->state;
    if (!in_event_mode(self, call)) return STATUS_ERROR;
    if (active == (*self->clock != 0)) return STATUS_OK;
    if (!active) {
        return core_error(&self->host, call,
                          "found `%s` deactivated in its tick; valid: active until fmi3UpdateDiscreteStates",
                          clock->name);
    }
    if (state->ticks == TICKED && state->tick == *self->time) {
        return core_error(&self->host, call, "found a second tick of `%s` at time %.9g; valid: one", clock->name,
                          *self->time);
    }
    *self->clock = 1;
    state->tick = *self->time;
    state->ticks = TICKED;
    if (state->outputs == OUTPUTS_HELD) state->outputs = OUTPUTS_STALE;
    return STATUS_OK;
}

Status core_set_interval(Instance *self, const char *call, const Variable *clock, double interval) {
    if (self->state->mode != INITIALIZING) {
        return core_wrong_mode(self, call, "in initialization mode, as the interval is fixed");
    }
    if (!(interval > 0) || !isfinite(interval)) {
        return core_error(&self->host, call, "found the interval %g of `%s`; valid: a finite number above 0",
                          isnan(interval) ? fabs(NAN) : interval, clock->name);
    }
    self->state->interval = interval;
    return STATUS_OK;
}

Status core_may_get_interval(Instance *self, const char *call) {
    int32_t mode = self->state->mode;
    if (mode == INITIALIZING || mode == EVENTS) return STATUS_OK;
    return core_wrong_mode(self, call, "in initialization mode or event mode");
}
