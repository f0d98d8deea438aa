/* Every input comes out at the value reference that follows its own, at once. */
#define NX 0
#define NZ 0
#define STEP 0.1
static const int states[1], derivatives[1];
static const int inputs[] = {1, 3, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31, 33};
enum { SINGLE_DISCRETE = 3, FIXED = 5, TUNABLE = 6, REAL = 7, DISCRETE = 9, TEXT = 29, BYTES = 31, OPTION = 33 };
static int rule(int k) {
    if (k == FIXED) return BEFORE_START;
    if (k == TUNABLE || k == DISCRETE || k == SINGLE_DISCRETE) return AT_EVENTS;
    for (size_t i = 0; i < sizeof inputs / sizeof *inputs; i++)
        if (k == inputs[i]) return ALWAYS;
    return NEVER;
}
static void begin(M *m) {
    strcpy(m->v[TEXT].bytes, "Set me!");
    strcpy(m->v[BYTES].bytes, "foo");
    m->size[BYTES] = 3;
    m->v[OPTION].number = 1;
}
static int compute(M *m) {
    for (size_t i = 0; i < sizeof inputs / sizeof *inputs; i++) {
        m->v[inputs[i] + 1] = m->v[inputs[i]];
        m->size[inputs[i] + 1] = m->size[inputs[i]];
    }
    return 0;
}
static double indicator(M *m) { return 0; }
static void event(M *m) {}
