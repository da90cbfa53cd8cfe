"""Text output of the command `synth`."""

from __future__ import annotations

from typing import get_args

from frictool.adapters.controller_composition import profile_limits
from frictool.documents.controller import Controller, Number
from frictool.documents.quantity import si_unit
from frictool.synth.design import SynthesisResult
from frictool.synth.load_disturbance import LoadDisturbance
from frictool.synth.weight_relaxation import Trade
from frictool.verify.loop_wording import delay_words, plant_units, rounded_down
from frictool.verify.rest_view import rest_lines

COLUMNS = (
    7,
    10,
    10,
    10,
    10,
)  # widths in characters: name, inertia, viscous and Coulomb friction, drive constant
AUDIBLE = 5.0  # %, drive of one count relative to the limit, above which a line says more
ACTIONS = {
    "cut": "cut (loop open inside the band)",
    "brake": "brake (loop open at rest inside the band)",
    "none": "none",
}


def text(result: SynthesisResult, disturbance: LoadDisturbance) -> str:
    """Return the result of a synthesis as text.

    disturbance: largest load of the model.
    """
    controller = result.controller
    lines = [
        *_head(controller),
        *(
            f"derived: {one.name} {one.value:.4g}{f' {one.unit}' if one.unit else ''}, {one.source}"
            for one in result.derived
        ),
        *_trade(result.trade),
        *result.notes,
        *_vertices(controller),
        *_margins(controller),
        *_beyond(result),
        *_schedule(controller),
        *_disturbance(disturbance, si_unit("effort", controller.axis)),
    ]
    return "\n".join(lines)


def _head(controller: Controller) -> list[str]:
    verified, law = controller.verified, controller.position_law
    position = si_unit("position", controller.axis)
    required = (
        "" if verified.gamma_asked is None else f"gamma requested {verified.gamma_asked:.4g}, "
    )
    lines = [
        f"{controller.name}: {controller.structure.replace('_', ' ')} by {controller.method} in "
        f"{controller.domain} time, "
        f"order {controller.linear.order}, {controller.sample_period_s * 1e3:g} ms, "
        f"{delay_words(controller.delay_samples)}; {required}verified {verified.gamma_verified:.4g}"
    ]
    if law is not None and law.kind == "proportional":
        band = f"band {law.band:.4g} {position}, " if law.band else ""
        lines.append(
            f"position law: proportional, gain {law.gain:.4g} 1/s, {band}action "
            f"{ACTIONS[law.action]}"
        )
    elif law is not None:
        gain = f"{law.gain:.4g} {position}^0.5/s"
        lines.append(
            f"position law: gain {gain} by {law.formula}, band {law.band:.4g} {position}, "
            f"action {ACTIONS[law.action]}"
        )
    return [*lines, *_blocks(controller)]


def _tracking_blocks(controller: Controller) -> list[str]:
    units = {
        name: si_unit(name, controller.axis)
        for name in ("velocity", "acceleration", "jerk", "inertia", "viscous", "effort")
    }
    lines = []
    if (limits := controller.profile) is not None:
        jerk = profile_limits(limits).jerk(controller.sample_period_s)
        lines.append(
            f"profile: {limits.speed:.4g} {units['velocity']}, {limits.acceleration:.4g} "
            f"{units['acceleration']}, {jerk:.4g} {units['jerk']} by a mean over "
            f"{limits.smoothing_samples} samples"
        )
    if (fed := controller.feedforward) is not None:
        source = (
            f"the reference through {fed.filter_rad_s:.4g} rad/s"
            if fed.filter_rad_s
            else "the profile"
            if controller.profile is not None
            else "the prefilter"
        )
        lines.append(
            f"feedforward: inertia {fed.inertia:.4g} {units['inertia']}, viscous "
            f"{fed.viscous:.4g} {units['viscous']}, Coulomb {fed.coulomb:.4g} {units['effort']} "
            f"above {fed.switch_on_speed:.4g} {units['velocity']}, by {source}"
        )
    return lines


