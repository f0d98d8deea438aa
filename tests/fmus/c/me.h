/* A Model Exchange FMU in one struct: variables by value reference, the model in functions of its own header.
   0 is the time, 1..NX the states, NX+1..2*NX their derivatives; what follows is the model's own. */
#include <stdlib.h>
#include <string.h>

typedef struct {
    double v[64];
    int mode; /* 0 instantiated, 1 initialization, 2 event, 3 continuous time */
    long calls;
} M;

typedef struct {
    int again, terminate, nominals, values, next_defined;
    double next;
} Event;

#include MODEL /* NX, NZ, start, compute, indicators, event, step_event, nominal */
