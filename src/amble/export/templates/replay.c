/* Replay the test vectors: replay test_vectors.txt [repetitions]. Exit code 0 where all agree, 1 where one does not, 2
 * where the file cannot be read. With repetitions the median and the 99th percentile of the time of a step are printed.
 */
#define _POSIX_C_SOURCE 199309L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "amble_controller.h"

#define TOLERANCE 1e-12
#define TIMES 100000

typedef struct {
  int stance;
  double clock, q[AMBLE_COORDINATES], qd[AMBLE_COORDINATES], u[AMBLE_JOINTS], force[AMBLE_FORCES];
  unsigned char contact[AMBLE_FEET];
  unsigned status;
} vector;

static double seconds[TIMES];

static int numbers(FILE *file, double *values, int count) {
  int i;
  for (i = 0; i < count; i++) {
    if (fscanf(file, "%lf", values + i) != 1) return 0;
  }
  return 1;
}

static int next_vector(FILE *file, vector *v) {
  int i, flag;
  if (fscanf(file, "%d", &v->stance) != 1) return 0;
  if (!numbers(file, &v->clock, 1)) return 0;
  if (!numbers(file, v->q, AMBLE_COORDINATES) || !numbers(file, v->qd, AMBLE_COORDINATES)) return 0;
  for (i = 0; i < AMBLE_FEET; i++) {
    if (fscanf(file, "%d", &flag) != 1) return 0;
    v->contact[i] = (unsigned char)flag;
  }
  if (!numbers(file, v->u, AMBLE_JOINTS) || !numbers(file, v->force, AMBLE_FORCES)) return 0;
  return fscanf(file, "%u", &v->status) == 1;
}

/* Largest difference relative to the largest value, at least 1. */
static double difference(const double *ours, const double *theirs, int count) {
  double largest = 0.0, size = 1.0;
  int i;
  for (i = 0; i < count; i++) {
    double d = fabs(ours[i] - theirs[i]);
    if (!(d <= largest)) largest = d;
    if (fabs(theirs[i]) > size) size = fabs(theirs[i]);
  }
  return largest / size;
}

static int ascending(const void *a, const void *b) {
  double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static unsigned run(amble_controller *c, const vector *v, double *u, double *force) {
  unsigned bad = amble_enter(c, v->stance, 0.0);
  return bad | amble_step(c, v->clock, v->q, v->qd, v->contact, u, force);
}

int main(int argc, char **argv) {
  static amble_controller c;
  static vector v;
  double u[AMBLE_JOINTS], force[AMBLE_FORCES], worst = 0.0;
  int count = 0, wrong = 0, timed = 0, repetitions = argc > 2 ? atoi(argv[2]) : 0, i;
  FILE *file = argc > 1 ? fopen(argv[1], "r") : 0;
  if (!file) {
    fprintf(stderr, "usage: replay test_vectors.txt [repetitions]\n");
    return 2;
  }
  while (next_vector(file, &v)) {
    unsigned status = run(&c, &v, u, force);
    double d = fmax(difference(u, v.u, AMBLE_JOINTS), difference(force, v.force, AMBLE_FORCES));
    if (!(d <= worst)) worst = d;
    if (status != v.status || !(d <= TOLERANCE)) {
      fprintf(stderr, "vector %d: status %u, expected %u; difference %.3g\n", count, status, v.status, d);
      wrong++;
    }
    for (i = 0; i < repetitions && timed < TIMES; i++) {
      double start = now();
      run(&c, &v, u, force);
      seconds[timed++] = now() - start;
    }
    count++;
  }
  if (!feof(file) || count == 0) {
    fprintf(stderr, "vector %d cannot be read\n", count);
    return 2;
  }
  fclose(file);
  printf("%d vectors, %d wrong, largest relative difference %.3g\n", count, wrong, worst);
  if (timed) {
    qsort(seconds, (size_t)timed, sizeof seconds[0], ascending);
    printf("median %.3f us, 99th percentile %.3f us, %d steps\n", 1e6 * seconds[timed / 2],
           1e6 * seconds[timed - 1 - timed / 100], timed);
  }
  return wrong ? 1 : 0;
}
