/* Ends the process of a role by a signal at its n-th call of the system library, for LD_PRELOAD.
   ROLE: the subcommand of the process. CALL: the number of the call, from 1; 0 counts only.
   MARK: a folder that is made when the process is ended, so that it is ended once. COUNT: a file
   that receives the number of calls at the end of the process. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static int is_role;
static long end_at, calls;

__attribute__((constructor)) static void begin(void) {
  char line[4096] = {0};
  int file = REAL(open)("/proc/self/cmdline", O_RDONLY);
  long length = read(file, line, sizeof line - 1);
  REAL(close)(file);
  char *subcommand = line + strlen(line) + 1;
  end_at = getenv("CALL") ? atol(getenv("CALL")) : 0;
  is_role = length > 0 && subcommand < line + length && getenv("ROLE") &&
            !strcmp(subcommand, getenv("ROLE"));
}

__attribute__((destructor)) static void end(void) {
  if (!is_role || !getenv("COUNT")) return;
  is_role = 0;
  FILE *file = fopen(getenv("COUNT"), "w");
  if (file) {
    fprintf(file, "%ld", calls);
    fclose(file);
  }
}

static void count(void) {
  if (!is_role || __sync_add_and_fetch(&calls, 1) != end_at) return;
  if (REAL(mkdir)(getenv("MARK"), 0700) == 0) kill(getpid(), SIGKILL);
}

static mode_t mode_of(int flags, va_list rest) {
  return flags & O_CREAT ? va_arg(rest, mode_t) : 0;
}

int open(const char *name, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  mode_t mode = mode_of(flags, rest);
  va_end(rest);
  count();
  return REAL(open)(name, flags, mode);
}
int open64(const char *name, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  mode_t mode = mode_of(flags, rest);
  va_end(rest);
  count();
  return REAL(open64)(name, flags, mode);
}
int shm_open(const char *name, int flags, mode_t mode) {
  count();
  return REAL(shm_open)(name, flags, mode);
}
int shm_unlink(const char *name) {
  count();
  return REAL(shm_unlink)(name);
}
int ftruncate(int file, off_t size) {
  count();
  return REAL(ftruncate)(file, size);
}
int ftruncate64(int file, off64_t size) {
  count();
  return REAL(ftruncate64)(file, size);
}
int fchmod(int file, mode_t mode) {
  count();
  return REAL(fchmod)(file, mode);
}
void *mmap(void *at, size_t size, int access, int flags, int file, off_t offset) {
  if (file >= 0) count();
  return REAL(mmap)(at, size, access, flags, file, offset);
}
void *mmap64(void *at, size_t size, int access, int flags, int file, off64_t offset) {
  if (file >= 0) count();
  return REAL(mmap64)(at, size, access, flags, file, offset);
}
int munmap(void *at, size_t size) {
  count();
  return REAL(munmap)(at, size);
}
int remove(const char *name) {
  count();
  return REAL(remove)(name);
}
int unlink(const char *name) {
  count();
  return REAL(unlink)(name);
}
int mkdir(const char *name, mode_t mode) {
  count();
  return REAL(mkdir)(name, mode);
}
int rmdir(const char *name) {
  count();
  return REAL(rmdir)(name);
}
int flock(int file, int operation) {
  count();
  return REAL(flock)(file, operation);
}
int close(int file) {
  count();
  return REAL(close)(file);
}
ssize_t write(int file, const void *data, size_t size) {
  count();
  return REAL(write)(file, data, size);
}
