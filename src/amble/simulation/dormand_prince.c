/* Flow through one domain of a hybrid system: explicit Runge-Kutta steps with error control, a watch on the guards,
 * the event located on the dense output, samples evenly spaced in time. One call a domain; no Python inside.
 *
 * The method is data (runge_kutta.py): 12 stages of order 8 with embedded errors of order 5 and 3, one stage that is the
 * first of the next step, 3 more for a dense output of order 7 (Hairer, Norsett, Wanner, Solving Ordinary
 * Differential Equations I, sections II.5 and II.10: DOP853). The step control is theirs too. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "callee.h"

#define STAGES 16      /* rows of the extended tableau */
#define STEP_STAGES 12 /* stages that make a step; row 12 is the weights of the solution */
#define DENSE 7        /* coefficient vectors of the dense output */
#define RESOLUTION 1e-10 /* s; of flow.py */
#define MOST_STEPS 10000 /* kept in memory; MOST_STEPS of flow.py */
#define EVENT_SAMPLES 4        /* at the guards in a panel; EVENT_SAMPLES of flow.py */
#define FLAT 0.01      /* of the largest slope in a panel: the slope of a polynomial through the samples is no exact one */
#define HALVINGS 60    /* of an interval in search of an excursion: as many as golden sections to 1e-12 of it */

enum { CROSSED = 0, TOO_LONG = 1, STUCK = 2, NO_MEMORY = 3, STEEP = 4 };
enum { NONE = -1, NOT_A_NUMBER = -2, STEEPER = -3 };

typedef struct {
    const double *a, *c, *error3, *error5, *dense;
} Tableau;

typedef struct {
    const Callee *field, *guards;
    const double *sign;  /* +1: the guard fires rising, -1: falling */
    const double *first; /* clock of the first sample of the guard, above 0 */
    const double *steepest; /* bound on the guard's slope along a motion, infinite where none is known */
    const double *breakpoints; /* clocks at which a step has to end, ascending */
    int n, n_guards, n_breakpoints;
} Problem;

typedef struct {
    double start, length;
} Span;

typedef struct { /* accepted steps: spans[i] and (1 + DENSE) vectors of the state from i * (1 + DENSE) * n */
    Span *spans;
    double *coefficients;
    int count, capacity;
} Path;

static double call(const Problem *problem, const Callee *callee, double clock, const double *state) {
    *callee->clock = clock;
    memcpy(callee->state, state, problem->n * sizeof(double));
    callee->results[0][0] = NAN; /* a function that fails writes nothing: it must not look like its last value */
    evaluate(callee);
    return callee->results[0][0];
}

static void slope(const Problem *problem, double clock, const double *state, double *rate) {
    call(problem, problem->field, clock, state);
    memcpy(rate, problem->field->results[0], problem->n * sizeof(double));
}

/* y = x + length * sum_j weights[j] k_j */
static void combine(int n, const double *x, double length, int stages, const double *weights, const double *k, double *y) {
    memset(y, 0, n * sizeof(double));
    for (int j = 0; j < stages; ++j) {
        const double w = weights[j];
        if (w == 0.0) continue;
        for (int i = 0; i < n; ++i) y[i] += w * k[j * n + i];
    }
    for (int i = 0; i < n; ++i) y[i] = (x ? x[i] : 0.0) + length * y[i];
}

static double first_step(const Problem *problem, const double *x, const double *rate, double tolerance, double time_limit,
                         double *work) {
    const int n = problem->n;
    double d0 = 0, d1 = 0, d2 = 0;
    for (int i = 0; i < n; ++i) {
        const double scale = tolerance + tolerance * fabs(x[i]);
        d0 += pow(x[i] / scale, 2);
        d1 += pow(rate[i] / scale, 2);
    }
    d0 = sqrt(d0 / n), d1 = sqrt(d1 / n);
    double h0 = (d0 < 1e-5 || d1 < 1e-5) ? 1e-6 : 0.01 * d0 / d1;
    h0 = fmin(h0, time_limit);
    double *y = work, *other = work + n;
    for (int i = 0; i < n; ++i) y[i] = x[i] + h0 * rate[i];
    slope(problem, h0, y, other);
    for (int i = 0; i < n; ++i) d2 += pow((other[i] - rate[i]) / (tolerance + tolerance * fabs(x[i])), 2);
    d2 = sqrt(d2 / n) / h0;
    const double largest = fmax(d1, d2);
    const double h1 = largest <= 1e-15 ? fmax(1e-6, h0 * 1e-3) : pow(0.01 / largest, 1.0 / 8.0);
    const double h = fmin(fmin(100 * h0, h1), time_limit);
    return h > 0 ? h : 1e-6 * time_limit; /* also for a rate that is not a number: the step itself reports it */
}

