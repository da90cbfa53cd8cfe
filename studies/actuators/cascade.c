/* A cascade that needs no synthesis: prefilter, position law, PI of the speed, rest band.
 *
 *     prefilter   second order, trapezoidal rule
 *     law         speed = sign(e) min(gain |e|, sqrt(2 braking |e|))
 *     speed       difference quotient through a first-order low-pass
 *     PI          drive = proportional (w - speed) + integral, held while it pushes into the limit
 *     rest        |e| <= band with the prefilter slow: brake to w = 0, then drive 0
 */
#include <math.h>

typedef struct {
    double period, limit;
    double prefilter, damping, gain, braking, proportional, integral_gain, speed_filter;
    double band, settled_speed, rest_speed;
    /* from here on: state */
    double reference, filtered, filtered_speed, position, difference, speed, integral, resting;
} cascade_t;

void cascade_init(void *opaque, double position)
{
    cascade_t *s = opaque;
    s->reference = s->filtered = s->position = position;
    s->filtered_speed = s->difference = s->speed = s->integral = 0.0;
    s->resting = 1.0;
}

double cascade_step(void *opaque, double reference, double position)
{
    cascade_t *s = opaque;
    const double t = s->period, w = s->prefilter, h = 0.5 * t;
    const double scale = 1.0 + 2.0 * s->damping * w * h + w * w * h * h;
    const double before = s->filtered_speed;
    const double difference = (position - s->position) / t;
    double error, wanted, drive, acceleration;
    acceleration = (w * w * (0.5 * (reference + s->reference) - s->filtered - h * before) - 2.0 * s->damping * w * before) / scale;
    s->filtered_speed = before + t * acceleration;
    s->filtered += h * (before + s->filtered_speed);
    s->speed += s->speed_filter * (0.5 * (difference + s->difference) - s->speed);
    s->difference = difference;
    s->position = position;
    s->reference = reference;
    error = s->filtered - position;
    wanted = copysign(fmin(s->gain * fabs(error), sqrt(2.0 * s->braking * fabs(error))), error);
    if (fabs(error) <= s->band && fabs(s->filtered_speed) < s->settled_speed) {
        if (s->resting > 0.0 || fabs(s->speed) < s->rest_speed) {
            s->resting = 1.0;
            s->integral = 0.0;
            return 0.0;
        }
        wanted = 0.0;
    }
    s->resting = 0.0;
    drive = s->proportional * (wanted - s->speed) + s->integral;
    if (fabs(drive) < s->limit || drive * (wanted - s->speed) < 0.0)
        s->integral += s->integral_gain * t * (wanted - s->speed);
    return fmax(-s->limit, fmin(s->limit, drive));
}