def _blocks(controller: Controller) -> list[str]:
    velocity, limiter, compensation = (
        controller.velocity,
        controller.limiter,
        controller.friction_compensation,
    )
    position, speed, effort, inertia = (
        si_unit(name, controller.axis) for name in ("position", "velocity", "effort", "inertia")
    )
    lines = _tracking_blocks(controller)
    if velocity.source == "measured":
        lines.append("velocity: measured")
    elif velocity.bandwidth_rad_s:
        lines.append(
            f"velocity: the encoder's difference, low-pass of order {velocity.order} at "
            f"{velocity.bandwidth_rad_s:.4g} rad/s"
        )
    if limiter is not None:
        rule = (
            f" (inertia {limiter.inertia:.4g} {inertia}, F_c {limiter.coulomb:.4g} {effort})"
            if limiter.condition == "energy"
            else ""
        )
        brake = (
            f"; F_cv {limiter.virtual_coulomb:.4g} {effort}, v_r {limiter.virtual_speed:.4g} "
            f"{speed}"
            if limiter.virtual_speed
            else ""
        )
        lines.append(
            f"limiter: by {limiter.condition}{rule}, band {limiter.band:.4g} {position}{brake}"
        )
    if compensation is not None:
        level = (
            f"a table of {len(compensation.speeds)} speeds"
            if compensation.speeds
            else f"F_c {compensation.coulomb:.4g} {effort}"
        )
        what = (
            f"an observer of {compensation.observer_rad_s:.4g} rad/s"
            if compensation.source == "observer"
            else f"the model, {level}, smoothed below "
            f"{compensation.smoothing_speed:.4g} {speed} of the "
            f"{compensation.velocity} speed"
        )
        lines.append(f"friction compensation: {compensation.gain:g} of {what}")
    if controller.linear.form == "sos":
        count = len(controller.linear.sos)
        lines.append(f"runs as {count} second-order section{'s' * (count > 1)}")
    return lines


def _trade(trade: Trade | None) -> list[str]:
    if trade is None:
        return []
    start, chosen = trade.start, trade.chosen
    return [
        f"relaxed: from W1 {start.disturbance:.4g}, W3 {start.drive:.4g} with gamma "
        f"{start.level:.4g} to W1 {chosen.disturbance:.4g}, "
        f"W3 {chosen.drive:.4g} with {chosen.level:.4g}: {trade.why}"
    ]


def _vertices(controller: Controller) -> list[str]:
    verified = controller.verified
    delays = [check.delay_samples for check in verified.vertices[0].checks]
    lines = [
        "vertex  inertia    viscous    coulomb    constant   norm    sampled "
        + "  ".join(f"margin (delay {d})" for d in delays)
    ]
    units = plant_units(controller.bench).values()
    lines.append(
        " ".join(
            f"{unit:<{width}}" for unit, width in zip(["", *units], COLUMNS, strict=True)
        ).rstrip()
    )
    for v in verified.vertices:
        margins = "  ".join(f"{check.modulus_margin:16.3f}" for check in v.checks)
        values = [f"{value:.4g}" for value in (v.inertia, v.viscous, v.coulomb, v.constant)]
        plant = " ".join(
            f"{cell:<{width}}" for cell, width in zip([v.name, *values], COLUMNS, strict=True)
        )
        lines.append(f"{plant} {v.norm:<7.4g} {v.sampled_norm:<7.4g} {margins}")
    lines.append(
        f"verified: stable at all {len(verified.vertices)} vertices, modulus margin "
        f"{verified.modulus_margin:.3f} "
        f">= {verified.modulus_margin_specified:g}"
    )
    return lines


