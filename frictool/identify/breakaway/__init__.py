"""From ramps: the breakaway, its dependence on position and on the time at rest, and the friction
map (4.3, 4.40-4.44)."""
