/* SPDX-License-Identifier: MIT
   Ranks that wait for a message sleep, so that other processes have their core; loaded by LD_PRELOAD, see processes.py.

   Open MPI polls, and calls sched_yield between polls. That helps others that are ready on the same core only, and who
   yielded may wait for a whole time slice, some milliseconds: two ranks that did nothing but exchange messages ran
   several times as long beside one busy process. A short sleep instead ends when it should. Messages that come at once,
   while all ranks have a core, are waited for without it. */
#define _GNU_SOURCE
#include <sys/prctl.h>
#include <time.h>

enum
{
  pause = 20000,   /* longer without a poll [ns]: another wait has begun */
  polling = 20000, /* how long a wait polls before it sleeps [ns] */
  nap = 20000      /* one sleep [ns] */
};

static long now(void)
{
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return 1000000000L * t.tv_sec + t.tv_nsec;
}

int sched_yield(void)
{
  static __thread long begin, last;
  const long t = now();
  if (last == 0)
    prctl(PR_SET_TIMERSLACK, 1000); /* ns; 50000 otherwise */
  if (last == 0 || t - last > pause)
    begin = t;
  if (t - begin > polling)
    nanosleep(&(struct timespec){0, nap}, 0);
  last = now();
  return 0;
}
