/* start.c: start of a program on a Cortex-M4 (QEMU's mps2-an386), and its end by semihosting.
 *
 * reset() is the first code that runs: it copies the initial data, clears the rest, enables the
 * floating-point unit if the code uses it, runs main, and ends with main's value as exit code.
 */
#include <stdint.h>

#define CPACR (*(volatile uint32_t *)0xE000ED88u)
#define SYS_EXIT_EXTENDED 0x20
#define APPLICATION_EXIT 0x20026u

extern uint32_t stack_top, data_source, data_start, data_end, bss_start, bss_end;

int main(void);
void initialise_monitor_handles(void);
void reset(void) __attribute__((noreturn));
void stop(void) __attribute__((noreturn));
void timer_interrupt(void) __attribute__((weak));

static void leave(uint32_t code) __attribute__((noreturn));

static void leave(uint32_t code)
{
    uint32_t block[2] = {APPLICATION_EXIT, code};
    register uint32_t operation __asm("r0") = SYS_EXIT_EXTENDED;
    register uint32_t *argument __asm("r1") = block;

    __asm volatile("bkpt 0xAB" : : "r"(operation), "r"(argument) : "memory");
    for (;;) {
    }
}

/* An exception that nobody handles ends the program with the code 99. */
void stop(void)
{
    leave(99);
}

/* The timer's exception; an application with a timer has its own. */
void timer_interrupt(void)
{
    stop();
}

void reset(void)
{
    const uint32_t *source = &data_source;
    uint32_t *target;

    for (target = &data_start; target < &data_end; target++) {
        *target = *source++;
    }
    for (target = &bss_start; target < &bss_end; target++) {
        *target = 0;
    }
#ifdef __ARM_FP
    CPACR |= 0xFu << 20;
    __asm volatile("dsb\n isb" : : : "memory");
#endif
    initialise_monitor_handles();
    leave((uint32_t)main());
}

__attribute__((section(".vectors"), used)) static void (*const vectors[16])(void) = {
    (void (*)(void))&stack_top, reset, stop, stop, stop, stop, stop, 0, 0, 0, 0, stop, stop, 0, stop, timer_interrupt,
};
