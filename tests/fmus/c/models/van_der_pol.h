/* Van der Pol's oscillator: x0' = x1, x1' = mu (1 - x0^2) x1 - x0. */
enum { X0 = 1, DER_X0, X1, DER_X1, MU };
#define NX 2
#define NZ 0
#define STEP 1e-2
static const int states[] = {X0, X1}, derivatives[] = {DER_X0, DER_X1};
static int rule(int k) { return k == MU ? BEFORE_START : k == X0 || k == X1 ? ALWAYS : NEVER; }
static void begin(M *m) { R(X0) = 2; R(MU) = 1; }
static int compute(M *m) {
    R(DER_X0) = R(X1);
    R(DER_X1) = R(MU) * ((1.0 - R(X0) * R(X0)) * R(X1)) - R(X0);
    return 0;
}
static double indicator(M *m) { return 0; }
static void event(M *m) {}
