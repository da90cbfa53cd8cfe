"""Search for a design whose controller meets a specification in simulation.

design_scales.py            model, spec ──▶ DesignScales
candidate families          DesignScales, parameters ──▶ Design
candidate_controller.py     Design ──▶ Controller
simulation by the caller    Controller ──▶ distances to the limits
played_search.py            distances to the limits ──▶ FamilyOutcome
"""
