#include "amble_controller.h"

#include <math.h>

#define MARK 0x616d626c

@TABLES@
typedef int (*evaluation)(const double **arg, double **res, long long *iw, double *w);

@PROTOTYPES@
static const evaluation LAW[LAWS] = {@EVALUATIONS@};

static int all_finite(const double *values, int count) {
  int i;
  for (i = 0; i < count; i++) {
    if (!isfinite(values[i])) return 0;
  }
  return 1;
}

static void permute(const int *index, const double *sign, const double *from, double *to, int count) {
  int i;
  for (i = 0; i < count; i++) to[i] = sign[i] * from[index[i]];
}

@TURNING@/* Law of a stance at its clock; the second half of a mirrored gait mirrors the state and then the result. */
static int evaluate(amble_controller *c, double clock, const double *q, const double *qd, double *u, double *force) {
  double x[2 * AMBLE_COORDINATES], torque[AMBLE_JOINTS] = {0}, contact[AMBLE_FORCES] = {0};
  const double *arg[ARGUMENTS] = {0};
  double *res[RESULTS] = {0};
  int i, place = LAW_OF[c->stance], mirrored = MIRRORED[c->stance], failed;
  if (mirrored) {
    permute(COORDINATE_INDEX, COORDINATE_SIGN, q, x, AMBLE_COORDINATES);
    permute(COORDINATE_INDEX, COORDINATE_SIGN, qd, x + AMBLE_COORDINATES, AMBLE_COORDINATES);
  } else {
    for (i = 0; i < AMBLE_COORDINATES; i++) {
      x[i] = q[i];
      x[AMBLE_COORDINATES + i] = qd[i];
    }
  }
@TURN_STATE@  arg[0] = &clock;
  arg[1] = x;
  arg[2] = PARAMETERS[place];
  res[0] = mirrored ? torque : u;
  res[1] = mirrored ? contact : force;
  res[2] = &c->pivot;
  res[3] = &c->margin;
  failed = LAW[place](arg, res, c->integers, c->work);
  if (mirrored) {
    permute(JOINT_INDEX, JOINT_SIGN, torque, u, AMBLE_JOINTS);
    permute(FORCE_INDEX, FORCE_SIGN, contact, force, AMBLE_FORCES);
  }
@TURN_FORCES@  return failed;
}

/* Largest torque along a joint's rate. */
static double driving(int joint, double rate) {
  double corner = AMBLE_CORNER, share = fabs(rate) / SPEED_LIMIT[joint];
  if (corner >= 1.0 || share <= corner) return TORQUE_LIMIT[joint];
  return share >= 1.0 ? 0.0 : TORQUE_LIMIT[joint] * (1.0 - share) / (1.0 - corner);
}

static int saturate(const double *qd, double *u) {
  int j, cut = 0;
  for (j = 0; j < AMBLE_JOINTS; j++) {
    double rate = qd[AMBLE_COORDINATES - AMBLE_JOINTS + j];
    double limit = u[j] * rate > 0.0 ? driving(j, rate) : TORQUE_LIMIT[j];
    if (u[j] > limit) {
      u[j] = limit;
      cut = 1;
    } else if (u[j] < -limit) {
      u[j] = -limit;
      cut = 1;
    }
  }
  return cut;
}

static unsigned fallback(unsigned status, const double *qd, double *u, double *force) {
  int i;
  for (i = 0; i < AMBLE_JOINTS; i++) {
    double rate = qd[AMBLE_COORDINATES - AMBLE_JOINTS + i];
    u[i] = isfinite(rate) ? -AMBLE_DAMPING * rate : 0.0;
  }
  for (i = 0; i < AMBLE_FORCES; i++) force[i] = 0.0;
  saturate(qd, u);
  return status;
}

static unsigned pressed(const unsigned char *contact) {
  unsigned flags = 0;
  int i;
  for (i = 0; i < AMBLE_FEET; i++) flags |= (unsigned)(contact[i] != 0) << i;
  return flags;
}

static int between_landings(int stance) { return stance >= AMBLE_GAIT_STANCES; }

