/* Preloaded by tests/files/run: lets the FAULT_AT-th write to a file whose name holds FAULT_FILE go
 * wrong: FAULT_MODE once (this write fails), full (this and all later ones fail), torn (only a part,
 * FAULT_SHARE percent, is written, then kill -9), count (nothing). The number of
 * the write goes to FAULT_COUNT: that of the last one, or of the one that goes wrong. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

static long writes = 0;

static int chosen(int fd) {
  char link[64], path[4096];
  const char *name = getenv("FAULT_FILE");
  snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
  ssize_t n = readlink(link, path, sizeof path - 1);
  if (n < 0 || !name) return 0;
  path[n] = 0;
  return strstr(path, name) != NULL;
}

/* How many of count bytes are to be written: all, a part (then the process ends), or -1 for none. */
static ssize_t allowed(int fd, size_t count, int *last) {
  const char *mode = getenv("FAULT_MODE"), *at = getenv("FAULT_AT"), *share = getenv("FAULT_SHARE");
  *last = 0;
  if (!mode || !chosen(fd)) return count;
  writes++;
  if (!strcmp(mode, "count") || writes == atol(at ? at : "0")) {
    FILE *out = fopen(getenv("FAULT_COUNT"), "w");
    if (out) { fprintf(out, "%ld\n", writes); fclose(out); }
  }
  if (!strcmp(mode, "count")) return count;
  if (writes < atol(at ? at : "0")) return count;
  if (!strcmp(mode, "full")) return -1;
  if (writes > atol(at ? at : "0")) return count;
  if (!strcmp(mode, "once")) return -1;
  *last = 1;
  return (ssize_t)(count*(double)atol(share ? share : "50")/100.0);
}

ssize_t pwrite(int fd, const void *bytes, size_t count, off_t offset) {
  static ssize_t (*real)(int, const void *, size_t, off_t);
  if (!real) real = dlsym(RTLD_NEXT, "pwrite");
  int last;
  ssize_t n = allowed(fd, count, &last);
  if (n < 0) { errno = ENOSPC; return -1; }
  ssize_t done = n > 0 || !last ? real(fd, bytes, n, offset) : 0;
  if (last) kill(getpid(), SIGKILL);
  return done;
}

ssize_t pwrite64(int fd, const void *bytes, size_t count, off_t offset) {
  return pwrite(fd, bytes, count, offset);
}

ssize_t write(int fd, const void *bytes, size_t count) {
  static ssize_t (*real)(int, const void *, size_t);
  if (!real) real = dlsym(RTLD_NEXT, "write");
  int last;
  ssize_t n = allowed(fd, count, &last);
  if (n < 0) { errno = ENOSPC; return -1; }
  ssize_t done = n > 0 || !last ? real(fd, bytes, n) : 0;
  if (last) kill(getpid(), SIGKILL);
  return done;
}
