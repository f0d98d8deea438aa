/* What an FMU does that it must not: one deed in one function, both told by the file resources/fault beside the library.
   In functions of every step it begins at 0.25 s, so that there are rows before it. */
#include <dlfcn.h>
#include <fcntl.h>
#include <fenv.h>
#include <ftw.h>
#include <limits.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define GO (-1000000)
static char function_[64], deed_[64], folder_[4096];
static double now_;
static int stepping_;
static void say(int status, const char *text);

static int does(const char *deed) { return !strcmp(deed_, deed); }
static int due(const char *function) { return !strcmp(function_, function) && (!stepping_ || now_ > 0.25); }

static volatile double zero_;
static volatile int sink_;
static int deeper(int n) { volatile char room[4096]; room[0] = n; return n < 0 ? 0 : deeper(n + 1) + room[0]; }
static int removed(const char *path, const struct stat *s, int kind, struct FTW *place) { return remove(path), 0; }
static void everywhere(const char *text) {
    for (int f = 3; f < 1024; f++)
        if (fcntl(f, F_GETFL) >= 0) {
            fcntl(f, F_SETFL, fcntl(f, F_GETFL) | O_NONBLOCK);
            sink_ = write(f, text, strlen(text));
        }
}
static void *goes_on(void *kept) {
    for (;;) { usleep(100); sink_ += *(char *)kept; say(1, "still there"); }
}
static void *ends_later(void *kept) { usleep(20000); sink_ = *(volatile int *)8; return NULL; }

static int done(void) {
    static const struct { const char *name; int number; } signals[] = {
        {"SIGTERM", SIGTERM}, {"SIGINT", SIGINT}, {"SIGHUP", SIGHUP}, {"SIGPIPE", SIGPIPE}, {"SIGUSR1", SIGUSR1},
        {"SIGALRM", SIGALRM}, {"SIGSTOP", SIGSTOP}, {"SIGCHLD", SIGCHLD}, {"SIGFPE", SIGFPE}, {"SIGKILL", SIGKILL},
        {"SIGCONT", SIGCONT}, {"SIGABRT", SIGABRT}, {"SIGSYS", SIGSYS}, {NULL, 0}};
    static const struct { const char *name; int status; } statuses[] = {
        {"warning", 1}, {"discard", 2}, {"error", 3}, {"fatal", 4}, {"pending", 5}, {"negative", -7}, {"least", INT_MIN},
        {"status 99", 99}, {NULL, 0}};
    pthread_t thread;
    char *huge;
    for (int k = 0; signals[k].name; k++) if (does(signals[k].name)) raise(signals[k].number);
    for (int k = 0; statuses[k].name; k++) if (does(statuses[k].name)) return statuses[k].status;
    if (does("segv")) sink_ = *(volatile int *)8;
    if (does("abort")) abort();
    if (does("exit 0")) exit(0);
    if (does("exit 1")) exit(1);
    if (does("_exit 0")) _exit(0);
    if (does("loop")) for (;;) sink_++;
    if (does("sleep")) for (;;) sleep(1000);
    if (does("divide")) { feenableexcept(FE_DIVBYZERO); zero_ = 1 / zero_; }
    if (does("stack")) sink_ = deeper(0);
    if (does("heap")) { char *p = malloc(64); memset(p - 32, 0xff, 256); free(p); free(p); }
    if (does("memory")) {
        struct rlimit some = {(rlim_t)3 << 30, (rlim_t)3 << 30};
        setrlimit(RLIMIT_AS, &some);
        for (;;) { char *p = malloc(1 << 24); if (!p) abort(); memset(p, 1, 4096); }
    }
    if (does("log many")) for (int k = 0; k < 20000; k++) say(1, "it is warm");
    if (does("log many and fail")) {
        say(3, "it is too hot");
        for (int k = 0; k < 20000; k++) say(1, "it is warm");
        return 3;
    }
    if (does("log markup")) { say(3, "[bold]no[/nonsense] [link=file:///x]"); return 3; }
    if (does("log escape")) { say(3, "\033]0;title\007\033[2J\r\x9b" "31m\xe2\x80\xae"); return 3; }
    if (does("log format")) { say(3, "100%% %%n"); return 3; }
    if (does("log bad UTF-8")) { say(3, "\xff\xfe\xc0\xaf"); return 3; }
    if (does("log NULL")) { say(3, NULL); return 3; }
    if (does("log huge")) { huge = malloc(1 << 26); memset(huge, 'x', 1 << 26); huge[(1 << 26) - 1] = 0; say(3, huge); free(huge); return 3; }
    if (does("print")) { for (int k = 0; k < 100000; k++) { puts("\033[31mred"); fputs("\033[2J", stderr); } fflush(stdout); }
    if (does("read")) { char byte; sink_ = read(0, &byte, 1); sink_ = getchar(); }
    if (does("write everywhere")) everywhere("\x80\x04K\x07.");
    if (does("write much everywhere")) for (int k = 0; k < 2000; k++) everywhere("\x7f\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff\xff");
    if (does("close all")) for (int f = 0; f < 1024; f++) close(f);
    if (does("close streams")) { close(0); close(1); close(2); }
    if (does("shorten")) for (int f = 3; f < 1024; f++) sink_ = ftruncate(f, 0);
    if (does("fork")) if (!fork()) { sleep(1000); _exit(0); }
    if (does("fork and leave")) if (!fork()) { setsid(); if (!fork()) { sleep(1000); } _exit(0); }
    if (does("fork 64")) for (int k = 0; k < 64; k++) if (!fork()) { setsid(); for (;;) sleep(1000); }
    if (does("fork and die")) { if (!fork()) { setsid(); sleep(1000); _exit(0); } abort(); }
    if (does("fork and kill")) { if (!fork()) { setsid(); sleep(1000); _exit(0); } kill(getppid(), SIGKILL); }
    if (does("fork itself")) { pid_t child = fork(); if (child) waitpid(child, NULL, 0); else exit(0); }
    if (does("execute")) if (!fork()) { setsid(); execl("/bin/sleep", "sleep", "1000", NULL); _exit(1); }
    if (does("thread")) pthread_create(&thread, NULL, goes_on, malloc(8));
    if (does("thread dies")) { pthread_create(&thread, NULL, ends_later, NULL); usleep(100000); }
    if (does("handlers")) for (int s = 1; s < 32; s++) signal(s, SIG_IGN);
    if (does("mask")) { sigset_t all; sigfillset(&all); sigprocmask(SIG_BLOCK, &all, NULL); }
    if (does("alarm")) alarm(1);
    if (does("locale")) { setenv("LC_ALL", "C.UTF-8", 1); setlocale(LC_ALL, ""); }
    if (does("arithmetic")) { fesetround(FE_UPWARD); feenableexcept(FE_DIVBYZERO | FE_INVALID | FE_OVERFLOW); }
    if (does("folder")) sink_ = chdir("/");
    if (does("lost folder")) { char path[] = "/tmp/lostXXXXXX"; sink_ = !mkdtemp(path) || chdir(path) || rmdir(path); }
    if (does("environment")) { clearenv(); setenv("PATH", "/nowhere", 1); setenv("TMPDIR", "/nowhere", 1); }
    if (does("permissions")) umask(0777);
    if (does("limits")) {
        struct rlimit few = {0, 0};
        setrlimit(RLIMIT_NOFILE, &few); setrlimit(RLIMIT_FSIZE, &few); setrlimit(RLIMIT_NPROC, &few);
    }
    if (does("priority")) { sink_ = nice(19); }
    if (does("kill parent")) kill(getppid(), SIGKILL);
    if (does("stop parent")) kill(getppid(), SIGSTOP);
    if (does("terminate parent")) kill(getppid(), SIGTERM);
    if (does("kill group")) kill(0, SIGKILL);
    if (does("trace parent")) { ptrace(PTRACE_ATTACH, getppid(), NULL, NULL); usleep(1000); }
    if (does("session")) setsid();
    if (does("delete")) {
        nftw(folder_, removed, 16, FTW_DEPTH | FTW_PHYS);
        if (getenv("TMPDIR")) nftw(getenv("TMPDIR"), removed, 16, FTW_DEPTH | FTW_PHYS);
    }
    if (does("exit handler")) atexit(abort);
    return GO;
}