/* Pass one switch that the flags ask for; whether there was one. A foot lands where it touches after it did not. */
static int switched(amble_controller *c, double t, unsigned flags) {
  int i, here = c->stance;
  for (i = 0; i < SWITCHES; i++) {
    unsigned landing = SWITCH[i].landing;
    if (SWITCH[i].source != here) continue;
    if (landing ? (flags & c->clear & landing) != landing : (flags & SWITCH[i].lifting) != 0) continue;
    c->stance = SWITCH[i].target;
    c->entry = t;
@TURN_HEADING@    return 1;
  }
  return 0;
}

/* Enter the next stance where the flags say so; of feet that land one by one, as many as have landed. */
static void follow(amble_controller *c, double t, unsigned flags) {
  c->clear = (c->clear | ~flags) & ~DOWN[c->stance];
  while (switched(c, t, flags) && between_landings(c->stance)) {
  }
}

/* A stance foot is off the ground, or a swing foot on it that neither just lifted nor is about to land. */
static int wrong(const amble_controller *c, double clock, unsigned flags) {
  unsigned here = DOWN[c->stance], after = AFTER[c->stance];
  int young = between_landings(c->stance) || clock < YOUNG * DURATION[LAW_OF[c->stance]];
  unsigned allowed = here | after | (young ? BEFORE[c->stance] : 0u);
  unsigned needed = young ? here : here & after;
  return (flags & ~allowed) != 0 || (needed & ~flags) != 0;
}

unsigned amble_enter(amble_controller *c, int stance, double t) {
  int i;
  c->entered = 0;
  if (stance < 0 || stance >= AMBLE_STANCES || !isfinite(t)) return AMBLE_BAD_CLOCK;
  c->stance = stance;
  c->entry = t;
  c->last = t;
  c->pivot = 0.0;
  c->margin = 0.0;
  c->heading = 0.0;
  c->clear = 0;
  for (i = 0; i < AMBLE_WORK; i++) c->work[i] = 0.0;
  for (i = 0; i < AMBLE_INTEGERS; i++) c->integers[i] = 0;
  c->entered = MARK;
  return AMBLE_OK;
}

unsigned amble_step(amble_controller *c, double t, const double q[AMBLE_COORDINATES],
                    const double qd[AMBLE_COORDINATES], const unsigned char contact[AMBLE_FEET],
                    double u[AMBLE_JOINTS], double force[AMBLE_FORCES]) {
  unsigned status = AMBLE_OK, flags = pressed(contact);
  double clock;
  if (c->entered != MARK || !(t >= c->entry)) {
    return fallback(isfinite(t) ? AMBLE_BAD_CLOCK : AMBLE_NOT_FINITE, qd, u, force);
  }
  if (!isfinite(t) || !all_finite(q, AMBLE_COORDINATES) || !all_finite(qd, AMBLE_COORDINATES)) {
    return fallback(AMBLE_NOT_FINITE, qd, u, force);
  }
  c->last = t;
  follow(c, t, flags);
  clock = t - c->entry;
  if (wrong(c, clock, flags)) status |= AMBLE_CONTACT_FLAGS;
  if (clock > LATEST * DURATION[LAW_OF[c->stance]]) status |= AMBLE_LATE;
  if (evaluate(c, clock, q, qd, u, force) || !(c->pivot >= SMALLEST_PIVOT)) {
    return fallback(status | AMBLE_RANK_LOST, qd, u, force);
  }
  if (!all_finite(u, AMBLE_JOINTS) || !all_finite(force, AMBLE_FORCES) || !isfinite(c->margin)) {
    return fallback(status | AMBLE_NOT_FINITE, qd, u, force);
  }
  if (saturate(qd, u)) status |= AMBLE_SATURATED;
  if (c->margin < 0.0) status |= AMBLE_CONTACT_FORCE;
  return status;
}

unsigned amble_watchdog(amble_controller *c, double t, const double qd[AMBLE_COORDINATES], double u[AMBLE_JOINTS],
                        double force[AMBLE_FORCES]) {
  if (c->entered != MARK) return fallback(AMBLE_BAD_CLOCK, qd, u, force);
  if (t >= c->last && t - c->last < AMBLE_WATCHDOG_TIME) return AMBLE_OK;
  c->entered = 0;
  return fallback(AMBLE_SILENT, qd, u, force);
}

int amble_stands(int stance, int foot) {
  if (stance < 0 || stance >= AMBLE_STANCES || foot < 0 || foot >= AMBLE_FEET) return 0;
  return (int)(DOWN[stance] >> foot) & 1;
}
