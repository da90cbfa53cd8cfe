/* Simulates one axis with dry friction under a sampled controller.
 *
 *     drive      i' = (command - i)/lag, command held over a sample, |command| <= limit
 *     slipping   inertia v' = constant i - d coulomb - viscous v, d = +-1 the direction
 *     at rest    v = 0 while |constant i| <= breakaway
 *     backlash   the motor moves by its full width before it carries the load; inside, `loose`
 *                replaces the Coulomb friction, `loose_breakaway` the breakaway, without viscosity
 *     encoder    floor(position/step) step
 *
 * Each phase of motion has a fixed direction and a solution in exponentials. A phase ends at the
 * end of the sample, where the speed is zero, or where the motor meets the load. Bisection finds
 * the end to the last bit. The phases begin again until the sample is complete.
 */
#include <math.h>

typedef double (*step_function)(void *state, double reference, double position);

typedef struct {
    double period, delay, lag, step, limit;
    double inertia, viscous, coulomb, constant, breakaway;
    double backlash, loose, loose_breakaway, start;
} axis_t;

typedef struct {
    double position, speed, drive, gap;
} motion_t;

/* One phase: v' = constant_part + lag_part exp(-lag_rate t) - decay v. */
typedef struct {
    double decay, lag_rate, constant_part, lag_part;
} phase_t;

enum { DELAYS = 4, PHASES = 200, HALVINGS = 80 };

/* Integral of exp(-c s) over [0, t]. */
static double once(double c, double t)
{
    const double x = c * t;
    return fabs(x) < 1e-8 ? t * (1.0 - 0.5 * x) : -expm1(-x) / c;
}

/* Integral of `once` over [0, t]. */
static double twice(double c, double t)
{
    const double x = c * t;
    if (fabs(x) < 2e-2)
        return t * t * (0.5 - x / 6.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0 * (1.0 - x / 7.0)))));
    return (t - once(c, t)) / c;
}

static double speed_after(const phase_t *p, double speed, double t)
{
    const double a = p->decay, b = p->lag_rate;
    double v = speed * exp(-a * t) + p->constant_part * once(a, t);
    if (p->lag_part != 0.0)
        v += p->lag_part * exp(-a * t) * once(b - a, t);
    return v;
}

static double distance_after(const phase_t *p, double speed, double t)
{
    const double a = p->decay, b = p->lag_rate;
    double x = speed * once(a, t) + p->constant_part * twice(a, t);
    if (p->lag_part != 0.0)
        x += p->lag_part * (b * twice(b, t) - a * twice(a, t)) / (b - a);
    return x;
}

/* First time in (0, t] at which the speed has lost its direction; more than t if it never has. */
static double standstill(const phase_t *p, double speed, double direction, double t)
{
    const double a = p->decay, b = p->lag_rate;
    double from = 0.0, until = t;
    if (p->lag_part != 0.0) { /* the acceleration has one zero at most */
        const double slow = p->constant_part - a * speed - a * p->lag_part / (b - a);
        const double fast = b * p->lag_part / (b - a);
        const double ratio = -fast / slow;
        const double turn = ratio > 0.0 ? log(ratio) / (b - a) : -1.0;
        if (turn > 0.0 && turn < t) {
            /* an axis that starts from rest accelerates first */
            if (speed != 0.0 && direction * speed_after(p, speed, turn) < 0.0)
                until = turn;
            else
                from = turn;
        }
    }
    if (direction * speed_after(p, speed, until) > 0.0)
        return 2.0 * t;
    for (int k = 0; k < HALVINGS; k++) {
        const double middle = 0.5 * (from + until);
        if (direction * speed_after(p, speed, middle) > 0.0)
            from = middle;
        else
            until = middle;
    }
    return until;
}

/* First time in (0, t] at which the motor has moved by `room`; more than t if it does not. */
static double contact(const phase_t *p, double speed, double room, double t)
{
    double from = 0.0, until = t;
    if (fabs(distance_after(p, speed, t)) < room)
        return 2.0 * t;
    for (int k = 0; k < HALVINGS; k++) {
        const double middle = 0.5 * (from + until);
        if (fabs(distance_after(p, speed, middle)) < room)
            from = middle;
        else
            until = middle;
    }
    return until;
}

