"""Stage: a controller on many plants, drawn, at the corners and where it is worst; what the verdicts of all of them say."""