/* weighted error of a step from x to y, accepted when below 1; not a number where a stage is not */
static double step_error(const Problem *problem, const Tableau *tableau, double length, const double *x, const double *y,
                         const double *k, double tolerance) {
    const int n = problem->n;
    double five = 0, three = 0;
    for (int i = 0; i < n; ++i) {
        double e5 = 0, e3 = 0;
        for (int j = 0; j <= STEP_STAGES; ++j) {
            e5 += tableau->error5[j] * k[j * n + i];
            e3 += tableau->error3[j] * k[j * n + i];
        }
        const double scale = tolerance + tolerance * fmax(fabs(x[i]), fabs(y[i]));
        five += pow(e5 / scale, 2);
        three += pow(e3 / scale, 2);
    }
    if (five == 0 && three == 0) return 0;
    return length * five / sqrt((five + 0.01 * three) * n);
}

static int grow(Path *path, int n) {
    if (path->count < path->capacity) return 1;
    const int capacity = path->capacity ? 2 * path->capacity : 16;
    Span *spans = realloc(path->spans, capacity * sizeof(Span));
    if (spans) path->spans = spans;
    double *coefficients = realloc(path->coefficients, (size_t)capacity * (1 + DENSE) * n * sizeof(double));
    if (coefficients) path->coefficients = coefficients;
    if (!spans || !coefficients) return 0;
    path->capacity = capacity;
    return 1;
}

/* append an accepted step with the coefficients of its dense output (HNW I, eq. 6.13) */
static int append(const Problem *problem, const Tableau *tableau, Path *path, double start, double length,
                  const double *x, const double *y, double *k, double *work) {
    const int n = problem->n;
    if (!grow(path, n)) return 0;
    for (int s = STEP_STAGES + 1; s < STAGES; ++s) {
        combine(n, x, length, s, tableau->a + s * STAGES, k, work);
        slope(problem, start + tableau->c[s] * length, work, k + s * n);
    }
    double *f = path->coefficients + (size_t)path->count * (1 + DENSE) * n;
    const double *first = k, *last = k + STEP_STAGES * n;
    memcpy(f, x, n * sizeof(double));
    f += n;
    for (int i = 0; i < n; ++i) {
        const double change = y[i] - x[i];
        f[i] = change;
        f[n + i] = length * first[i] - change;
        f[2 * n + i] = 2 * change - length * (first[i] + last[i]);
    }
    for (int d = 0; d < DENSE - 3; ++d) combine(n, NULL, length, STAGES, tableau->dense + d * STAGES, k, f + (3 + d) * n);
    path->spans[path->count].start = start;
    path->spans[path->count].length = length;
    ++path->count;
    return 1;
}

static void dense(const Path *path, int n, int step, double clock, double *state) {
    const double *x = path->coefficients + (size_t)step * (1 + DENSE) * n, *f = x + n;
    const double s = (clock - path->spans[step].start) / path->spans[step].length;
    for (int i = 0; i < n; ++i) {
        double y = 0;
        for (int d = DENSE - 1; d >= 0; --d) y = (y + f[d * n + i]) * ((DENSE - 1 - d) % 2 ? 1 - s : s);
        state[i] = x[i] + y;
    }
}

static double watch(const Problem *problem, const Path *path, int guard, double clock, double *work) {
    dense(path, problem->n, path->count - 1, clock, work);
    return problem->sign[guard] * call(problem, problem->guards + guard, clock, work);
}

/* zero of a guard that is negative at a and not negative at b (regula falsi, Illinois variant) */
static double locate(const Problem *problem, const Path *path, int guard, double a, double at_a, double b, double at_b,
                     double *work) {
    int side = 0;
    for (int i = 0; i < 100 && at_b > 0 && b - a > 4e-16 * b; ++i) {
        double c = a + (b - a) * at_a / (at_a - at_b);
        if (!(c > a && c < b)) c = 0.5 * (a + b);
        if (c <= a || c >= b) break;
        const double at_c = watch(problem, path, guard, c, work);
        if (at_c < 0) {
            if (c - a < 1e-15 * c && side > 0) return c;
            a = c, at_a = at_c;
            if (side > 0) at_b *= 0.5;
            side = 1;
        } else {
            b = c, at_b = at_c;
            if (side < 0) at_a *= 0.5;
            side = -1;
        }
    }
    return b;
}