def _margins(controller: Controller) -> list[str]:
    verified = controller.verified
    unit = si_unit(controller.drive, controller.axis)
    lines = []
    if verified.margins is not None:
        m = verified.margins
        up = "any" if m.gain_increase is None else f"{m.gain_increase:.3g}"
        down = "0" if m.gain_decrease is None else f"{m.gain_decrease:.3g}"
        phase = "any" if m.phase_deg is None else f"{m.phase_deg:.3g} deg"
        wait = "any" if m.delay_s is None else f"{m.delay_s * 1e3:.3g} ms"
        speed = si_unit("velocity", controller.axis)
        lines.append(
            f"  worst margins with the delay: gain x {down} to x {up}, phase {phase}, "
            f"additional delay {wait}; "
            f"largest norm from friction to speed {m.small_gain:.4g} {speed}"
        )
    if verified.count_drive is not None:
        share = 100.0 * verified.count_drive / controller.drive_limit
        lines.append(
            f"  one encoder count changes the drive by up to {verified.count_drive:.4g} {unit}, "
            f"{share:.3g} % of the limit"
        )
        if share > AUDIBLE and not _released(controller):
            filtered = controller.velocity.source == "position"
            remedy = "velocity.bandwidth_rad_s" if filtered else "the bandwidth"
            lines.append(
                "  the drive stays on at rest: it changes by this value whenever the encoder "
                f"changes by a count; to reduce this value, lower {remedy} of the design"
            )
    if verified.rounded:
        figures = ", ".join(
            f"{one.number} {one.gamma:.6g} and margin {one.modulus_margin:.4f}"
            for one in verified.rounded
        )
        lines.append(f"  rounded: norm {figures}")
        missing = [
            number
            for number in get_args(Number)
            if number not in {one.number for one in verified.rounded}
        ]
        if missing:
            lines.append(
                f"  not verified with coefficients rounded to {', '.join(missing)}: export "
                "refuses them"
            )
    return lines


def _released(controller: Controller) -> bool:
    """Return True if the drive is switched off at rest near the target."""
    law = controller.position_law
    return (law is not None and law.action != "none") or controller.limiter is not None


def _beyond(result: SynthesisResult) -> list[str]:
    controller = result.controller
    lines = []
    bounds = controller.verified.robustness
    if bounds is not None and controller.linear.input == "speed_error":
        lines.append(
            f"  largest sensitivity inside the box, {bounds.interior_points} plants       "
            f"{bounds.interior:.4g}"
        )
    elif bounds is not None:
        lines += [
            "  worst norm at the vertices                              "
            f"{controller.verified.gamma_verified:.4g}",
            f"  seen inside the box, {bounds.interior_points} plants and a search          "
            f"{bounds.interior:.4g}",
        ]
        if bounds.common is not None:
            lines.append(
                f"  bound for parameters that vary at any speed             {bounds.common:.4g}"
            )
    if controller.certificate is not None:
        for bound in result.proved:
            what = (
                f"norm < {bound.below:.6g}"
                if bound.modulus_margin is None
                else f"sensitivity < {bound.below:.6g}, modulus margin > "
                f"{rounded_down(bound.modulus_margin)}"
            )
            lines.append(
                f"proved for every constant plant of the box: {what} ({bound.cells} cells)"
            )
        if controller.certificate.bounds:  # without any bound, a note states the reason
            lines += [
                f"not proved: {reason}" for reason in controller.certificate.not_proved.values()
            ]
        lines += rest_lines(controller, controller.certificate)
    return lines


def _schedule(controller: Controller) -> list[str]:
    stored = controller.schedule
    if stored is None:
        return []
    return [
        f"scheduled over {', '.join(stored.parameters)}: {len(stored.corners)} controllers; "
        f"with {stored.points} plants between their corners the worst norm is {stored.gamma:.4g}, "
        f"the least modulus margin {stored.modulus_margin:.3f}"
    ]


def _disturbance(load: LoadDisturbance, unit: str) -> list[str]:
    if load.total == 0.0:
        return []
    labels = {"spring": "spring and offset"}
    parts = [
        f"{labels.get(name, name)} {value:.4g}"
        for name in ("spring", "offset", "gravity", "ripple")
        if (value := getattr(load, name))
    ]
    terms = load.offset + load.gravity + load.ripple + load.spring
    if load.total < terms:
        parts = [f"{load.total:.4g}"]
    share = (
        f"{100.0 * load.total / load.available:.2g} % of the {load.available:.4g} {unit} at "
        "the drive's limit"
    )
    lines = [
        f"disturbance: up to {' + '.join(parts)} {unit}"
        f"{' (offset and loads together)' if load.total < terms else ''}, {share}; the plants of "
        "the polytope do not include the disturbance, but simulate does"
    ]
    if load.total >= load.breakaway:
        lines.append(
            f"  the smallest breakaway, {load.breakaway:.4g} {unit}, does not hold this "
            "disturbance: with the drive off, the axis can move"
        )
    return lines
