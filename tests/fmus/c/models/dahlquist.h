/* Dahlquist's test equation: x' = -k x. */
enum { X = 1, DER_X, K };
#define NX 1
#define NZ 0
#define STEP 0.1
static const int states[] = {X}, derivatives[] = {DER_X};
static int rule(int k) { return k == X ? ALWAYS : k == K ? BEFORE_START : NEVER; }
static void begin(M *m) { R(X) = R(K) = 1; }
static int compute(M *m) { R(DER_X) = -R(K) * R(X); return 0; }
static double indicator(M *m) { return 0; }
static void event(M *m) {}
