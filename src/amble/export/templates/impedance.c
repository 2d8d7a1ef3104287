#include "amble_controller.h"

#include <math.h>

typedef AMBLE_REAL real;

#define MARK 0x616d626c

@TABLES@
#if AMBLE_AXES
/* One of `size` numbers of a table, between the gaits around both commands of the step. */
static real at(const amble_controller *c, const real *table, int size, int place) {
  real sum = 0;
  int k;
  for (k = 0; k < 2 * AMBLE_CORNERS; k++) sum += c->weight[k] * table[c->node[k] * size + place];
  return sum;
}

/* Find the gaits around a command, and their multilinear weights. */
static void surround(const real *command, int *node, real *part) {
  int cell[AMBLE_AXES], axis, k;
  real share[AMBLE_AXES];
  const real *values = GRID;
  for (axis = 0; axis < AMBLE_AXES; axis++) {
    int i = 0;
    while (i + 2 < GAITS[axis] && command[axis] >= values[i + 1]) i++;
    cell[axis] = i;
    share[axis] = (command[axis] - values[i]) / (values[i + 1] - values[i]);
    values += GAITS[axis];
  }
  for (k = 0; k < AMBLE_CORNERS; k++) {
    node[k] = 0;
    part[k] = 1;
    for (axis = 0; axis < AMBLE_AXES; axis++) {
      int side = (k >> axis) & 1;
      node[k] = node[k] * GAITS[axis] + cell[axis] + side;
      part[k] *= side ? share[axis] : 1 - share[axis];
    }
  }
}

/* Weigh both commands by a share of the step. */
static void weigh(amble_controller *c, real share) {
  int k;
  for (k = 0; k < AMBLE_CORNERS; k++) {
    c->weight[k] = (1 - share) * c->part[k];
    c->weight[k + AMBLE_CORNERS] = share * c->part[k + AMBLE_CORNERS];
  }
}

/* Weigh them at the clock: the share grows up to the planned duration of the stance. */
static void advance(amble_controller *c) {
  real passed = c->clock < c->planned ? c->clock / c->planned : 1;
  weigh(c, c->begin + (c->end - c->begin) * passed);
}

/* Settle between which shares of the step a stance leads, and its planned duration. */
static void plan(amble_controller *c) {
  int law = LAW_OF[c->stance], stances = PASSED[law] + (law < STEP), k;
  real passed = 0, until = 0, whole = 0;
  weigh(c, 0);
  for (k = 0; k < STEP; k++) {
    real duration = at(c, DURATION, LAWS, k);
    if (k < PASSED[law]) passed += duration;
    if (k < stances) until += duration;
    whole += duration;
  }
  c->begin = PASSED[law] == STEP ? 1 : passed / whole;
  c->end = stances == STEP ? 1 : until / whole;
  weigh(c, c->end);
  c->planned = at(c, DURATION, LAWS, law);
  advance(c);
}

/* Go on to the next step: its command leads from the last one towards what was asked for. */
static void move(amble_controller *c) {
  int axis, k;
  for (axis = 0; axis < AMBLE_AXES; axis++) {
    real way = c->asked[axis] - c->followed[axis];
    if (way > CHANGE[axis]) way = CHANGE[axis];
    if (way < -CHANGE[axis]) way = -CHANGE[axis];
    c->left[axis] = c->followed[axis];
    c->followed[axis] += way;
  }
  for (k = 0; k < AMBLE_CORNERS; k++) {
    c->node[k] = c->node[k + AMBLE_CORNERS];
    c->part[k] = c->part[k + AMBLE_CORNERS];
  }
  surround(c->followed, c->node + AMBLE_CORNERS, c->part + AMBLE_CORNERS);
}

/* What the change of the command in this step adds to the feed-forward of a law. */
static real lead(const amble_controller *c, int law, int joint) {
  real sum = 0;
  int axis;
  if (law >= STEP) return 0;
  for (axis = 0; axis < AMBLE_AXES; axis++) {
    int place = (axis * STEP + law) * AMBLE_JOINTS + joint;
    sum += (c->followed[axis] - c->left[axis]) * at(c, LEAD, AMBLE_AXES * STEP * AMBLE_JOINTS, place);
  }
  return sum;
}

