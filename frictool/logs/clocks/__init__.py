"""Time: clocks against each other, their gaps, and streams on one grid."""
