/* FMI 3.0 Co-Simulation, translated to the core. fmi3_events.c has the functions of event mode and its clock, and
 * fmi3_absent.c those that this FMU does not support. */
#include "core.h"
#include "fmi3Functions.h"

static void log_fmi3(const Host *host, Status status, const char *message) {
    fmi3LogMessageCallback logger = (fmi3LogMessageCallback)host->callback;
    if (!logger) return;
    logger(host->environment, (fmi3Status)status, status == STATUS_ERROR ? "logStatusError" : "logStatusWarning",
           message);
}

const char *fmi3GetVersion(void) {
    return fmi3Version;
}

/* Errors and warnings are all this FMU ever says; they are not debugging, and nothing turns them off. */
fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[]) {
    (void)instance, (void)loggingOn, (void)nCategories, (void)categories;
    return fmi3OK;
}

/* --- life --- */

static Host host_of(fmi3String name, fmi3InstanceEnvironment environment, fmi3LogMessageCallback logMessage) {
    Host host = {log_fmi3, (void (*)(void))logMessage, environment, name};
    return host;
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
                                         fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment,
                                         fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate) {
    (void)resourcePath, (void)visible, (void)loggingOn, (void)earlyReturnAllowed;
    (void)requiredIntermediateVariables, (void)intermediateUpdate;
    Host host = host_of(instanceName, instanceEnvironment, logMessage);
    if (eventModeUsed && !model.sampled) {
        core_error(&host, __func__, "found event mode in use; valid: without, as the modelDescription.xml says");
        return NULL;
    }
    if (nRequiredIntermediateVariables > 0) {
        core_error(&host, __func__,
                   "found required intermediate variables; valid: none, there is no intermediate update");
        return NULL;
    }
    Instance *self = core_instantiate(&host, __func__, instantiationToken);
    if (self) self->state->events = eventModeUsed;
    return self;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage) {
    (void)instantiationToken, (void)resourcePath, (void)visible, (void)loggingOn;
    Host host = host_of(instanceName, instanceEnvironment, logMessage);
    core_error(&host, __func__, "found Model Exchange; valid: Co-Simulation");
    return NULL;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken,
                                               fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                               fmi3InstanceEnvironment instanceEnvironment,
                                               fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
                                               fmi3LockPreemptionCallback lockPreemption,
                                               fmi3UnlockPreemptionCallback unlockPreemption) {
    (void)instantiationToken, (void)resourcePath, (void)visible, (void)loggingOn;
    (void)clockUpdate, (void)lockPreemption, (void)unlockPreemption;
    Host host = host_of(instanceName, instanceEnvironment, logMessage);
    core_error(&host, __func__, "found Scheduled Execution; valid: Co-Simulation");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance) {
    core_free(instance);
}

/* Tolerance and stop time mean nothing to a fixed-step model. */
fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 startTime, fmi3Boolean stopTimeDefined, fmi3Float64 stopTime) {
    (void)toleranceDefined, (void)tolerance, (void)stopTimeDefined, (void)stopTime;
    return (fmi3Status)core_enter_initialization(instance, __func__, startTime);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    return (fmi3Status)core_exit_initialization(instance, __func__);
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
    return (fmi3Status)core_terminate(instance, __func__);
}

fmi3Status fmi3Reset(fmi3Instance instance) {
    return (fmi3Status)core_reset(instance);
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint, fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint, fmi3Boolean *eventHandlingNeeded,
                      fmi3Boolean *terminateSimulation, fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime) {
    (void)noSetFMUStatePriorToCurrentPoint;
    Instance *self = instance;
    Status status = core_step(self, __func__, currentCommunicationPoint, communicationStepSize);
    *eventHandlingNeeded = *terminateSimulation = *earlyReturn = fmi3False;
    *lastSuccessfulTime = *self->time;
    return (fmi3Status)status;
}

/* --- variables: FMI 3.0 gets and sets an enumeration by the functions for Int64 --- */

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Float64 values[], size_t nValues) {
    Access access = access_to_read(instance, __func__, BY_VARIABLE, FLOAT64, valueReferences, nValueReferences,
                                   nValues);
    while (access_next(&access)) *values++ = *access.element;
    return (fmi3Status)access.status;
}

fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Int32 values[], size_t nValues) {
    Access access = access_to_read(instance, __func__, BY_VARIABLE, INT32, valueReferences, nValueReferences,
                                   nValues);
    while (access_next(&access)) *values++ = access_int32(*access.element);
    return (fmi3Status)access.status;
}

fmi3Status fmi3GetInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        fmi3Int64 values[], size_t nValues) {
    Access access = access_to_read(instance, __func__, BY_VARIABLE, ENUMERATION, valueReferences, nValueReferences,
                                   nValues);
    while (access_next(&access)) *values++ = access_int32(*access.element);
    return (fmi3Status)access.status;
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          fmi3Boolean values[], size_t nValues) {
    Access access = access_to_read(instance, __func__, BY_VARIABLE, BOOLEAN, valueReferences, nValueReferences,
                                   nValues);
    while (access_next(&access)) *values++ = *access.element != 0;
    return (fmi3Status)access.status;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Float64 values[], size_t nValues) {
    Access access = access_to_write(instance, __func__, BY_VARIABLE, FLOAT64, valueReferences, nValueReferences,
                                    nValues);
    while (access_next(&access)) access_write(&access, *values++);
    return (fmi3Status)access.status;
}

fmi3Status fmi3SetInt32(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Int32 values[], size_t nValues) {
    Access access = access_to_write(instance, __func__, BY_VARIABLE, INT32, valueReferences, nValueReferences,
                                    nValues);
    while (access_next(&access)) access_write(&access, *values++);
    return (fmi3Status)access.status;
}

fmi3Status fmi3SetInt64(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                        const fmi3Int64 values[], size_t nValues) {
    Access access = access_to_write(instance, __func__, BY_VARIABLE, ENUMERATION, valueReferences, nValueReferences,
                                    nValues);
    while (access_next(&access)) access_write(&access, (double)*values++);
    return (fmi3Status)access.status;
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences,
                          const fmi3Boolean values[], size_t nValues) {
    Access access = access_to_write(instance, __func__, BY_VARIABLE, BOOLEAN, valueReferences, nValueReferences,
                                    nValues);
    while (access_next(&access)) access_write(&access, *values++);
    return (fmi3Status)access.status;
}

/* --- the FMU state --- */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState) {
    return (fmi3Status)snapshot_take(instance, __func__, FMUState);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState) {
    return (fmi3Status)snapshot_restore(instance, __func__, FMUState);
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState) {
    (void)instance;
    if (FMUState) snapshot_free(FMUState);
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size) {
    (void)instance, (void)FMUState;
    *size = snapshot_size();
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte serializedState[],
                                 size_t size) {
    return (fmi3Status)snapshot_serialize(instance, __func__, FMUState, serializedState, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[], size_t size,
                                   fmi3FMUState *FMUState) {
    return (fmi3Status)snapshot_deserialize(instance, __func__, serializedState, size, FMUState);
}
