/* The contract between the runtime and a generated model.
 *
 * For every block the generator writes two files:
 *   model.c      the block's equations as C functions (by CasADi)
 *   variables.c  `model`, the description below: names, types, ranges, start values and sizes
 *
 * Value references. All values of an instance stand in one row of doubles:
 *
 *     time | parameters p | inputs u | outputs y | clock, when the model is sampled | states x
 *
 * The value reference of an element is its place in this row. FMI 2.0 names every element; FMI 3.0 names an array
 * by its first, and only FMI 3.0 knows time and the clock. States have no reference that FMI knows of.
 */
#ifndef MACROSTEP_MODEL_H
#define MACROSTEP_MODEL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Only the functions of FMI are for others, whatever flags an importer compiles with: two FMUs in one process must
 * not take each other's `model` for their own. */
#ifdef __GNUC__
#pragma GCC visibility push(hidden)
#endif

/* CasADi's own integer, as it stands in model.c. */
typedef long long int Integer;

/* How CasADi's functions are called: `arguments` and `results` are arrays of columns. A result that is NULL is not
 * wanted. Both arrays, and the two work arrays, are scratch of the sizes that the function of type WorkSizes gives.
 * The return value is 0 when all went well. */
typedef int Evaluate(const double **arguments, double **results, Integer *integers, double *doubles, int memory);
typedef int WorkSizes(Integer *arguments, Integer *results, Integer *integers, Integer *doubles);

typedef struct {
    Evaluate *evaluate;
    WorkSizes *work_sizes;
} Function;

/* The types of FMI 3.0; in FMI 2.0 they are Real, Integer, Boolean and Enumeration. A function of FMI serves one or
 * several of them, hence bits. */
typedef enum { FLOAT64 = 1, INT32 = 2, BOOLEAN = 4, ENUMERATION = 8, CLOCK = 16 } Type;

typedef enum { TIME, FIXED_PARAMETER, TUNABLE_PARAMETER, INPUT, OUTPUT, INPUT_CLOCK, STATE } Role;

typedef struct {
    const char *name;
    Type type;
    Role role;
    uint32_t reference; /* of the first element */
    uint32_t size;      /* number of elements, 1 for a scalar */
    double min, max;    /* infinite where there is no limit */
} Variable;

typedef struct {
    const char *name;
    const char *token; /* the GUID of FMI 2.0 and the instantiation token of FMI 3.0 */
    bool sampled;      /* acts once per step or tick of its clock, and its outputs hold until the next */
    double interval;   /* [s] from one tick of the clock to the next, unless the importer sets another */
    double max_step;   /* longest step [s] that `step` is called with */

    size_t n_p, n_u, n_y, n_x;
    const double *start; /* of the parameters and, after them, of the inputs */

    const Variable *variables; /* in the order of the row above */
    size_t n_variables;
    const uint16_t *variable_of; /* which variable the element with a reference belongs to */

    Function initial; /* (p) -> (x) */
    Function output;  /* (x, u, p) -> (y); absent when sampled, because then `step` gives the outputs */
    Function step;    /* (x, u, p, h) -> (x), and when sampled (x, u, p, h) -> (x, y) */
} Model;

extern const Model model;

#ifdef __GNUC__
#pragma GCC visibility pop
#endif

#endif
