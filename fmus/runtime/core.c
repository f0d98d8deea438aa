#include "core.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { LARGEST_NUMBER_OF_PARTS = 1000000000 };

static const char *const mode_names[] = {"instantiated", "in initialization mode", "in step mode", "in event mode",
                                         "in error (reset it, or restore an earlier state)", "terminated"};

Status core_wrong_mode(Instance *self, const char *call, const char *valid) {
    return core_error(&self->host, call, "the instance is %s; valid: %s", mode_names[self->state->mode], valid);
}

/* --- the model's functions: CasADi may overwrite its lists of columns, so they are written anew for each call --- */

static bool call_model(Instance *self, Function function) {
    return function.evaluate(self->arguments, self->results, self->integers, self->doubles, 0) == 0;
}

static bool evaluate_initial(Instance *self) {
    self->arguments[0] = self->p;
    self->results[0] = self->x;
    return call_model(self, model.initial);
}

/* The next state and, when the model is sampled, the outputs of the sample. */
static bool evaluate_step(Instance *self, double h) {
    self->arguments[0] = self->x;
    self->arguments[1] = self->u;
    self->arguments[2] = self->p;
    self->arguments[3] = &h;
    self->results[0] = self->x_next; /* CasADi must not write where it reads */
    self->results[1] = self->y;      /* ignored unless the model is sampled */
    return call_model(self, model.step);
}

static void take_next_state(Instance *self) {
    memcpy(self->x, self->x_next, model.n_x * sizeof(double));
}

static bool evaluate_output(Instance *self) {
    if (model.sampled) return evaluate_step(self, 0); /* a sample does not depend on the step */
    self->arguments[0] = self->x;
    self->arguments[1] = self->u;
    self->arguments[2] = self->p;
    self->results[0] = self->y;
    return call_model(self, model.output);
}

/* --- finite values, valid ranges --- */

static void element_name(char *name, size_t size, const Variable *variable, size_t element) {
    if (variable->size == 1) {
        snprintf(name, size, "%s", variable->name);
    } else {
        snprintf(name, size, "%s[%lu]", variable->name, (unsigned long)element + 1);
    }
}

/* A value for messages; the sign of a NaN means nothing. */
static double shown(double value) {
    return isnan(value) ? fabs(NAN) : value;
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
    core_error(&self->host, call, "parameter `%s` is %.9g; valid: %sfinite number%s", name, shown(*element), low, high);
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
    if (wrong) {
        core_warning(&self->host, call, "at time %.9g `%s` is %g, not a finite number", *self->time, name,
                     shown(*wrong));
    }
    return STATUS_OK;
}

/* --- modes and steps --- */

Status core_enter_initialization(Instance *self, const char *call, double start_time) {
    if (self->state->mode != INSTANTIATED) return core_wrong_mode(self, call, "once, after instantiation or reset");
    if (!isfinite(start_time)) {
        return core_error(&self->host, call, "found the start time %g; valid: a finite number", start_time);
    }
    *self->time = start_time;
    self->state->mode = INITIALIZING;
    return STATUS_OK;
}

Status core_exit_initialization(Instance *self, const char *call) {
    char name[NAME_SIZE];
    if (self->state->mode != INITIALIZING) return core_wrong_mode(self, call, "in initialization mode");

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
    if (wrong) return core_error(&self->host, call, "start state `%s` is %g, not a finite number", name, shown(*wrong));
    self->state->outputs = OUTPUTS_STALE;
    self->state->mode = self->state->events ? EVENTS : STEPPING;
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
        bool done = evaluate_step(self, h);
        take_next_state(self);
        return done;
    }
    double n = number_of_parts(h);
    for (double part = 0; part < n; ++part) {
        bool done = evaluate_step(self, h / n);
        take_next_state(self);
        if (!done) return false;
    }
    self->state->outputs = OUTPUTS_FRESH;
    return evaluate_output(self);
}

