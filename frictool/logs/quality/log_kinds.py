"""Kinds of test that kind_recognition.py distinguishes, and their descriptions for users."""

from __future__ import annotations

KINDS = {
    "sines": "the axis is driven by one sine or several",
    "ramp": "the effort repeatedly grows from rest until the axis moves, then falls (breakaway)",
    "steps": "the reference jumps between positions, or the axis rests at one position "
    "after the other",
    "stroke": "the axis moves in one direction, or in one direction and back",
    "free": "the motion matches no other kind of test",
    "rest": "the position does not move",
}
TEST = "test"  # key of the metadata record `log`: kind of test declared at `ingest`
