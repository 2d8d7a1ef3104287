/* Ticks that no robot should send: numbers that are none or enormous, clocks that jump, flags drawn at random. Every
 * torque must be a number all the same. Prints how many ticks fell back and how many were answered soundly.
 */
#include <math.h>
#include <stdio.h>

#include "amble_controller.h"

#define TICKS 20000

static unsigned long long state = 88172645463325252ull;

static double uniform(void) {
  state ^= state << 13;
  state ^= state >> 7;
  state ^= state << 17;
  return (double)(state >> 11) / 9007199254740992.0;
}

/* Mostly a small number; now and then one of those that break things. */
static double drawn(void) {
  static const double odd[] = {0.0, -0.0, 1e308, -1e308, 1e-308, 5e-324, 1e30};
  double chance = uniform();
  if (chance < 0.001) return NAN;
  if (chance < 0.002) return uniform() < 0.5 ? INFINITY : -INFINITY;
  if (chance < 0.004) return odd[(int)(uniform() * 6.999)];
  return uniform() - 0.5;
}

int main(void) {
  static amble_controller c;
  unsigned char contact[AMBLE_FEET];
  long fell_back = 0, sound = 0;
#ifndef IMPEDANCE
  double t = 0.0;
#endif
  int tick, i;
  for (tick = 0; tick < TICKS; tick++) {
    unsigned status;
    double step = uniform() < 0.01 ? drawn() : 0.001;
    int stance = (int)(uniform() * (AMBLE_STANCES + 3)) - 1, enters = uniform() < 0.01;
    for (i = 0; i < AMBLE_FEET; i++) contact[i] = (unsigned char)(uniform() < 0.5 ? 0 : (int)(256.0 * uniform()));
    {
#ifdef IMPEDANCE
      static AMBLE_REAL q[AMBLE_JOINTS], qd[AMBLE_JOINTS];
      static amble_command command;
      const AMBLE_REAL *torque = command.sum;
      if (enters) (void)amble_enter(&c, stance);
      for (i = 0; i < AMBLE_JOINTS; i++) q[i] = (AMBLE_REAL)drawn();
      for (i = 0; i < AMBLE_JOINTS; i++) qd[i] = (AMBLE_REAL)drawn();
      if (uniform() < 0.1) {
        status = amble_watchdog(&c, (AMBLE_REAL)step, q, qd, &command);
      } else {
        status = amble_step(&c, (AMBLE_REAL)step, q, qd, contact, &command);
      }
      if (status & (AMBLE_NOT_FINITE | AMBLE_NOT_ENTERED | AMBLE_SILENT)) fell_back++;
#else
      static double q[AMBLE_COORDINATES], qd[AMBLE_COORDINATES], torque[AMBLE_JOINTS], force[AMBLE_FORCES];
      if (enters) (void)amble_enter(&c, stance, t);
      for (i = 0; i < AMBLE_COORDINATES; i++) q[i] = drawn();
      for (i = 0; i < AMBLE_COORDINATES; i++) qd[i] = drawn();
      t = uniform() < 0.001 ? drawn() : (isfinite(t) ? t : 0.0) + (isfinite(step) ? step : 0.0);
      if (uniform() < 0.1) {
        status = amble_watchdog(&c, t, qd, torque, force);
      } else {
        status = amble_step(&c, t, q, qd, contact, torque, force);
      }
      if (status & AMBLE_FALLBACK) fell_back++;
#endif
      if (!(status & ~(unsigned)(AMBLE_SATURATED | 2 | AMBLE_LATE | AMBLE_CONTACT_FLAGS))) sound++;
      for (i = 0; i < AMBLE_JOINTS; i++) {
        if (!isfinite((double)torque[i]) || fabs((double)torque[i]) > 1e6) {
          printf("tick %d: torque %g of joint %d, status %u\n", tick, (double)torque[i], i, status);
          return 1;
        }
      }
    }
  }
  printf("%ld %ld\n", fell_back, sound);
  return 0;
}
