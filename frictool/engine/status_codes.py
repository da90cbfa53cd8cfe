"""Status codes that the kernels of the engine return.

====  ===============  ==========================================================================
code  name             meaning
====  ===============  ==========================================================================
0     OK               done
1     TOO_MANY_EVENTS  too many stops, breakaways and contacts in one call (MAX_EVENTS); the
                       call ends after its last allowed event
2     NOT_FINITE       state, command or duration is not a finite number; a call with such
                       input leaves the state unchanged
3     EVENTS_FULL      the array for the events is full; the call ends at the first event that
                       does not fit
4     STEP_TOO_SMALL   the tolerance requires a step that is lost in the rounding of the time
5     LAW_FAILED       a kernel of the friction law returned an error of friction/status_codes.py
6     JAMMED           a self-locking link wedges: no acceleration satisfies the equations
7     UNRESOLVED       contacts and sticking parts change without end at one instant
====  ===============  ==========================================================================
"""

from __future__ import annotations

OK = 0
TOO_MANY_EVENTS = 1
NOT_FINITE = 2
EVENTS_FULL = 3
STEP_TOO_SMALL = 4
LAW_FAILED = 5
JAMMED = 6
UNRESOLVED = 7

MESSAGES = {
    TOO_MANY_EVENTS: "the axis stops and starts more often within one sample "
    "than the engine resolves",
    NOT_FINITE: "the simulation left the range of floating-point numbers",
    EVENTS_FULL: "there were more events than the array of events can store",
    STEP_TOO_SMALL: "the tolerance requires steps below the rounding error of time; raise the "
    "tolerance",
    LAW_FAILED: "the friction law left the range of floating-point numbers, or the memory of the "
    "law is full",
    JAMMED: "a self-locking link wedges, because its friction grows faster than the driving "
    "effort; lower the friction of the link or the inertia of the load",
    UNRESOLVED: "contacts and sticking parts change without end at one instant",
}
