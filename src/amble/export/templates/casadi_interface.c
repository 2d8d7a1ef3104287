/* The exported controller as functions (clock, x) -> u that casadi loads; not part of the exported folder. */
#include "amble_controller.h"

static void torques(int stance, double clock, const double *x, double *u) {
  amble_controller controller;
  double force[AMBLE_FORCES];
  unsigned char contact[AMBLE_FEET];
  int foot;
  for (foot = 0; foot < AMBLE_FEET; foot++) contact[foot] = (unsigned char)amble_stands(stance, foot);
  amble_enter(&controller, stance, 0.0);
  amble_step(&controller, clock, x, x + AMBLE_COORDINATES, contact, u, force);
}

static const long long clock_shape[3] = {1, 1, 1};
static const long long state_shape[3] = {2 * AMBLE_COORDINATES, 1, 1};
static const long long torque_shape[3] = {AMBLE_JOINTS, 1, 1};

/* one stance */
int stance_@NUMBER@(const double **arg, double **res, long long *iw, double *w, int mem);
long long stance_@NUMBER@_n_in(void);
long long stance_@NUMBER@_n_out(void);
const long long *stance_@NUMBER@_sparsity_in(long long i);
const long long *stance_@NUMBER@_sparsity_out(long long i);

int stance_@NUMBER@(const double **arg, double **res, long long *iw, double *w, int mem) {
  (void)iw;
  (void)w;
  (void)mem;
  if (res[0]) torques(@NUMBER@, *arg[0], arg[1], res[0]);
  return 0;
}
long long stance_@NUMBER@_n_in(void) { return 2; }
long long stance_@NUMBER@_n_out(void) { return 1; }
const long long *stance_@NUMBER@_sparsity_in(long long i) { return i == 0 ? clock_shape : state_shape; }
const long long *stance_@NUMBER@_sparsity_out(long long i) {
  (void)i;
  return torque_shape;
}
