/* The first character of the file y.txt in the folder of resources, read whenever a value is wanted. */
enum { Y = 1 };
#define NX 0
#define NZ 0
#define STEP 1.0
static const int states[1], derivatives[1];
static int rule(int k) { return NEVER; }
static void begin(M *m) {}
static int compute(M *m) {
    char path[5000];
    FILE *file;
    snprintf(path, sizeof path, "%sy.txt", m->resources);
    if (!(file = fopen(path, "r"))) return 1;
    m->v[Y].number = (char)fgetc(file);
    fclose(file);
    return 0;
}
static double indicator(M *m) { return 0; }
static void event(M *m) {}
