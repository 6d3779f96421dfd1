/* FMI 2.0 of a function without states, for model exchange and co-simulation. Before this text stand INPUTS, OUTPUTS,
 * GUID, starts[INPUTS] and outputs(u, y). */
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define EXPORTED __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORTED __attribute__((visibility("default")))
#else
#define EXPORTED
#endif
/* names have a prefix where several units are linked into one program */
#ifdef FMI2_FUNCTION_PREFIX
#define JOINED(a, b) a##b
#define PREFIXED(a, b) JOINED(a, b)
#define FMI(name) PREFIXED(FMI2_FUNCTION_PREFIX, fmi2##name)
#else
#define FMI(name) fmi2##name
#endif

enum { OK = 0, DISCARD = 2, ERROR = 3 };
typedef unsigned int Reference;
typedef struct {
    int new_states_needed, terminate, nominals_changed, states_changed, next_event_defined;
    double next_event;
} EventInfo;
typedef struct {
    double u[INPUTS], y[OUTPUTS];
    int current;
} Instance;

#define DOES_NOTHING(name, arguments) \
    EXPORTED int FMI(name) arguments { return OK; }
#define NOT_SUPPORTED(name, arguments) \
    EXPORTED int FMI(name) arguments { return ERROR; }
#define NO_VARIABLES(name, type) \
    EXPORTED int FMI(name)(void *c, const Reference r[], size_t n, type v[]) { return n ? ERROR : OK; }

EXPORTED const char *FMI(GetTypesPlatform)(void) { return "default"; }
EXPORTED const char *FMI(GetVersion)(void) { return "2.0"; }

EXPORTED int FMI(Reset)(void *c)
{
    memcpy(((Instance *)c)->u, starts, sizeof(starts));
    ((Instance *)c)->current = 0;
    return OK;
}

EXPORTED void *FMI(Instantiate)(const char *name, int kind, const char *guid, const char *place, const void *calls,
                                int visible, int logging)
{
    Instance *c = strcmp(guid, GUID) ? NULL : malloc(sizeof(Instance));
    if (c) FMI(Reset)(c);
    return c;
}

EXPORTED void FMI(FreeInstance)(void *c) { free(c); }

EXPORTED int FMI(SetReal)(void *c, const Reference r[], size_t n, const double v[])
{
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= INPUTS) return ERROR;
        ((Instance *)c)->u[r[i]] = v[i];
    }
    ((Instance *)c)->current = 0;
    return OK;
}

EXPORTED int FMI(GetReal)(void *c, const Reference r[], size_t n, double v[])
{
    Instance *instance = c;
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= INPUTS + OUTPUTS) return ERROR;
        if (r[i] >= INPUTS && !instance->current) {
            outputs(instance->u, instance->y);
            instance->current = 1;
        }
        v[i] = r[i] < INPUTS ? instance->u[r[i]] : instance->y[r[i] - INPUTS];
    }
    return OK;
}

NO_VARIABLES(GetInteger, int)
NO_VARIABLES(GetBoolean, int)
NO_VARIABLES(GetString, const char *)
NO_VARIABLES(SetInteger, const int)
NO_VARIABLES(SetBoolean, const int)
NO_VARIABLES(SetString, const char *const)

DOES_NOTHING(SetDebugLogging, (void *c, int on, size_t n, const char *const categories[]))
DOES_NOTHING(SetupExperiment, (void *c, int given, double tolerance, double start, int ends, double stop))
DOES_NOTHING(EnterInitializationMode, (void *c))
DOES_NOTHING(ExitInitializationMode, (void *c))
DOES_NOTHING(Terminate, (void *c))
NOT_SUPPORTED(GetFMUstate, (void *c, void **state))
NOT_SUPPORTED(SetFMUstate, (void *c, void *state))
NOT_SUPPORTED(FreeFMUstate, (void *c, void **state))
NOT_SUPPORTED(SerializedFMUstateSize, (void *c, void *state, size_t *size))
NOT_SUPPORTED(SerializeFMUstate, (void *c, void *state, char bytes[], size_t size))
NOT_SUPPORTED(DeSerializeFMUstate, (void *c, const char bytes[], size_t size, void **state))
NOT_SUPPORTED(GetDirectionalDerivative, (void *c, const Reference unknown[], size_t m, const Reference known[], size_t n,
                                         const double seed[], double v[]))

/* model exchange */
DOES_NOTHING(EnterEventMode, (void *c))
DOES_NOTHING(EnterContinuousTimeMode, (void *c))
DOES_NOTHING(SetTime, (void *c, double time))
DOES_NOTHING(SetContinuousStates, (void *c, const double x[], size_t n))
DOES_NOTHING(GetDerivatives, (void *c, double derivatives[], size_t n))
DOES_NOTHING(GetEventIndicators, (void *c, double indicators[], size_t n))
DOES_NOTHING(GetContinuousStates, (void *c, double x[], size_t n))
DOES_NOTHING(GetNominalsOfContinuousStates, (void *c, double nominals[], size_t n))

EXPORTED int FMI(NewDiscreteStates)(void *c, EventInfo *info)
{
    memset(info, 0, sizeof(*info));
    return OK;
}

EXPORTED int FMI(CompletedIntegratorStep)(void *c, int no_setting, int *event, int *terminate)
{
    *event = *terminate = 0;
    return OK;
}

/* co-simulation: outputs follow the inputs of the moment */
DOES_NOTHING(DoStep, (void *c, double time, double step, int no_setting))
NOT_SUPPORTED(SetRealInputDerivatives, (void *c, const Reference r[], size_t n, const int order[], const double v[]))
NOT_SUPPORTED(GetRealOutputDerivatives, (void *c, const Reference r[], size_t n, const int order[], double v[]))
NOT_SUPPORTED(CancelStep, (void *c))
#define NO_STATUS(name, type) \
    EXPORTED int FMI(name)(void *c, int kind, type *value) { return DISCARD; }
NO_STATUS(GetStatus, int)
NO_STATUS(GetRealStatus, double)
NO_STATUS(GetIntegerStatus, int)
NO_STATUS(GetBooleanStatus, int)
NO_STATUS(GetStringStatus, const char *)
