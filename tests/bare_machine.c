// A machine that lacks something: preload the library made of this file, compiled with SEMAPHORES or LOCKS as the error.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <semaphore.h>

#ifdef SEMAPHORES  // a container without /dev/shm, or one that forbids them
sem_t *sem_open(const char *name, int flags, ...) {
    errno = SEMAPHORES;
    return SEM_FAILED;
}
#endif

#ifdef LOCKS  // a file system without locks
int flock(int descriptor, int operation) {
    errno = LOCKS;
    return -1;
}

int lockf(int descriptor, int command, off_t length) {
    errno = LOCKS;
    return -1;
}
#endif