static real planned(const amble_controller *c) { return c->planned; }
#else
#define at(c, table, size, place) ((void)(c), (table)[place])

static real planned(const amble_controller *c) { return DURATION[LAW_OF[c->stance]]; }
#endif

/* Values and rates of a law's curves at a clock; outside, the first and last pieces go on. */
static void curves(const amble_controller *c, int law, real *angle, real *rate, real *torque) {
  int piece = FIRST[law], last = FIRST[law + 1] - 1, i, k;
  real clock = c->clock, end = at(c, END, LAWS, law), hold = at(c, HOLD, LAWS, law);
  real inside = clock < end ? clock : end, beyond = (clock < hold ? clock : hold) - inside, xi, half;
  while (piece < last && inside >= at(c, BEGINS, PIECES, piece + 1)) piece++;
  half = at(c, HALVES, PIECES, piece);
  xi = (inside - at(c, BEGINS, PIECES, piece)) / half - 1;
  for (i = 0; i < AMBLE_JOINTS; i++) {
    int first = (piece * AMBLE_JOINTS + i) * COEFFICIENTS;
    real value = at(c, ANGLES, CURVES, first + COEFFICIENTS - 1), slope = 0;
    real push = at(c, TORQUES, CURVES, first + COEFFICIENTS - 1);
    for (k = COEFFICIENTS - 2; k >= 0; k--) {
      slope = slope * xi + value;
      value = value * xi + at(c, ANGLES, CURVES, first + k);
      push = push * xi + at(c, TORQUES, CURVES, first + k);
    }
    slope /= half;
#if AMBLE_AXES
    push += lead(c, law, i);
#endif
    angle[i] = value + slope * beyond;
    rate[i] = clock < hold ? slope : 0;
    torque[i] = push;
  }
}

/* The command of a stance at its clock, without the sum; the second half of a mirrored gait is the mirror image. */
static void refer(const amble_controller *c, amble_command *out) {
  real angle[AMBLE_JOINTS], rate[AMBLE_JOINTS], torque[AMBLE_JOINTS];
  int law = LAW_OF[c->stance], mirrored = MIRRORED[c->stance], i;
  curves(c, law, angle, rate, torque);
  for (i = 0; i < AMBLE_JOINTS; i++) {
    int from = mirrored ? JOINT_INDEX[i] : i;
    real sign = mirrored ? JOINT_SIGN[i] : 1;
    out->angle[i] = sign * angle[from];
    out->rate[i] = sign * rate[from];
    out->torque[i] = sign * torque[from];
    out->stiffness[i] = at(c, STIFFNESS, LAWS * AMBLE_JOINTS, law * AMBLE_JOINTS + from);
    out->damping[i] = at(c, DAMPING, LAWS * AMBLE_JOINTS, law * AMBLE_JOINTS + from);
  }
}

/* Largest torque along a joint's rate. */
static real driving(int joint, real rate) {
  real corner = (real)AMBLE_CORNER, share = (rate < 0 ? -rate : rate) / SPEED_LIMIT[joint];
  if (corner >= 1 || share <= corner) return TORQUE_LIMIT[joint];
  return share >= 1 ? 0 : TORQUE_LIMIT[joint] * (1 - share) / (1 - corner);
}

static unsigned add(const real *q, const real *qd, amble_command *out) {
  unsigned status = AMBLE_OK;
  int i;
  for (i = 0; i < AMBLE_JOINTS; i++) {
    real sum = out->torque[i] - out->stiffness[i] * (q[i] - out->angle[i]) - out->damping[i] * (qd[i] - out->rate[i]);
    real limit = sum * qd[i] > 0 ? driving(i, qd[i]) : TORQUE_LIMIT[i];
    if (sum > limit) {
      sum = limit;
      status = AMBLE_SATURATED;
    } else if (sum < -limit) {
      sum = -limit;
      status = AMBLE_SATURATED;
    }
    out->sum[i] = sum;
  }
  return status;
}

