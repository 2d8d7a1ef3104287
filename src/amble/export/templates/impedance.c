#include "amble_controller.h"

#include <math.h>

typedef AMBLE_REAL real;

#define MARK 0x616d626c

@TABLES@
/* Values and rates of a domain's curves at a clock; outside, the first and last pieces go on. */
static void curves(int domain, real clock, real *angle, real *rate, real *torque) {
  const real *begins = BEGINS + FIRST[domain];
  int count = FIRST[domain + 1] - FIRST[domain], piece = 0, i, k;
  real inside = clock < END[domain] ? clock : END[domain];
  real beyond = (clock < HOLD[domain] ? clock : HOLD[domain]) - inside, xi, half;
  while (piece + 1 < count && inside >= begins[piece + 1]) piece++;
  half = HALVES[FIRST[domain] + piece];
  xi = (inside - begins[piece]) / half - 1;
  for (i = 0; i < AMBLE_JOINTS; i++) {
    const real *a = ANGLES + ((FIRST[domain] + piece) * AMBLE_JOINTS + i) * COEFFICIENTS;
    const real *u = TORQUES + ((FIRST[domain] + piece) * AMBLE_JOINTS + i) * COEFFICIENTS;
    real value = a[COEFFICIENTS - 1], slope = 0, push = u[COEFFICIENTS - 1];
    for (k = COEFFICIENTS - 2; k >= 0; k--) {
      slope = slope * xi + value;
      value = value * xi + a[k];
      push = push * xi + u[k];
    }
    slope /= half;
    angle[i] = value + slope * beyond;
    rate[i] = clock < HOLD[domain] ? slope : 0;
    torque[i] = push;
  }
}

/* The command of a stance at its clock, without the sum; the second half of a mirrored gait is the mirror image. */
static void refer(const amble_controller *c, amble_command *out) {
  real angle[AMBLE_JOINTS], rate[AMBLE_JOINTS], torque[AMBLE_JOINTS];
  int domain = c->stance % SOLVED, mirrored = c->stance >= SOLVED, i;
  curves(domain, c->clock, angle, rate, torque);
  for (i = 0; i < AMBLE_JOINTS; i++) {
    int from = mirrored ? JOINT_INDEX[i] : i;
    real sign = mirrored ? JOINT_SIGN[i] : 1;
    out->angle[i] = sign * angle[from];
    out->rate[i] = sign * rate[from];
    out->torque[i] = sign * torque[from];
    out->stiffness[i] = STIFFNESS[domain * AMBLE_JOINTS + from];
    out->damping[i] = DAMPING[domain * AMBLE_JOINTS + from];
  }
}

static unsigned add(const real *q, const real *qd, amble_command *out) {
  unsigned status = AMBLE_OK;
  int i;
  for (i = 0; i < AMBLE_JOINTS; i++) {
    real sum = out->torque[i] - out->stiffness[i] * (q[i] - out->angle[i]) - out->damping[i] * (qd[i] - out->rate[i]);
    if (sum > TORQUE_LIMIT[i]) {
      sum = TORQUE_LIMIT[i];
      status = AMBLE_SATURATED;
    } else if (sum < -TORQUE_LIMIT[i]) {
      sum = -TORQUE_LIMIT[i];
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

/* Count ticks and time of flags that differ from what counts, and let those that are confirmed count. */
static void confirm(amble_controller *c, real dt, const unsigned char *contact) {
  int i;
  for (i = 0; i < AMBLE_FEET; i++) {
    unsigned bit = 1u << i;
    if ((contact[i] != 0) == ((c->down & bit) != 0)) {
      c->ticks[i] = 0;
      c->since[i] = 0;
      continue;
    }
    if (c->ticks[i]++) c->since[i] += dt;
    if (c->ticks[i] >= AMBLE_CONFIRM_TICKS && c->since[i] >= (real)AMBLE_CONFIRM_TIME) {
      c->down ^= bit;
      c->ticks[i] = 0;
      c->since[i] = 0;
    }
  }
}

/* Enter the next stance where the feet say so. */
static void follow(amble_controller *c) {
  int next = (c->stance + 1) % AMBLE_STANCES;
  unsigned landing = DOWN[next] & ~DOWN[c->stance], lifting = DOWN[c->stance] & ~DOWN[next];
  int arrived = landing ? (c->down & landing) == landing : (c->down & lifting) == 0;
  if (arrived && c->clock >= (real)AMBLE_EARLIEST * DURATION[c->stance % SOLVED]) {
    c->stance = next;
    c->clock = 0;
  }
}

/* A stance foot is up that stays down, or a swing foot down that neither just lifted nor is about to land. */
static int wrong(const amble_controller *c) {
  unsigned here = DOWN[c->stance], before = DOWN[(c->stance + AMBLE_STANCES - 1) % AMBLE_STANCES];
  unsigned after = DOWN[(c->stance + 1) % AMBLE_STANCES];
  int young = c->clock < (real)AMBLE_EARLIEST * DURATION[c->stance % SOLVED];
  unsigned allowed = here | (young ? before : after), needed = young ? here : here & after;
  return (c->down & ~allowed) != 0 || (needed & ~c->down) != 0;
}

unsigned amble_enter(amble_controller *c, int stance) {
  int i;
  c->entered = 0;
  if (stance < 0 || stance >= AMBLE_STANCES) return AMBLE_NOT_ENTERED;
  c->stance = stance;
  c->clock = 0;
  c->down = DOWN[stance];
  for (i = 0; i < AMBLE_FEET; i++) {
    c->ticks[i] = 0;
    c->since[i] = 0;
  }
  c->entered = MARK;
  return AMBLE_OK;
}

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
  confirm(c, dt, contact);
  follow(c);
  if (c->clock >= HOLD[c->stance % SOLVED]) status |= AMBLE_LATE;
  if (wrong(c)) status |= AMBLE_CONTACT_FLAGS;
  for (i = 0; i < AMBLE_JOINTS; i++) {
    if (!isfinite(q[i]) || !isfinite(qd[i])) return fallback(status | AMBLE_NOT_FINITE, q, qd, command);
  }
  refer(c, command);
  return status | add(q, qd, command);
}

int amble_stands(int stance, int foot) {
  if (stance < 0 || stance >= AMBLE_STANCES || foot < 0 || foot >= AMBLE_FEET) return 0;
  return (int)(DOWN[stance] >> foot) & 1;
}
