/* The exported controller in a loop with MuJoCo: sample, hold, delay, noise, rounding, push, and what is measured. Compiled with
 * amble_controller.c, of the impedance law or of one that reads the whole state; one call walks one case. */
#include <math.h>
#include <mujoco/mujoco.h>
#include <stdint.h>
#include <string.h>

#include "amble_controller.h"

#define RING 512

typedef struct {
  int cycles;         /* the walk ends after so many */
  int every, delay;   /* steps of the plant between two of the controller, and until its command arrives */
  int trunk;          /* body of the base */
  double threshold;   /* normal force at which a foot's flag is set, N */
  double noise_angle, noise_rate; /* standard deviations, rad and rad/s */
  double quantum_angle, quantum_rate; /* steps in which joints are measured, rad and rad/s; 0 for none */
  double cap, lag;    /* torque limit, N m, and time constant, s, of the motors */
  double rise, edge, ahead; /* height of a step of the ground, m, x of its edge, and on which side of it, 1 or -1 */
  double reach;       /* by which deviations of the base's place and velocity are larger, m */
  double push[3], push_from, push_until; /* force on the base, N, between two times, s */
  double lowest, steepest; /* height of the base, m, and vertical component of its axis, below which it has fallen */
  double longest;     /* the walk ends after so long, s */
  uint64_t seed;
  int qpos[AMBLE_JOINTS], dof[AMBLE_JOINTS], motor[AMBLE_JOINTS], geom[AMBLE_FEET];
} settings;

typedef struct {
  int cycles, fell;
  double time, x, y, square, peak, slip, deepest;
  unsigned status;
} outcome;

static uint64_t state[2];

static double uniform(void) {
  uint64_t a = state[0], b = state[1];
  state[0] = b;
  a ^= a << 23;
  state[1] = a ^ b ^ (a >> 17) ^ (b >> 26);
  return ((double)((state[1] + b) >> 11) + 0.5) / 9007199254740992.0;
}

static double normal(void) {
  double r = sqrt(-2.0 * log(uniform()));
  return r * cos(6.283185307179586 * uniform());
}

/* Normal forces on the feet, and the whole forces in the world's axes. */
static void press(const mjModel *m, const mjData *d, const settings *s, double *force, double (*whole)[3]) {
  int i, f, k;
  for (f = 0; f < AMBLE_FEET; f++) force[f] = whole[f][0] = whole[f][1] = whole[f][2] = 0.0;
  for (i = 0; i < d->ncon; i++) {
    const mjtNum *axes = d->contact[i].frame;
    mjtNum wrench[6];
    mj_contactForce(m, d, i, wrench);
    for (f = 0; f < AMBLE_FEET; f++) {
      int second = d->contact[i].geom[1] == s->geom[f];
      if (!second && d->contact[i].geom[0] != s->geom[f]) continue;
      force[f] += wrench[0];
      for (k = 0; k < 3; k++) { /* the frame's first axis points from the first geom to the second */
        double along = axes[k] * wrench[0] + axes[3 + k] * wrench[1] + axes[6 + k] * wrench[2];
        whole[f][k] += second ? along : -along;
      }
    }
  }
}

/* Horizontal speed of a foot's lowest point, m/s: a foot that rolls does not slip. */
static double sliding(const mjModel *m, const mjData *d, int geom) {
  mjtNum v[6];
  double r = m->geom_size[3 * geom];
  mj_objectVelocity(m, d, mjOBJ_GEOM, geom, v, 0);
  return hypot(v[3] - r * v[1], v[4] + r * v[0]);
}

/* Height of the ground at a place, m. */
static double ground(const settings *s, double x) { return s->ahead * (x - s->edge) > 0.0 ? s->rise : 0.0; }

