/* @TITLE@
 *
 * Written by amble @VERSION@ from gait '@GAIT@' of robot '@ROBOT@' with control law '@CONTROL@' and allocation law
 * '@LAW@'. C99, no heap, no library but libm, no global state that changes: all that a controller remembers is in one
 * struct.
 *
 * Sensors: joint angles, joint rates and one contact flag a foot; neither the base nor a clock is read.
 * Units: s, rad, rad/s, N m, N m/rad, N m s/rad; of joints that slide m, m/s, N, N/m, N s/m. AMBLE_REAL is double,
 * with -DAMBLE_FLOAT float.
 * Joints, in the order of all arrays, positive as in the robot's description: @JOINTS@.
 * Feet: @FEET@.
 *
 * Use: amble_enter once, where a stance begins; then amble_step at every tick, with the time since the last one.
 */
#ifndef AMBLE_CONTROLLER_H
#define AMBLE_CONTROLLER_H

#define AMBLE_VERSION "@VERSION@"
/* Id of the content of this export; every C file of it holds the same one and tests that. */
#define AMBLE_CONTENT @CONTENT@

#define AMBLE_JOINTS @JOINT_COUNT@
#define AMBLE_FEET @FOOT_COUNT@
/* Stances of the gait, and with those between the landings of feet that land one by one. */
#define AMBLE_GAIT_STANCES @GAIT_STANCES@
#define AMBLE_STANCES @STANCE_COUNT@

/* What is commanded, in this order: @AXES_NAMES@. 0 axes where the controller is that of one gait. */
#define AMBLE_AXES @AXES@
#if AMBLE_AXES
/* Gaits around a command. */
#define AMBLE_CORNERS (1 << AMBLE_AXES)
#endif

#ifdef AMBLE_FLOAT
typedef float AMBLE_REAL;
#else
typedef double AMBLE_REAL;
#endif

/* A foot counts as down after its flag was set at this many ticks in a row and for this long, and as up again after as
 * many without: a foot that bounces neither lands nor lifts. Both may be set by -D. */
#ifndef AMBLE_CONFIRM_TICKS
#define AMBLE_CONFIRM_TICKS 2
#endif
#ifndef AMBLE_CONFIRM_TIME
#define AMBLE_CONFIRM_TIME 0.0
#endif
/* Share of the planned duration before which no stance of the gait ends; a foot that is down by then ends it there. 0 is
 * the rule of the simulation and of the certificate; a floor that feet scuff over early in the swing may want more. */
#ifndef AMBLE_EARLIEST
#define AMBLE_EARLIEST 0.0
#endif
/* A stance that ends where feet lift and none lands ends between these shares of its planned duration. Before the first
 * the impact of the foot that landed may take the load off a stance foot for some ticks, which is no lift-off; at the
 * second a foot that still carries is lifted by the next stance, because nothing else would lift it. */
#ifndef AMBLE_EARLIEST_LIFT_OFF
#define AMBLE_EARLIEST_LIFT_OFF @EARLIEST_LIFT_OFF@
#endif
#ifndef AMBLE_LATEST_LIFT_OFF
#define AMBLE_LATEST_LIFT_OFF @LATEST_LIFT_OFF@
#endif
/* Share of the planned duration from which a stance counts as late: @HOLD@, where the references stand still. A contact
 * that does not come leaves the controller there, with the status LATE at every tick; what then is to be done is the
 * caller's decision. */

/* Share of a joint's fastest rate from which its motor gives less torque along the rate: the limit falls in a line to 0
 * at the fastest rate (against it the motor brakes with its whole limit). 1 leaves the limit as it is. */
#ifndef AMBLE_CORNER
#define AMBLE_CORNER 1.0
#endif
/* Time without a step after which amble_watchdog lets the motors damp only, s. */
#ifndef AMBLE_WATCHDOG_TIME
#define AMBLE_WATCHDOG_TIME @LONGEST@
#endif

/* Status of a step: 0, or a sum of these. */
enum {
  AMBLE_OK = 0,
  AMBLE_SATURATED = 1,     /* a component of sum was cut to the joint's limit */
  AMBLE_LATE = 4,          /* see above */
  AMBLE_CONTACT_FLAGS = 8, /* a foot of this and the next stance is up, or one of neither is down */
  AMBLE_NOT_FINITE = 32,   /* fallback: torque and stiffness 0, damping AMBLE_DAMPING; the clock goes on */
  AMBLE_BAD_CLOCK = 64,    /* the step was negative, no number, or longer than AMBLE_LONGEST_STEP and cut to it */
  AMBLE_NOT_ENTERED = 128, /* fallback; nothing changes until amble_enter */
  AMBLE_SILENT = 256,      /* fallback of amble_watchdog, with NOT_ENTERED from then on */
  AMBLE_OUT_OF_RANGE = 512 /* amble_steer, amble_enter_at: a command beyond the gaits was cut to the range */
};

