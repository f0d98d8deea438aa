/* FMI 2.0 Co-Simulation, translated to the core. fmi2_absent.c has the functions that this FMU does not support. */
#include "core.h"
#include "fmi2Functions.h"

#include <string.h>

/* FMI 2.0 formats messages once more (printf style), so every % must be doubled to survive. */
static void log_fmi2(const Host *host, Status status, const char *message) {
    fmi2CallbackLogger logger = (fmi2CallbackLogger)host->callback;
    char format[1024];
    size_t n = 0;
    for (; *message && n + 2 < sizeof format; ++message) {
        if (*message == '%') format[n++] = '%';
        format[n++] = *message;
    }
    format[n] = '\0';
    if (!logger) return;
    logger(host->environment, host->instance_name ? host->instance_name : model.name, (fmi2Status)status,
           status == STATUS_ERROR ? "logStatusError" : "logStatusWarning", format);
}

const char *fmi2GetTypesPlatform(void) {
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void) {
    return fmi2Version;
}

/* Errors and warnings are all this FMU ever says; they are not debugging, and nothing turns them off. */
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[]) {
    (void)c, (void)loggingOn, (void)nCategories, (void)categories;
    return fmi2OK;
}

/* --- life --- */

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn) {
    (void)fmuResourceLocation, (void)visible, (void)loggingOn;
    Host host = {log_fmi2, NULL, NULL, instanceName};
    if (functions) {
        host.callback = (void (*)(void))functions->logger;
        host.environment = functions->componentEnvironment;
    }
    if (fmuType != fmi2CoSimulation) {
        core_error(&host, __func__, "found the type Model Exchange; valid: Co-Simulation");
        return NULL;
    }
    return core_instantiate(&host, __func__, fmuGUID);
}

void fmi2FreeInstance(fmi2Component c) {
    core_free(c);
}

/* The start time waits in `time` for initialization; tolerance and stop time mean nothing to a fixed-step model. */
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real startTime,
                               fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
    (void)toleranceDefined, (void)tolerance, (void)stopTimeDefined, (void)stopTime;
    Instance *self = c;
    if (self->state->mode != INSTANTIATED) {
        return (fmi2Status)core_error(&self->host, __func__, "found after initialization began; valid: before it");
    }
    *self->time = startTime;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    Instance *self = c;
    return (fmi2Status)core_enter_initialization(self, __func__, *self->time);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    return (fmi2Status)core_exit_initialization(c, __func__);
}

fmi2Status fmi2Terminate(fmi2Component c) {
    return (fmi2Status)core_terminate(c, __func__);
}

fmi2Status fmi2Reset(fmi2Component c) {
    return (fmi2Status)core_reset(c);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
    (void)noSetFMUStatePriorToCurrentPoint;
    return (fmi2Status)core_step(c, __func__, currentCommunicationPoint, communicationStepSize);
}

/* --- variables: FMI 2.0 treats an enumeration as an Integer --- */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[]) {
    Access access = access_to_read(c, __func__, BY_ELEMENT, FLOAT64, vr, nvr, nvr);
    while (access_next(&access)) *value++ = *access.element;
    return (fmi2Status)access.status;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Integer value[]) {
    Access access = access_to_read(c, __func__, BY_ELEMENT, INT32 | ENUMERATION, vr, nvr, nvr);
    while (access_next(&access)) *value++ = access_int32(*access.element);
    return (fmi2Status)access.status;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Boolean value[]) {
    Access access = access_to_read(c, __func__, BY_ELEMENT, BOOLEAN, vr, nvr, nvr);
    while (access_next(&access)) *value++ = *access.element != 0 ? fmi2True : fmi2False;
    return (fmi2Status)access.status;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[]) {
    Access access = access_to_write(c, __func__, BY_ELEMENT, FLOAT64, vr, nvr, nvr);
    while (access_next(&access)) access_write(&access, *value++);
    return (fmi2Status)access.status;
}

fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Integer value[]) {
    Access access = access_to_write(c, __func__, BY_ELEMENT, INT32 | ENUMERATION, vr, nvr, nvr);
    while (access_next(&access)) access_write(&access, *value++);
    return (fmi2Status)access.status;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Boolean value[]) {
    Access access = access_to_write(c, __func__, BY_ELEMENT, BOOLEAN, vr, nvr, nvr);
    while (access_next(&access)) access_write(&access, *value++ != fmi2False);
    return (fmi2Status)access.status;
}

/* No type matches, so that any reference is refused and an empty list is fine. */
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2String value[]) {
    (void)value;
    return (fmi2Status)access_to_read(c, __func__, BY_ELEMENT, 0, vr, nvr, nvr).status;
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2String value[]) {
    (void)value;
    return (fmi2Status)access_to_write(c, __func__, BY_ELEMENT, 0, vr, nvr, nvr).status;
}

/* --- the FMU state --- */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    return (fmi2Status)snapshot_take(c, __func__, FMUstate);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
    return (fmi2Status)snapshot_restore(c, __func__, FMUstate);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    (void)c;
    if (FMUstate) snapshot_free(FMUstate);
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size) {
    (void)c, (void)FMUstate;
    *size = snapshot_size();
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size) {
    return (fmi2Status)snapshot_serialize(c, __func__, FMUstate, serializedState, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate) {
    return (fmi2Status)snapshot_deserialize(c, __func__, serializedState, size, FMUstate);
}
