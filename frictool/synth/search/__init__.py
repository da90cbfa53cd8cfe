"""Search for a design whose controller meets a specification in simulation.

model, spec ──design_scales.py──▶ DesignScales DesignScales, parameters ──candidate families──▶
Design ──candidate_controller.py──▶ Controller Controller ──simulation by the caller──▶ distances to
limits ──played_search.py──▶ FamilyOutcome
"""