/* A guard in a panel: its samples, from..to evenly spaced, with their values (signed: it fires where it rises). */
typedef struct {
    double clock[EVENT_SAMPLES + 1], value[EVENT_SAMPLES + 1];
    int guard, count; /* samples with numbers after the first */
    int entry;        /* the first sample is the guard's first at all */
} Panel;

/* slopes at the samples of the polynomial through them, per panel */
static void slopes_of(const double *value, double *slope) {
    static const double d[EVENT_SAMPLES + 1][EVENT_SAMPLES + 1] = {
        {-25, 48, -36, 16, -3}, {-3, -10, 18, -6, 1}, {1, -8, 0, 8, -1}, {-1, 6, -18, 10, 3}, {3, -16, 36, -48, 25}};
    for (int i = 0; i <= EVENT_SAMPLES; ++i) {
        slope[i] = 0;
        for (int j = 0; j <= EVENT_SAMPLES; ++j) slope[i] += d[i][j] * value[j] / 3.0;
    }
}

/* whether a guard of one sign at samples i and i + 1 may come to zero between: it turns there, and it is no farther from
 * zero than it changes in the panel */
static int turns(const Panel *panel, const double *slope, int i) {
    const double a = panel->value[i], b = panel->value[i + 1], sign = a < 0 ? -1 : 1;
    double least = panel->value[0], most = least, flat = 0;
    for (int k = 0; k <= EVENT_SAMPLES; ++k) {
        least = fmin(least, panel->value[k]), most = fmax(most, panel->value[k]);
        flat = fmax(flat, FLAT * fabs(slope[k]));
    }
    if (fmin(fabs(a), fabs(b)) > most - least) return 0;
    /* at the entry a guard may be zero and rest there: roundoff turns it */
    const double before = panel->entry && i == 0 ? -flat : flat;
    return sign * slope[i] < before && sign * slope[i + 1] > -flat;
}

/* first crossing of a guard between a and b, which may leave its side and return between; INFINITY where there is none.
 * By golden sections towards the extreme that is closest to zero. */
static double excursion(const Problem *problem, const Path *path, const Panel *panel, int i, double *work) {
    const double share = 0.3819660112501051, sign = panel->value[i] < 0 ? -1 : 1;
    double a = panel->clock[i], b = panel->clock[i + 1];
    double c = a + share * (b - a), d = b - share * (b - a);
    double at_c = watch(problem, path, panel->guard, c, work), at_d = watch(problem, path, panel->guard, d, work);
    for (int halving = 0; halving < HALVINGS; ++halving) {
        const double where = sign * at_c < sign * at_d ? c : d, value = sign * at_c < sign * at_d ? at_c : at_d;
        if ((value < 0) != (sign < 0)) {
            if (sign < 0) return locate(problem, path, panel->guard, panel->clock[i], panel->value[i], where, value, work);
            return locate(problem, path, panel->guard, where, value, panel->clock[i + 1], panel->value[i + 1], work);
        }
        if (where == c) {
            b = d, d = c, at_d = at_c, c = a + share * (b - a);
            at_c = watch(problem, path, panel->guard, c, work);
        } else {
            a = c, c = d, at_c = at_d, d = b - share * (b - a);
            at_d = watch(problem, path, panel->guard, d, work);
        }
    }
    return INFINITY;
}

/* first crossing between a and b of a guard whose slope is bounded: what the bound does not rule out is halved, down to
 * the clock of a first sample. INFINITY where there is none, not a number where the guard is steeper than its bound. */
static double bounded(const Problem *problem, const Path *path, int guard, double a, double at_a, double b, double at_b,
                      double *work) {
    const double reach = problem->steepest[guard] * (b - a);
    if (isnan(at_b) || fabs(at_b - at_a) > reach * (1 + 1e-6) + 1e-12 * (fabs(at_a) + fabs(at_b))) return NAN;
    const int crosses = at_a < 0 && at_b >= 0;
    if (fabs(at_a) + fabs(at_b) > reach) return crosses ? locate(problem, path, guard, a, at_a, b, at_b, work) : INFINITY;
    if (b - a < RESOLUTION) return crosses ? locate(problem, path, guard, a, at_a, b, at_b, work) : INFINITY;
    const double middle = 0.5 * (a + b), at_middle = watch(problem, path, guard, middle, work);
    const double left = bounded(problem, path, guard, a, at_a, middle, at_middle, work);
    return left == INFINITY ? bounded(problem, path, guard, middle, at_middle, b, at_b, work) : left;
}

