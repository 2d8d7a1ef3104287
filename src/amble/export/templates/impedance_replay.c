/* Replay the test vectors: replay test_vectors.txt. Exit code 0 where all agree, 1 where one does not, 2 where the file
 * cannot be read. A vector is one command, relative to the largest torque of all of them.
 */
#include <math.h>
#include <stdio.h>

#include "amble_controller.h"

#ifdef AMBLE_FLOAT
#define TOLERANCE 1e-4
#else
#define TOLERANCE 1e-12
#endif

static int numbers(FILE *file, double *values, int count) {
  int i;
  for (i = 0; i < count; i++) {
    if (fscanf(file, "%lf", values + i) != 1) return 0;
  }
  return 1;
}

static double gap(const AMBLE_REAL *ours, const double *theirs) {
  double largest = 0.0;
  int i;
  for (i = 0; i < AMBLE_JOINTS; i++) {
    double d = fabs((double)ours[i] - theirs[i]);
    if (!(d <= largest)) largest = d;
  }
  return largest;
}

int main(int argc, char **argv) {
  amble_controller c;
  amble_command command;
  double clock, state[2 * AMBLE_JOINTS], expected[6 * AMBLE_JOINTS], peak, worst = 0.0;
  AMBLE_REAL q[AMBLE_JOINTS], qd[AMBLE_JOINTS];
  unsigned char contact[AMBLE_FEET];
  int stance, count = 0, wrong = 0, i;
  unsigned status, found;
  FILE *file = argc > 1 ? fopen(argv[1], "r") : 0;
  if (!file || !numbers(file, &peak, 1)) {
    fprintf(stderr, "usage: replay test_vectors.txt\n");
    return 2;
  }
  while (fscanf(file, "%d", &stance) == 1) {
    double d = 0.0;
#if AMBLE_AXES
    double asked[2 * AMBLE_AXES];
    AMBLE_REAL commands[2 * AMBLE_AXES];
    if (!numbers(file, asked, 2 * AMBLE_AXES)) break;
    for (i = 0; i < 2 * AMBLE_AXES; i++) commands[i] = (AMBLE_REAL)asked[i];
#endif
    if (!numbers(file, &clock, 1) || !numbers(file, state, 2 * AMBLE_JOINTS) ||
        !numbers(file, expected, 6 * AMBLE_JOINTS) || fscanf(file, "%u", &status) != 1) {
      break;
    }
#if AMBLE_AXES
    amble_enter_between(&c, stance, commands, commands + AMBLE_AXES);
#else
    amble_enter(&c, stance);
#endif
    c.clock = (AMBLE_REAL)clock;
    for (i = 0; i < AMBLE_JOINTS; i++) {
      q[i] = (AMBLE_REAL)state[i];
      qd[i] = (AMBLE_REAL)state[AMBLE_JOINTS + i];
    }
    for (i = 0; i < AMBLE_FEET; i++) contact[i] = (unsigned char)amble_stands(stance, i);
    found = amble_step(&c, 0, q, qd, contact, &command);
    d = fmax(d, gap(command.angle, expected));
    d = fmax(d, gap(command.rate, expected + AMBLE_JOINTS));
    d = fmax(d, gap(command.torque, expected + 2 * AMBLE_JOINTS) / peak);
    d = fmax(d, gap(command.stiffness, expected + 3 * AMBLE_JOINTS) / peak);
    d = fmax(d, gap(command.damping, expected + 4 * AMBLE_JOINTS) / peak);
    d = fmax(d, gap(command.sum, expected + 5 * AMBLE_JOINTS) / peak);
    if (!(d <= worst)) worst = d;
    if (found != status || !(d <= TOLERANCE)) {
      fprintf(stderr, "vector %d: status %u, expected %u; difference %.3g\n", count, found, status, d);
      wrong++;
    }
    count++;
  }
  if (!feof(file) || count == 0) {
    fprintf(stderr, "vector %d cannot be read\n", count);
    return 2;
  }
  fclose(file);
  printf("%d vectors, %d wrong, largest relative difference %.3g\n", count, wrong, worst);
  return wrong ? 1 : 0;
}