static Status check_step(Instance *self, const char *call, double time, double h) {
    if (self->state->mode != STEPPING) return core_wrong_mode(self, call, "in step mode, after initialization");
    if (!(h > 0) || !isfinite(h)) {
        return core_error(&self->host, call, "found the communication step size %g; valid: a finite number above 0", h);
    }
    if (number_of_parts(h) > LARGEST_NUMBER_OF_PARTS) {
        return core_error(&self->host, call, "found the communication step size %g; valid: at most %g", h,
                          LARGEST_NUMBER_OF_PARTS * model.max_step);
    }
    if (!(fabs(time - *self->time) <= 1e-6 * fmax(h, fabs(time)))) { /* masters that add up steps drift a little */
        return core_error(&self->host, call,
                          "found the communication point %.9g; valid: %.9g, where the last step ended",
                          time, *self->time);
    }
    return STATUS_OK;
}

/* Whether all states and outputs are finite; otherwise says which is not, and which input may have caused it. */
static bool all_finite(Instance *self, const char *call) {
    char name[NAME_SIZE], input[NAME_SIZE];
    const double *wrong = not_finite(self, OUTPUT, STATE, name, sizeof name);
    if (!wrong) return true;
    const double *cause = not_finite(self, INPUT, INPUT, input, sizeof input);
    if (cause) {
        core_error(&self->host, call, "at time %.9g `%s` is %g, not a finite number; so is input `%s`: %g",
                   *self->time, name, shown(*wrong), input, shown(*cause));
    } else {
        core_error(&self->host, call, "at time %.9g `%s` is %g, not a finite number", *self->time, name,
                   shown(*wrong));
    }
    return false;
}

/*
 * A master that takes the step as the difference of two times gives another last digit in every step, and an optimiser
 * in a closed loop enlarges it (libcosim: 1e-17 s became 3e-5 N.m in 20 steps). Within a picosecond of a whole number
 * of nanoseconds, that number is meant.
 */
static double without_rounding(double h) {
    double nanoseconds = round(h * 1e9);
    return nanoseconds > 0 && fabs(h * 1e9 - nanoseconds) < 1e-3 ? nanoseconds / 1e9 : h;
}

/* Whether the model acts at the ticks of its clock, so that a step only lets time pass. */
static bool acts_at_ticks(Instance *self, const char *call) {
    State *state = self->state;
    if (state->events && state->ticks == TICK_EXPECTED) {
        core_warning(&self->host, call,
                     "found event mode in use and no tick of the clock at time %.9g; valid: one at the start; "
                     "the model acts with every step instead", *self->time);
        state->ticks = TICK_MISSED;
    }
    return state->events && state->ticks == TICKED;
}

Status core_step(Instance *self, const char *call, double time, double h) {
    Status status = check_step(self, call, time, h);
    if (status != STATUS_OK) return status;
    if (acts_at_ticks(self, call)) {
        *self->time = time + h;
        return STATUS_OK;
    }

    bool done = advance(self, without_rounding(h));
    *self->time = time + h;
    if (!done) core_error(&self->host, call, "the step to time %.9g could not be computed", *self->time);
    if (done && all_finite(self, call)) return STATUS_OK;
    self->state->mode = FAILED;
    return STATUS_ERROR;
}

Status core_finish_tick(Instance *self, const char *call) {
    if (*self->clock == 0) return STATUS_OK;
    bool done = self->state->outputs == OUTPUTS_FRESH || evaluate_step(self, 0);
    take_next_state(self);
    self->state->outputs = OUTPUTS_HELD;
    *self->clock = 0;
    if (!done) core_error(&self->host, call, "the sample at time %.9g could not be computed", *self->time);
    if (done && all_finite(self, call)) return STATUS_OK;
    self->state->mode = FAILED;
    return STATUS_ERROR;
}

Status core_terminate(Instance *self, const char *call) {
    int32_t mode = self->state->mode;
    if (mode != STEPPING && mode != EVENTS && mode != FAILED) {
        return core_wrong_mode(self, call, "in step mode, after initialization");
    }
    self->state->mode = TERMINATED;
    return STATUS_OK;
}
