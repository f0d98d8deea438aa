/* A ball that falls from 1 m: h' = v, v' = g; v := -e v where h = 0, and it rests once it is slower than 0.1 m/s. */
enum { H = 1, DER_H, V, DER_V, G, E, V_MIN };
#define NX 2
#define NZ 1
#define STEP 1e-3
static const int states[] = {H, V}, derivatives[] = {DER_H, DER_V};
static int rule(int k) { return k == G ? BEFORE_START : k == E ? AT_EVENTS : k == H || k == V ? ALWAYS : NEVER; }
static void begin(M *m) { R(H) = 1; R(G) = -9.81; R(E) = 0.7; R(V_MIN) = 0.1; }
static int compute(M *m) { R(DER_H) = R(V); R(DER_V) = R(G); return 0; }
static double indicator(M *m) { return R(H) > -1e-10 && R(H) <= 0 && R(V) > 0 ? -1e-10 : R(H); }
static void event(M *m) {
    m->changed = R(H) <= 0 && R(V) < 0;
    if (!m->changed) return;
    R(H) = DBL_MIN; /* above the ground, so that this is no crossing */
    R(V) = -R(V) * R(E);
    if (R(V) < R(V_MIN)) R(V) = R(G) = 0;
}
