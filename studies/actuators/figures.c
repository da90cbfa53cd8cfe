/* Figures of the holds of a run, by the definitions of docs/metrics.md. */
#include <math.h>

typedef struct {
    double response, overshoot, error, turns, rest_motion, rest_drive, peak;
} figures_t;

/* Turning points from which the position moves back by more than `threshold`. */
static int turning_points(const double *y, int count, double direction, double threshold)
{
    double extreme = y[0];
    int turns = 0;
    for (int k = 1; k < count; k++) {
        if (direction * (y[k] - extreme) > 0.0) {
            extreme = y[k];
        } else if (direction * (extreme - y[k]) > threshold) {
            turns++;
            direction = -direction;
            extreme = y[k];
        }
    }
    return turns;
}

/* Figures of one hold of `count` samples after a step from `origin` to `target`. Rest is judged
 * from sample `rest` on; -1 where the hold is shorter. Times are in samples. */
void hold_figures(const double *y, const double *u, int count, double origin, double target,
                  double step, int rest, figures_t *f)
{
    const double amplitude = fabs(target - origin), direction = target > origin ? 1.0 : -1.0;
    const double zone = fmax(0.05 * amplitude, step) * (1.0 + 1e-12);
    const double threshold = fmax(2.0 * step, 0.01 * amplitude) * (1.0 + 1e-12);
    const int tail = count / 10 > 10 ? count / 10 : (count < 10 ? count : 10);
    double final = 0.0, excess = 0.0, lowest = INFINITY, highest = -INFINITY;
    int entry = -1, leaving = -1;
    for (int k = count - tail; k < count; k++)
        final += y[k] / tail;
    f->peak = f->rest_drive = 0.0;
    for (int k = 0; k < count; k++) {
        if (fabs(y[k] - final) > zone)
            leaving = k;
        else if (entry < 0)
            entry = k;
        excess = fmax(excess, direction * (y[k] - target));
        f->peak = fmax(f->peak, fabs(u[k]));
        if (rest >= 0 && k >= rest) {
            lowest = fmin(lowest, y[k]);
            highest = fmax(highest, y[k]);
            f->rest_drive = fmax(f->rest_drive, fabs(u[k]));
        }
    }
    f->error = fabs(target - final);
    f->response = leaving >= count - tail || f->error > 0.5 * amplitude ? INFINITY : leaving + 1;
    f->overshoot = excess <= step * (1.0 + 1e-9) ? 0.0 : 100.0 * excess / amplitude;
    f->turns = entry < 0 ? 0.0 : turning_points(y + entry, count - entry, direction, threshold);
    f->rest_motion = rest < 0 ? 0.0 : highest - lowest;
}