static unsigned fallback(unsigned status, const real *q, const real *qd, amble_command *out) {
  int i;
  for (i = 0; i < AMBLE_JOINTS; i++) {
    real rate = isfinite(qd[i]) ? qd[i] : 0;
    real limit = TORQUE_LIMIT[i], sum = -(real)AMBLE_DAMPING * rate;
    out->angle[i] = isfinite(q[i]) ? q[i] : 0;
    out->rate[i] = out->torque[i] = out->stiffness[i] = 0;
    out->damping[i] = (real)AMBLE_DAMPING;
    out->sum[i] = sum > limit ? limit : sum < -limit ? -limit : sum;
  }
  return status;
}

/* Count ticks and time of flags that differ from what counts, and let those that are confirmed count. A foot is clear
 * once it counts as up and does not touch. */
static void confirm(amble_controller *c, real dt, const unsigned char *contact) {
  int i;
  for (i = 0; i < AMBLE_FEET; i++) {
    unsigned bit = 1u << i;
    if ((contact[i] != 0) == ((c->down & bit) != 0)) {
      c->ticks[i] = 0;
      c->since[i] = 0;
      if (!contact[i]) c->clear |= bit;
      continue;
    }
    if (c->ticks[i]++) c->since[i] += dt;
    if (c->ticks[i] >= AMBLE_CONFIRM_TICKS && c->since[i] >= (real)AMBLE_CONFIRM_TIME) {
      c->down ^= bit;
      c->clear |= bit & ~c->down;
      c->ticks[i] = 0;
      c->since[i] = 0;
    }
  }
}

static int between_landings(int stance) { return stance >= AMBLE_GAIT_STANCES; }

/* Whether feet leave where none lands: they are up, or it is time. */
static int lifts(const amble_controller *c, unsigned feet, real share) {
  if (share < (real)AMBLE_EARLIEST_LIFT_OFF) return 0;
  return (c->down & feet) == 0 || share >= (real)AMBLE_LATEST_LIFT_OFF;
}

/* Pass one switch that the feet ask for; whether there was one. A foot lands where it is down after it was up. */
static int switched(amble_controller *c) {
  int i, here = c->stance;
  real share = c->clock / planned(c);
  if (!between_landings(here) && share < (real)AMBLE_EARLIEST) return 0;
  for (i = 0; i < SWITCHES; i++) {
    unsigned landing = SWITCH[i].landing;
    if (SWITCH[i].source != here) continue;
    if (landing ? (c->down & c->clear & landing) != landing : !lifts(c, SWITCH[i].lifting, share)) continue;
    c->stance = SWITCH[i].target;
    c->clock = 0;
#if AMBLE_AXES
    if (!between_landings(c->stance) && c->stance % STEP == 0) move(c);
    plan(c);
#endif
    return 1;
  }
  return 0;
}

/* Enter the next stance where the feet say so; of feet that land one by one, as many as have landed. */
static void follow(amble_controller *c) {
  c->clear &= ~DOWN[c->stance];
  while (switched(c) && between_landings(c->stance)) {
  }
}

/* A stance foot is up that stays down, or a swing foot down that neither just lifted nor is about to land. */
static int wrong(const amble_controller *c) {
  unsigned here = DOWN[c->stance], after = AFTER[c->stance];
  int young = between_landings(c->stance) || c->clock < (real)YOUNG * planned(c);
  unsigned allowed = here | after | (young ? BEFORE[c->stance] : 0u), needed = young ? here : here & after;
  return (c->down & ~allowed) != 0 || (needed & ~c->down) != 0;
}

#if AMBLE_AXES
/* Begin in the middle of a step, both of whose commands are known. */
static void settle(amble_controller *c) {
  surround(c->left, c->node, c->part);
  surround(c->followed, c->node + AMBLE_CORNERS, c->part + AMBLE_CORNERS);
  plan(c);
}
#endif