/* Time in [0, t] at which the effort of the resting axis exceeds a breakaway; more than t if never. */
static double breaking(const axis_t *axis, const motion_t *m, double command, double t, double *direction)
{
    const double half = 0.5 * axis->backlash;
    double first = 2.0 * t;
    *direction = 0.0;
    for (double d = -1.0; d < 2.0; d += 2.0) {
        const double level = d * m->gap >= half ? axis->breakaway : axis->loose_breakaway;
        const double now = d * axis->constant * m->drive, later = d * axis->constant * command;
        double when = 2.0 * t;
        if (now > level)
            when = 0.0;
        else if (later > level)
            when = axis->lag > 0.0 ? axis->lag * log((later - now) / (later - level)) : 0.0;
        if (when <= t && when < first) {
            first = when;
            *direction = d;
        }
    }
    return first;
}

static double drive_after(const axis_t *axis, double drive, double command, double t)
{
    return axis->lag > 0.0 ? command + (drive - command) * exp(-t / axis->lag) : command;
}

/* Moves the axis by the time t under one command; returns 0, or 1 after too many phases. */
int axis_move(const axis_t *axis, motion_t *m, double command, double t)
{
    const double half = 0.5 * axis->backlash;
    double direction = m->speed > 0.0 ? 1.0 : (m->speed < 0.0 ? -1.0 : 0.0);
    if (axis->lag == 0.0)
        m->drive = command;
    for (int count = 0; count < PHASES; count++) {
        phase_t p;
        double whole = t, stop, touch = 2.0 * t;
        int carried;
        if (direction == 0.0) {
            const double when = breaking(axis, m, command, t, &direction);
            if (when > t) {
                m->drive = drive_after(axis, m->drive, command, t);
                return 0;
            }
            m->drive = drive_after(axis, m->drive, command, when);
            t -= when;
            m->speed = 0.0;
            if (t <= 0.0)
                return 0; /* the next sample begins with the breakaway */
            whole = t;
            touch = 2.0 * t;
        }
        carried = direction * m->gap >= half;
        p.decay = carried ? axis->viscous / axis->inertia : 0.0;
        p.lag_rate = axis->lag > 0.0 ? 1.0 / axis->lag : 0.0;
        if (fabs(p.lag_rate - p.decay) < 1e-6 * p.lag_rate)
            p.decay *= 1.0 - 2e-6;
        p.constant_part = (axis->constant * command - direction * (carried ? axis->coulomb : axis->loose)) / axis->inertia;
        p.lag_part = axis->lag > 0.0 ? axis->constant * (m->drive - command) / axis->inertia : 0.0;
        stop = standstill(&p, m->speed, direction, whole);
        if (stop < whole)
            whole = stop;
        if (!carried)
            touch = contact(&p, m->speed, half - direction * m->gap, whole);
        if (touch < whole)
            whole = touch;
        const double moved = distance_after(&p, m->speed, whole);
        m->position += moved;
        m->gap = carried ? direction * half : m->gap + moved;
        m->speed = speed_after(&p, m->speed, whole);
        m->drive = drive_after(axis, m->drive, command, whole);
        t -= whole;
        if (touch <= whole) {
            m->gap = direction * half;
        } else if (stop <= whole) {
            m->speed = 0.0;
            direction = 0.0;
        }
        if (t <= 0.0)
            return 0;
    }
    return 1;
}

/* Runs a controller from its initial state over the reference; fills the encoder's readings, the
 * commands and the true positions at each sample; returns 0, or 1 where the phases of a sample do
 * not end. */
int axis_run(const axis_t *axis, const double *reference, int samples, step_function step,
             void *state, double *seen, double *commands, double *positions)
{
    motion_t m = {axis->start, 0.0, 0.0, 0.0};
    double waiting[DELAYS] = {0.0};
    const int delay = (int)axis->delay;
    for (int k = 0; k < samples; k++) {
        double command;
        positions[k] = m.position;
        seen[k] = floor(m.position / axis->step) * axis->step;
        commands[k] = step(state, reference[k], seen[k]);
        command = fmax(-axis->limit, fmin(axis->limit, commands[k]));
        for (int j = delay; j > 0; j--)
            waiting[j] = waiting[j - 1];
        waiting[0] = command;
        if (axis_move(axis, &m, k < delay ? 0.0 : waiting[delay], axis->period))
            return 1;
    }
    return 0;
}
