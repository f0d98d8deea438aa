/* Event mode of FMI 3.0 and its clock, translated to the core.
 *
 * The clock is a fixed periodic one, so that the importer can set its interval to its own step. FMI 3.0.2, 2.2.9.2
 * Clock Types, Fixed periodic Clock: "is a time-based periodic Clock which ticks with an arbitrary, but fixed interval
 * [...] If intervalDecimal is specified, the importer sets the Clock's fixed interval using fmi3SetInterval in
 * InitializationMode. If the function is not called the value given in intervalDecimal [...] is used."
 * It has no shift: the first tick is at the start time. supportsFraction is not set.
 */
#include "core.h"
#include "fmi3Functions.h"

fmi3Status fmi3EnterEventMode(fmi3Instance instance) {
    return (fmi3Status)core_enter_events(instance, __func__);
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    return (fmi3Status)core_leave_events(instance, __func__);
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation, fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged, fmi3Boolean *nextEventTimeDefined,
                                    fmi3Float64 *nextEventTime) {
    *discreteStatesNeedUpdate = *terminateSimulation = *nextEventTimeDefined = fmi3False;
    *nominalsOfContinuousStatesChanged = *valuesOfContinuousStatesChanged = fmi3False;
    *nextEventTime = 0;
    return (fmi3Status)core_update_discrete_states(instance, __func__);
}

/* --- the clock: the functions take lists, of which each entry is the one clock there is --- */

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Clock values[]) {
    Access access = access_to_read(instance, __func__, BY_VARIABLE, CLOCK, valueReferences, nValueReferences,
                                   nValueReferences);
    while (access_next(&access)) *values++ = *access.element != 0 ? fmi3ClockActive : fmi3ClockInactive;
    return (fmi3Status)access.status;
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Clock values[]) {
    Access access = access_to_write(instance, __func__, BY_VARIABLE, CLOCK, valueReferences, nValueReferences,
                                    nValueReferences);
    while (access_next(&access)) {
        access.status = core_set_clock(instance, __func__, access.variable, *values++ == fmi3ClockActive);
    }
    return (fmi3Status)access.status;
}

/* FMI 3.0.2, 2.2.9.4: for fixed clocks with intervalDecimal "fmi3IntervalUnchanged is the only qualifier that can be
 * returned, since the interval is set by the importer and cannot be changed by the FMU". */
fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[]) {
    Instance *self = instance;
    Access access = access_to_read(self, __func__, BY_VARIABLE, CLOCK, valueReferences, nValueReferences,
                                   nValueReferences);
    while (access_next(&access)) {
        access.status = core_may_get_interval(self, __func__);
        *intervals++ = self->state->interval;
        *qualifiers++ = fmi3IntervalUnchanged;
    }
    return (fmi3Status)access.status;
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, const fmi3Float64 intervals[]) {
    Access access = access_to_write(instance, __func__, BY_VARIABLE, CLOCK, valueReferences, nValueReferences,
                                    nValueReferences);
    while (access_next(&access)) {
        access.status = core_set_interval(instance, __func__, access.variable, *intervals++);
    }
    return (fmi3Status)access.status;
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, fmi3Float64 shifts[]) {
    Access access = access_to_read(instance, __func__, BY_VARIABLE, CLOCK, valueReferences, nValueReferences,
                                   nValueReferences);
    while (access_next(&access)) {
        access.status = core_may_get_interval(instance, __func__);
        *shifts++ = 0;
    }
    return (fmi3Status)access.status;
}