/* Deepest origin or centre of mass of a body below the ground, m; the robot's record has no other shape. */
static double depth(const mjModel *m, const mjData *d, const settings *s) {
  double found = -1e30;
  int b;
  for (b = 1; b < m->nbody; b++) {
    double mass = ground(s, d->xipos[3 * b]) - d->xipos[3 * b + 2];
    double origin = ground(s, d->xpos[3 * b]) - d->xpos[3 * b + 2];
    if (mass > found) found = mass;
    if (origin > found) found = origin;
  }
  return found;
}

static double noisy(double value, double deviation) { return deviation > 0.0 ? value + deviation * normal() : value; }

static double rounded(double value, double quantum) { return quantum > 0.0 ? quantum * rint(value / quantum) : value; }

static void sense(const mjData *d, const settings *s, double *q, double *qd) {
  int i;
  for (i = 0; i < AMBLE_JOINTS; i++) {
    q[i] = rounded(noisy(d->qpos[s->qpos[i]], s->noise_angle), s->quantum_angle);
    qd[i] = rounded(noisy(d->qvel[s->dof[i]], s->noise_rate), s->quantum_rate);
  }
}

#ifdef AMBLE_COORDINATES /* a controller that reads the whole state, and flags that are confirmed before */
#define BASE (AMBLE_COORDINATES - AMBLE_JOINTS)

typedef struct {
  amble_controller c;
  unsigned char down[AMBLE_FEET];
  int ticks[AMBLE_FEET];
  double since[AMBLE_FEET], time;
} driver;

/* The base: place, angles of the chain X-Y-Z, and their rates. */
static void sense_base(const mjData *d, const settings *s, double *q, double *qd) {
  mjtNum r[9];
  const mjtNum *w = d->qvel + 3;
  int i;
  mju_quat2Mat(r, d->qpos + 3);
  for (i = 0; i < 3; i++) {
    q[i] = d->qpos[i];
    qd[i] = d->qvel[i];
  }
  q[3] = atan2(-r[5], r[8]);
  q[4] = asin(r[2] > 1.0 ? 1.0 : r[2] < -1.0 ? -1.0 : r[2]);
  q[5] = atan2(-r[1], r[0]);
  qd[3] = (cos(q[5]) * w[0] - sin(q[5]) * w[1]) / cos(q[4]);
  qd[4] = sin(q[5]) * w[0] + cos(q[5]) * w[1];
  qd[5] = w[2] - sin(q[4]) * qd[3];
  for (i = 0; i < BASE; i++) {
    double scale = i < 3 ? s->reach : 1.0;
    q[i] = noisy(q[i], scale * s->noise_angle);
    qd[i] = noisy(qd[i], scale * s->noise_rate);
  }
}

static void begin(driver *v) {
  int f;
  memset(v, 0, sizeof *v);
  amble_enter(&v->c, 0, 0.0);
  for (f = 0; f < AMBLE_FEET; f++) v->down[f] = (unsigned char)amble_stands(0, f);
}

static unsigned act(driver *v, double dt, const mjData *d, const settings *s, const unsigned char *contact, double *u) {
  double q[AMBLE_COORDINATES], qd[AMBLE_COORDINATES], force[AMBLE_FORCES];
  int f;
  v->time += dt;
  for (f = 0; f < AMBLE_FEET; f++) {
    if (contact[f] == v->down[f]) {
      v->ticks[f] = 0;
      v->since[f] = 0.0;
      continue;
    }
    if (v->ticks[f]++) v->since[f] += dt;
    if (v->since[f] < AMBLE_CONFIRM_TIME) continue;
    v->down[f] = contact[f];
    v->ticks[f] = 0;
    v->since[f] = 0.0;
  }
  sense_base(d, s, q, qd);
  sense(d, s, q + BASE, qd + BASE);
  return amble_step(&v->c, v->time, q, qd, v->down, u, force);
}
#else
typedef struct {
  amble_controller c;
} driver;

static void begin(driver *v) { amble_enter(&v->c, 0); }

