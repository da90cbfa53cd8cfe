/* loop.c: the controller in a timer interrupt of 1 ms, with the clutch in place of encoder and current drive.
 *
 * The interrupt reads the encoder, calls speed_step, and applies the current one period later. The clutch is one inertia
 * with Coulomb and viscous friction. A step of the reference must end at rest within the band of the controller, and the
 * invalid samples in the second half must not move the axis.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include "speed.h"

#define TIMER_CONTROL (*(volatile uint32_t *)0xE000E010u)
#define TIMER_RELOAD (*(volatile uint32_t *)0xE000E014u)
#define TIMER_VALUE (*(volatile uint32_t *)0xE000E018u)
#define CLOCK_HZ 25000000u
#define SAMPLES 2000
#define REFERENCE 40.0f /* rad */
#define BAND 2.0f /* rad */

void timer_interrupt(void);

static speed_state controller;
static volatile uint32_t samples;
static volatile float speed, angle; /* rad/s, rad */
static float current; /* A, since the last sample */

/* The clutch during one period, in steps of 10 us: N m, kg m^2, N m/A. */
static void move_axis(float amperes)
{
    const float inertia = 1.32e-5f, viscous = 3.81e-4f, coulomb = 0.099f, constant = 0.0134f, step = 1e-5f;
    int k;

    for (k = 0; k < 100; k++) {
        const float effort = constant * amperes;
        const float before = speed;

        if (before == 0.0f && fabsf(effort) <= coulomb) {
            continue;
        }
        speed += step / inertia * (effort - viscous * before - copysignf(coulomb, before != 0.0f ? before : effort));
        if (before * speed < 0.0f) {
            speed = 0.0f;
        }
        angle += step * speed;
    }
}

void timer_interrupt(void)
{
    float position;

    if (samples >= SAMPLES) {
        return;
    }
    move_axis(current);
    position = floorf(angle / SPEED_POSITION_PER_COUNT) * SPEED_POSITION_PER_COUNT;
    if (samples > SAMPLES / 2 && samples % 100 < SPEED_HOLD_SAMPLES) {
        position = NAN; /* a lost telegram */
    }
    current = speed_step(&controller, REFERENCE, position);
    samples++;
}

int main(void)
{
    speed_init(&controller, 0.0f);
    TIMER_RELOAD = CLOCK_HZ / 1000u - 1u;
    TIMER_VALUE = 0;
    TIMER_CONTROL = 7; /* on, interrupt, the processor's clock */
    while (samples < SAMPLES) {
        __asm volatile("wfi");
    }
    printf("loop in the interrupt, after %lu samples: position %.2f rad, reference %.2f rad, speed %.2f rad/s, fault %d\n", (unsigned long)samples,
           (double)angle, (double)REFERENCE, (double)speed, speed_fault(&controller));
    return fabsf(angle - REFERENCE) > BAND || speed != 0.0f || speed_fault(&controller);
}