#define AMBLE_LONGEST_STEP @LONGEST@
#define AMBLE_DAMPING @DAMPING@

typedef struct {
  int stance;      /* 0 .. AMBLE_STANCES - 1 */
  int entered;     /* a mark that amble_enter leaves */
  AMBLE_REAL clock; /* time since the stance was entered, s */
  unsigned down;   /* feet that count as down, one bit a foot */
  unsigned clear;  /* feet that have been up since they last stood */
  int ticks[AMBLE_FEET];       /* how often in a row a flag differed from that, and for how long */
  AMBLE_REAL since[AMBLE_FEET];
  AMBLE_REAL silent; /* time without a step, s */
#if AMBLE_AXES
  AMBLE_REAL asked[AMBLE_AXES];    /* the command that was asked for */
  AMBLE_REAL left[AMBLE_AXES];     /* where the command is at the begin of this step, and where at its end */
  AMBLE_REAL followed[AMBLE_AXES];
  int node[2 * AMBLE_CORNERS];     /* gaits around both, and their parts in them */
  AMBLE_REAL part[2 * AMBLE_CORNERS];
  AMBLE_REAL weight[2 * AMBLE_CORNERS]; /* those at the present share of the step */
  AMBLE_REAL begin, end;           /* shares of the step at which this stance begins and ends as planned */
  AMBLE_REAL planned;              /* its planned duration, s */
#endif
} amble_controller;

/* What motor drivers take: torque + stiffness (q - angle) ... and sum, all of it for measured angles and rates,
 * sum = torque - stiffness * (measured angle - angle) - damping * (measured rate - rate), cut to the limits. */
typedef struct {
  AMBLE_REAL angle[AMBLE_JOINTS];
  AMBLE_REAL rate[AMBLE_JOINTS];
  AMBLE_REAL torque[AMBLE_JOINTS];
  AMBLE_REAL stiffness[AMBLE_JOINTS];
  AMBLE_REAL damping[AMBLE_JOINTS];
  AMBLE_REAL sum[AMBLE_JOINTS];
} amble_command;

/* Begin in a stance, its feet down. Returns AMBLE_OK, or AMBLE_NOT_ENTERED where there is no such stance. */
unsigned amble_enter(amble_controller *controller, int stance);

/* One tick: dt since the last one, measured angles and rates, contact 1 for every foot that touches. The command is
 * always written. The stance ends when the feet that land next count as down, however early (where none lands: when
 * those that lift count as up); a foot lands where it counts as down after it counted as up, so that one that has just
 * lifted may still touch. The clock then starts again. Of feet that land one by one, the first to land leads to a stance
 * between the landings, the last to the next stance of the gait. */
unsigned amble_step(amble_controller *controller, AMBLE_REAL dt, const AMBLE_REAL q[AMBLE_JOINTS],
                    const AMBLE_REAL qd[AMBLE_JOINTS], const unsigned char contact[AMBLE_FEET],
                    amble_command *command);

/* A tick of a driver's loop in which no measurement came, so that there was no amble_step: dt since the last tick of
 * either, the last known angles and rates. Until AMBLE_WATCHDOG_TIME since the last step the command stays as it is and
 * AMBLE_OK is returned; then the fallback is written, and the controller has to be entered again: its clock has passed
 * events that it did not see. A dt that is negative or no number counts as too long. */
unsigned amble_watchdog(amble_controller *controller, AMBLE_REAL dt, const AMBLE_REAL q[AMBLE_JOINTS],
                        const AMBLE_REAL qd[AMBLE_JOINTS], amble_command *command);

#if AMBLE_AXES
/* Ask for a command. From the next step on it is approached, in every axis by the change a step that commands may use at
 * most; within a step the law goes over smoothly. Returns AMBLE_OK, AMBLE_OUT_OF_RANGE, or AMBLE_NOT_FINITE, where
 * nothing is asked for. amble_enter begins with the command nearest to 0. */
unsigned amble_steer(amble_controller *controller, const AMBLE_REAL command[AMBLE_AXES]);

/* As amble_enter, with this command in its first step. One that is not finite leaves the one nearest to 0. */
unsigned amble_enter_at(amble_controller *controller, int stance, const AMBLE_REAL command[AMBLE_AXES]);

/* As amble_enter_at, in a step in which the command goes from one to another, by whatever change. */
unsigned amble_enter_between(amble_controller *controller, int stance, const AMBLE_REAL before[AMBLE_AXES],
                             const AMBLE_REAL after[AMBLE_AXES]);
#endif

/* Whether a foot stands in a stance. */
int amble_stands(int stance, int foot);

#endif
