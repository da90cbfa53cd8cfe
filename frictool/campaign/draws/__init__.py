"""What varies, and the draws of it: a box of factors, points of the unit cube, each a scenario."""
