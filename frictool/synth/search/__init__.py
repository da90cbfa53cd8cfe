"""Search for a design whose controller meets a specification in simulation.

model, spec ──design_scales.py──▶ DesignScales
DesignScales, parameters ──candidate families──▶ Design ──candidate_controller.py──▶ Controller
Controller ──simulation, passed by the caller──▶ reserves ──played_search.py──▶ FamilyOutcome
"""