/* What a function gives, after it. */
static void spoil_number(double *value) {
    if (does("NaN")) *value = NAN;
    if (does("infinity")) *value = -INFINITY;
}
static void spoil_texts(const char **values, size_t n) {
    static char *huge;
    if (!n) return;
    if (does("NULL text")) values[0] = NULL;
    if (does("bad UTF-8")) values[0] = "caf\xe9";
    if (does("wild text")) values[0] = (const char *)16;
    if (does("huge text")) {
        if (!huge) { huge = malloc(1 << 26); memset(huge, 'x', 1 << 26); huge[(1 << 26) - 1] = 0; }
        values[0] = huge;
    }
}
static void spoil_bytes(size_t *sizes, const void **values, size_t n) {
    if (!n) return;
    if (does("NULL bytes")) { sizes[0] = 7; values[0] = NULL; }
    if (does("no bytes")) { sizes[0] = 0; values[0] = NULL; }
    if (does("huge size")) { sizes[0] = (size_t)-1; values[0] = "x"; }
    if (does("wrong size")) { sizes[0] = 60 << 20; values[0] = "x"; }
    if (does("other bytes")) { sizes[0] = 3; values[0] = "\0\xff\0"; }
}
static void spoil_step(unsigned char *event, unsigned char *terminate, unsigned char *early, double *last, double t, double h) {
    if (does("early")) { *early = 1; *last = t + h / 2; }
    if (does("early without a move")) { *early = 1; *last = t; }
    if (does("early before")) { *early = 1; *last = t - 5; }
    if (does("early after")) { *early = 1; *last = t + 100 * h; }
    if (does("early NaN")) { *early = 1; *last = NAN; }
    if (does("last before")) *last = t - 5;
    if (does("last after")) *last = t + 100 * h;
    if (does("last NaN")) *last = NAN;
    if (does("event")) *event = 1;
    if (does("flags")) *event = *early = 0xff;
    if (does("terminate")) *terminate = 1;
    if (does("terminate NaN")) { *terminate = *early = 1; *last = NAN; }
}

static void learn(void) {
    Dl_info here;
    dladdr((void *)learn, &here);
    snprintf(folder_, sizeof folder_, "%s", here.dli_fname);
    for (int k = 0; k < 3; k++) *strrchr(folder_, '/') = 0;
    char path[5000];
    snprintf(path, sizeof path, "%s/resources/fault", folder_);
    FILE *file = fopen(path, "r");
    if (!file) return;
    sink_ = fscanf(file, "%63[^\n]\n%63[^\n]\n%d", function_, deed_, &stepping_);
    fclose(file);
}
__attribute__((constructor)) static void loaded(void) { learn(); if (due("constructor")) done(); }
__attribute__((destructor)) static void unloaded(void) { if (due("destructor")) done(); }