/* first crossing in a panel; as of bounded */
static double crossing(const Problem *problem, const Path *path, const Panel *panel, double *work) {
    const double *clock = panel->clock, *value = panel->value;
    const int guard = panel->guard, known = isfinite(problem->steepest[guard]);
    double slope[EVENT_SAMPLES + 1];
    if (panel->count == EVENT_SAMPLES) slopes_of(value, slope);
    for (int i = 0; i < panel->count; ++i) {
        double root = INFINITY;
        if (known)
            root = bounded(problem, path, guard, clock[i], value[i], clock[i + 1], value[i + 1], work);
        else if (value[i] < 0 && value[i + 1] >= 0)
            root = locate(problem, path, guard, clock[i], value[i], clock[i + 1], value[i + 1], work);
        else if ((value[i] < 0) == (value[i + 1] < 0) && panel->count == EVENT_SAMPLES && turns(panel, slope, i))
            root = excursion(problem, path, panel, i, work);
        if (root != INFINITY) return root;
    }
    return INFINITY;
}

/* sample the guards along the newest step, in panels of EVENT_SAMPLES at most max_step apart: the guard that crosses first,
 * its clock in *when; NONE, NOT_A_NUMBER or STEEPER. A guard whose value is still unknown (NaN) is looked at first at
 * its own first clock. */
static int first_event(const Problem *problem, const Path *path, double max_step, double *values, double *when, double *work) {
    const Span span = path->spans[path->count - 1];
    const double panels = fmax(1.0, ceil(span.length / (EVENT_SAMPLES * max_step)));
    int fired = NONE;
    for (double number = 0; number < panels && fired == NONE; ++number) {
        const double from = span.start + span.length * number / panels;
        const double to = span.start + span.length * (number + 1) / panels;
        double sound = INFINITY; /* until then all guards are numbers */
        *when = INFINITY;
        for (int guard = 0; guard < problem->n_guards; ++guard) {
            if (to <= problem->first[guard]) continue;
            Panel panel = {.guard = guard, .entry = isnan(values[guard])};
            panel.clock[0] = fmax(from, problem->first[guard]);
            panel.value[0] = panel.entry ? watch(problem, path, guard, panel.clock[0], work) : values[guard];
            if (isnan(panel.value[0])) return NOT_A_NUMBER;
            for (int k = 1; k <= EVENT_SAMPLES; ++k) {
                panel.clock[k] = k == EVENT_SAMPLES ? to : panel.clock[0] + (to - panel.clock[0]) * k / EVENT_SAMPLES;
                panel.value[k] = watch(problem, path, guard, panel.clock[k], work);
                if (isnan(panel.value[k])) break;
                panel.count = k;
            }
            if (panel.count < EVENT_SAMPLES) sound = fmin(sound, panel.clock[panel.count]);
            values[guard] = panel.value[EVENT_SAMPLES];
            const double root = crossing(problem, path, &panel, work);
            if (isnan(root)) return STEEPER;
            if (root < *when) *when = root, fired = guard;
        }
        if (sound < INFINITY && !(*when <= sound)) return NOT_A_NUMBER;
    }
    return fired;
}

static void resample(const Path *path, int n, double end, int samples, double *clocks, double *states) {
    int step = 0;
    for (int i = 0; i < samples; ++i) {
        const double clock = i == samples - 1 ? end : end * i / (samples - 1);
        while (step < path->count - 1 && clock > path->spans[step].start + path->spans[step].length) ++step;
        clocks[i] = clock;
        dense(path, n, step, clock, states + (size_t)i * n);
    }
}

/* clock that the next step must not pass: the next breakpoint, or the end */
static double barrier(const Problem *problem, double clock, double time_limit) {
    for (int i = 0; i < problem->n_breakpoints; ++i)
        if (problem->breakpoints[i] > clock && problem->breakpoints[i] < time_limit) return problem->breakpoints[i];
    return time_limit;
}

/* Integrate from state x at clock 0 until a guard fires or `time_limit` is reached.
 * Guards are looked at no more than `max_step` apart. Writes the samples, the clock at the end, the guard that fired, the number of accepted steps. */