static unsigned act(driver *v, double dt, const mjData *d, const settings *s, const unsigned char *contact, double *u) {
  double q[AMBLE_JOINTS], qd[AMBLE_JOINTS];
  amble_command command;
  unsigned status;
  sense(d, s, q, qd);
  status = amble_step(&v->c, dt, q, qd, contact, &command);
  memcpy(u, command.sum, sizeof command.sum);
  return status;
}
#endif

void walk(const mjModel *m, mjData *d, const settings *s, outcome *r, double *trace, int rows, int width, int interval) {
  static double ring[RING][AMBLE_JOINTS];
  static driver v;
  double command[AMBLE_JOINTS] = {0};
  double torque[AMBLE_JOINTS] = {0}, force[AMBLE_FEET], whole[AMBLE_FEET][3], h = m->opt.timestep;
  double began = d->qpos[0];
  long k;
  int i, f, written = 0;
  memset(ring, 0, sizeof ring);
  memset(r, 0, sizeof *r);
  r->deepest = -1e30;
  state[0] = s->seed * 0x9E3779B97F4A7C15ULL + 1;
  state[1] = s->seed ^ 0xD1B54A32D192ED03ULL;
  for (i = 0; i < 20; i++) uniform();
  begin(&v);
  mj_forward(m, d);
  for (k = 0; (double)k * h < s->longest; k++) {
    double t = (double)k * h;
    press(m, d, s, force, whole);
    for (f = 0; f < AMBLE_FEET; f++) {
      if (force[f] > s->threshold && amble_stands(v.c.stance, f)) r->slip += h * sliding(m, d, s->geom[f]);
    }
    if (k % s->every == 0) {
      unsigned char contact[AMBLE_FEET];
      int last = v.c.stance;
      for (f = 0; f < AMBLE_FEET; f++) contact[f] = force[f] > s->threshold;
      r->status |= act(&v, k ? (double)s->every * h : 0.0, d, s, contact, command);
      if (v.c.stance != last && v.c.stance == 0 && ++r->cycles >= s->cycles) break;
    }
    memcpy(ring[k % RING], command, sizeof command);
    for (i = 0; i < AMBLE_JOINTS; i++) {
      double wanted = ring[(k >= s->delay ? k - s->delay : 0) % RING][i];
      wanted = wanted > s->cap ? s->cap : wanted < -s->cap ? -s->cap : wanted;
      torque[i] = s->lag > 0.0 ? torque[i] + (wanted - torque[i]) * (1.0 - exp(-h / s->lag)) : wanted;
      d->ctrl[s->motor[i]] = torque[i];
      r->square += torque[i] * torque[i] * h;
      if (fabs(torque[i]) > r->peak) r->peak = fabs(torque[i]);
    }
    for (i = 0; i < 3; i++) {
      d->xfrc_applied[6 * s->trunk + i] = t >= s->push_from && t < s->push_until ? s->push[i] : 0.0;
    }
    if (interval > 0 && k % interval == 0 && written < rows) {
      double *row = trace + (long)width * written++;
      row[0] = t;
      row[1] = v.c.stance;
      memcpy(row + 2, d->qpos, (size_t)m->nq * sizeof *row);
      memcpy(row + 2 + m->nq, d->qvel, (size_t)m->nv * sizeof *row);
      memcpy(row + 2 + m->nq + m->nv, torque, sizeof torque);
      memcpy(row + 2 + m->nq + m->nv + AMBLE_JOINTS, whole, sizeof whole);
    }
    mj_step(m, d);
    r->time = t + h;
    if (depth(m, d, s) > r->deepest) r->deepest = depth(m, d, s);
    if (!(d->qpos[2] - ground(s, d->qpos[0]) > s->lowest) || !(d->xmat[9 * s->trunk + 8] > s->steepest)) {
      r->fell = 1;
      break;
    }
  }
  r->x = d->qpos[0] - began;
  r->y = d->qpos[1];
}
