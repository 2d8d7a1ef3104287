/* @TITLE@
 *
 * Written by amble @VERSION@ from gait '@GAIT@' of robot '@ROBOT@' with control law '@CONTROL@' and allocation law
 * '@LAW@'. C99, no heap, no library but libm, no global state that changes: all that a controller remembers is in one
 * struct.
 *
 * Sensors: the whole state, that is joint angles and rates, the base's place, attitude and their rates, one contact flag
 * a foot that does not bounce, and a clock.
 * Units: s, rad, m, N m, N; joints that slide have m and N. q = (x, y, z, roll, pitch, yaw, joints), R = Rx(roll) Ry(pitch) Rz(yaw); qd = dq/dt.
 * Joints: @JOINTS@.
 * Feet: @FEET@.
 *
 * Use: amble_enter once, where a stance begins; then amble_step at every tick.
 */
#ifndef AMBLE_CONTROLLER_H
#define AMBLE_CONTROLLER_H

#define AMBLE_VERSION "@VERSION@"
/* Id of the content of this export; every C file of it holds the same one and tests that. */
#define AMBLE_CONTENT @CONTENT@

#define AMBLE_COORDINATES @COORDINATES@
#define AMBLE_JOINTS @JOINT_COUNT@
#define AMBLE_FEET @FOOT_COUNT@
/* Components of the contact force of all feet; of each: @COMPONENTS@. */
#define AMBLE_FORCES @FORCE_COUNT@
/* Stances of the gait, and with those between the landings of feet that land one by one. */
#define AMBLE_GAIT_STANCES @GAIT_STANCES@
#define AMBLE_STANCES @STANCE_COUNT@

/* Share of a joint's fastest rate from which its motor gives less torque along the rate: the limit falls in a line to 0
 * at the fastest rate (against it the motor brakes with its whole limit). 1 leaves the limit as it is. */
#ifndef AMBLE_CORNER
#define AMBLE_CORNER 1.0
#endif
/* Time without a step after which amble_watchdog lets the motors damp only, s. */
#ifndef AMBLE_WATCHDOG_TIME
#define AMBLE_WATCHDOG_TIME @LONGEST@
#endif

/* Scratch of the generated code. */
#define AMBLE_WORK @WORK@
#define AMBLE_INTEGERS @INTEGERS@

/* Status of a step: 0, or a sum of these. */
enum {
  AMBLE_OK = 0,
  /* A torque was cut to its limit, joint by joint; the motion is no longer the planned one. */
  AMBLE_SATURATED = 1,
  /* A contact force leaves the friction cone or falls below the smallest normal force of the gait's limits. */
  AMBLE_CONTACT_FORCE = 2,
  /* The stance lasts longer than @LATEST@ times its plan; the references go on with their last acceleration. */
  AMBLE_LATE = 4,
  /* The flags fit neither this stance nor the next; the torques are those of the present stance. */
  AMBLE_CONTACT_FLAGS = 8,
  /* Fallbacks: u = -AMBLE_DAMPING qd within the limits (0 where qd is not a number), force = 0, the stance stays. */
  AMBLE_RANK_LOST = 16,  /* the motion does not determine the torques here */
  AMBLE_NOT_FINITE = 32, /* an argument or a result is not finite */
  AMBLE_BAD_CLOCK = 64,  /* t lies before the entry of the stance, or the controller was not entered */
  AMBLE_SILENT = 256,    /* of amble_watchdog; the controller has to be entered again */
  AMBLE_FALLBACK = 368   /* any of the four */
};

/* Joint damping of the fallback, N m s/rad, or N s/m of joints that slide. */
#define AMBLE_DAMPING @DAMPING@

typedef struct {
  int stance;     /* 0 .. AMBLE_STANCES - 1 */
  int entered;    /* a mark that amble_enter leaves */
  double entry;   /* time at which the stance was entered */
  double pivot;   /* smallest pivot of the last evaluation: its distance from lost rank */
  double margin;  /* of the last evaluation: smallest distance to a friction or normal force limit, N */
  double heading; /* of a gait that turns, at the entry of its cycle: where x of its laws points in the world, rad */
  unsigned clear; /* feet that have been off the ground since they last stood, one bit a foot */
  double last;    /* time of the last step, or of the entry */
  double work[AMBLE_WORK];
  long long integers[AMBLE_INTEGERS];
} amble_controller;

/* Begin in a stance at time t. A gait that turns begins with its heading along the world's x; set `heading` behind this
 * where the robot faces another way at the entry of the cycle. Returns AMBLE_OK, or AMBLE_BAD_CLOCK where the stance or the time is not valid. */
unsigned amble_enter(amble_controller *controller, int stance, double t);

/* One tick.
 *
 * t         time on the clock of amble_enter, s
 * q, qd     coordinates and their rates
 * contact   1 for every foot on the ground, else 0
 * u         joint torques, always written
 * force     contact forces that go with u, world frame, all feet, zero for swing feet; always written
 *
 * The stance switches when the feet that land next report contact, however early (where none lands: when the feet that
 * lift report none). A foot lands where it reports contact after it reported none: one that has just lifted may still
 * touch. Flags that bounce have to be filtered before. The clock of the references restarts at the switch. Where feet
 * land one by one the first to land leads to a stance between the landings, and the last to the next stance of the gait.
 */
unsigned amble_step(amble_controller *controller, double t, const double q[AMBLE_COORDINATES],
                    const double qd[AMBLE_COORDINATES], const unsigned char contact[AMBLE_FEET],
                    double u[AMBLE_JOINTS], double force[AMBLE_FORCES]);

/* A tick of a driver's loop in which no measurement came, so that there was no amble_step: its time, and the last known
 * rates. Until AMBLE_WATCHDOG_TIME since the last step (or the entry) nothing is written and AMBLE_OK is returned; then
 * the fallback is written, and the controller has to be entered again. A time before the last step counts as too late. */
unsigned amble_watchdog(amble_controller *controller, double t, const double qd[AMBLE_COORDINATES],
                        double u[AMBLE_JOINTS], double force[AMBLE_FORCES]);

/* Whether a foot stands in a stance. */
int amble_stands(int stance, int foot);

#endif