int amble_flow(const Problem *problem, const Tableau *tableau, const double *start, double tolerance, double time_limit,
               double max_step, int samples, double *clocks, double *states, double *end, int *fired, int *steps) {
    const int n = problem->n;
    double *work = calloc((size_t)(STAGES + 5) * n + problem->n_guards, sizeof(double));
    if (!work) return NO_MEMORY;
    double *k = work, *x = k + STAGES * n, *y = x + n, *spare = y + n, *values = spare + 3 * n;
    Path path = {0};
    int status = TOO_LONG, rejected = 0;
    double clock = 0;
    *fired = -1;
    for (int guard = 0; guard < problem->n_guards; ++guard) values[guard] = NAN;
    memcpy(x, start, n * sizeof(double));
    slope(problem, 0, x, k);
    double length = first_step(problem, x, k, tolerance, time_limit, spare);
    while (clock < time_limit) {
        if (length < 1e-14 * fmax(clock, 1e-3 * time_limit) || path.count >= MOST_STEPS) {
            status = STUCK;
            break;
        }
        const double limit = barrier(problem, clock, time_limit), wanted = length;
        const int limited = clock + length >= limit;
        if (limited) length = limit - clock;
        for (int s = 1; s <= STEP_STAGES; ++s) {
            combine(n, x, length, s, tableau->a + s * STAGES, k, y);
            slope(problem, clock + tableau->c[s] * length, y, k + s * n);
        }
        const double error = step_error(problem, tableau, length, x, y, k, tolerance);
        const double factor = error == 0 ? 10.0 : 0.9 * pow(error, -1.0 / 8.0); /* not a number where a stage is not */
        if (!(error < 1.0)) {
            length *= factor >= 0.2 ? factor : 0.2;
            rejected = 1;
            continue;
        }
        if (!append(problem, tableau, &path, clock, length, x, y, k, spare)) {
            status = NO_MEMORY;
            break;
        }
        double when;
        *fired = first_event(problem, &path, max_step, values, &when, spare);
        if (*fired != NONE) {
            status = *fired >= 0 ? CROSSED : *fired == STEEPER ? STEEP : STUCK;
            if (*fired >= 0) clock = when;
            break;
        }
        clock = limited ? limit : clock + length;
        memcpy(x, y, n * sizeof(double));
        memcpy(k, k + STEP_STAGES * n, n * sizeof(double));
        length *= fmin(factor, rejected ? 1.0 : 10.0);
        if (limited) length = fmax(length, wanted); /* a step that a breakpoint cut short says little about the next */
        rejected = 0;
    }
    *end = clock;
    *steps = path.count;
    if (path.count) resample(&path, n, clock, samples, clocks, states);
    free(path.spans);
    free(path.coefficients);
    free(work);
    return status;
}

/* A domain of a cycle: its flow, whose guards are those of the transitions, then the margins; where a transition leads. */
typedef struct {
    const Problem *problem;
    const Callee *resets; /* by transition */
    const int *targets;   /* numbers of domains */
    int n_transitions;
} Passage;

#define MOST_EVENTS 10000 /* of a cycle; of walk.py */
#define ACCUMULATED 1e-8  /* s: stays so short may accumulate; of walk.py */

/* whether a motion can begin in a domain */
static int open(const Problem *problem, int n_transitions, const double *state) {
    for (int i = 0; i < problem->n; ++i)
        if (!isfinite(state[i])) return 0;
    for (int guard = n_transitions; guard < problem->n_guards; ++guard)
        if (!(call(problem, problem->guards + guard, 0, state) > 0)) return 0;
    return 1;
}

/* Apply the map from the entry of the first domain to its next entry `cycles` times to every start, in place. Writes
 * whether each came back in the plain way: where not, it is not said why, and its state means nothing. */
void amble_map(const Passage *passages, const Tableau *tableau, double tolerance, double time_limit, double max_step,
               int cycles, int count, double *states, int *returned) {
    const int n = passages[0].problem->n;
    double *ends = malloc(2 * n * sizeof(double));
    for (int start = 0; start < count; ++start) {
        double *state = states + (size_t)start * n;
        int domain = 0, done = 0, passed = 0;
        while (ends && done < cycles && passed++ < MOST_EVENTS) {
            const Passage *here = passages + domain;
            double clocks[2], end;
            int fired, steps;
            if (!open(here->problem, here->n_transitions, state)) break;
            const int status = amble_flow(here->problem, tableau, state, tolerance, time_limit, max_step, 2, clocks, ends, &end,
                                          &fired, &steps);
            if (status != CROSSED || fired >= here->n_transitions || end < ACCUMULATED) break;
            call(here->problem, here->resets + fired, end, ends + n);
            memcpy(state, here->resets[fired].results[0], n * sizeof(double));
            domain = here->targets[fired];
            if (domain == 0) ++done, passed = 0;
        }
        returned[start] = ends && done == cycles;
    }
    free(ends);
}