unsigned amble_enter(amble_controller *c, int stance) {
  int i;
  c->entered = 0;
  if (stance < 0 || stance >= AMBLE_STANCES) return AMBLE_NOT_ENTERED;
  c->stance = stance;
  c->clock = 0;
  c->down = DOWN[stance];
  c->clear = 0;
  c->silent = 0;
  for (i = 0; i < AMBLE_FEET; i++) {
    c->ticks[i] = 0;
    c->since[i] = 0;
  }
#if AMBLE_AXES
  for (i = 0; i < AMBLE_AXES; i++) c->asked[i] = c->followed[i] = c->left[i] = START[i];
  settle(c);
#endif
  c->entered = MARK;
  return AMBLE_OK;
}

#if AMBLE_AXES
/* Cut a command to the gaits. */
static unsigned within(const AMBLE_REAL *command, real *found) {
  unsigned status = AMBLE_OK;
  int axis;
  for (axis = 0; axis < AMBLE_AXES; axis++) {
    if (!isfinite(command[axis])) return AMBLE_NOT_FINITE;
  }
  for (axis = 0; axis < AMBLE_AXES; axis++) {
    found[axis] = command[axis];
    if (command[axis] < LOWEST[axis] || command[axis] > HIGHEST[axis]) {
      status = AMBLE_OUT_OF_RANGE;
      found[axis] = command[axis] < LOWEST[axis] ? LOWEST[axis] : HIGHEST[axis];
    }
  }
  return status;
}

unsigned amble_steer(amble_controller *c, const AMBLE_REAL command[AMBLE_AXES]) { return within(command, c->asked); }

unsigned amble_enter_at(amble_controller *c, int stance, const AMBLE_REAL command[AMBLE_AXES]) {
  return amble_enter_between(c, stance, command, command);
}

unsigned amble_enter_between(amble_controller *c, int stance, const AMBLE_REAL before[AMBLE_AXES],
                             const AMBLE_REAL after[AMBLE_AXES]) {
  unsigned status = amble_enter(c, stance);
  int axis;
  if (status != AMBLE_OK) return status;
  status = within(before, c->left) | within(after, c->followed);
  for (axis = 0; axis < AMBLE_AXES; axis++) c->asked[axis] = c->followed[axis];
  settle(c);
  return status;
}
#endif

unsigned amble_step(amble_controller *c, AMBLE_REAL dt, const AMBLE_REAL q[AMBLE_JOINTS],
                    const AMBLE_REAL qd[AMBLE_JOINTS], const unsigned char contact[AMBLE_FEET],
                    amble_command *command) {
  unsigned status = AMBLE_OK;
  int i;
  if (c->entered != MARK) return fallback(AMBLE_NOT_ENTERED, q, qd, command);
  if (!(dt >= 0 && dt <= (real)AMBLE_LONGEST_STEP)) {
    status |= AMBLE_BAD_CLOCK;
    dt = dt > 0 ? (real)AMBLE_LONGEST_STEP : 0;
  }
  c->clock += dt;
  c->silent = 0;
  confirm(c, dt, contact);
  follow(c);
#if AMBLE_AXES
  advance(c);
#endif
  if (c->clock >= at(c, HOLD, LAWS, LAW_OF[c->stance])) status |= AMBLE_LATE;
  if (wrong(c)) status |= AMBLE_CONTACT_FLAGS;
  for (i = 0; i < AMBLE_JOINTS; i++) {
    if (!isfinite(q[i]) || !isfinite(qd[i])) return fallback(status | AMBLE_NOT_FINITE, q, qd, command);
  }
  refer(c, command);
  return status | add(q, qd, command);
}

unsigned amble_watchdog(amble_controller *c, AMBLE_REAL dt, const AMBLE_REAL q[AMBLE_JOINTS],
                        const AMBLE_REAL qd[AMBLE_JOINTS], amble_command *command) {
  if (c->entered != MARK) return fallback(AMBLE_NOT_ENTERED, q, qd, command);
  if (dt >= 0) {
    c->silent += dt;
    if (c->silent < (real)AMBLE_WATCHDOG_TIME) return AMBLE_OK;
  }
  c->entered = 0;
  return fallback(AMBLE_SILENT, q, qd, command);
}

int amble_stands(int stance, int foot) {
  if (stance < 0 || stance >= AMBLE_STANCES || foot < 0 || foot >= AMBLE_FEET) return 0;
  return (int)(DOWN[stance] >> foot) & 1;
}
