"""Simulated step test of the new controller at the end of `frictool synth`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from frictool.cli.console_output import note
from frictool.cli.progress import note_step

if TYPE_CHECKING:
    from frictool.campaign.design_trial import DesignTest
    from frictool.campaign.shorter_steps import ShorterSteps
    from frictool.campaign.trials.controller_judge import PlayedVerdict
    from frictool.documents.controller import Controller
    from frictool.documents.model import Model
    from frictool.documents.spec import Spec


@dataclass(frozen=True)
class PlayedTest:
    """Simulated test of a controller, and the verdict on it.

    compensated: True if the controller has a friction compensation.
    shorter: verdicts on shorter steps; None if none were simulated.
    decided: False if the controller may fail because of effects that the model lacks.
    """

    test: DesignTest
    verdict: PlayedVerdict
    compensated: bool
    shorter: ShorterSteps | None
    decided: bool = True

    @property
    def all_met(self) -> bool:
        """Return True if every requirement is met with every simulated plant."""
        from frictool.campaign.views.played_view import all_met

        return all_met(self.verdict)

    @property
    def passed(self) -> bool:
        """Return True if every requirement is met, and `decided` is True."""
        return self.decided and self.all_met

    @property
    def overspeed(self) -> str:
        """Return a warning if a plant exceeds `mechanics.top_speed` of the bench, else ""."""
        from frictool.logs.quality.overspeed import overspeed_words

        speeds = self.verdict.speeds
        name = self.test.names[self.verdict.plants[int(speeds.argmax())]]
        return overspeed_words(float(speeds.max()), self.test.model.bench, name)

    def lines(self, colour: bool) -> list[str]:
        """Return one line per requirement, then the verdict."""
        from frictool.campaign.views.played_view import (
            COLOURS,
            played_lines,
            rest_line,
            shorter_text,
        )

        test = self.test
        *lines, headline = played_lines(
            self.verdict, test.names, test.about, test.steps, colour, self.decided
        )
        lines += [rest_line(self.verdict)] if self.compensated else []
        if self.shorter is not None:
            text = shorter_text(self.shorter)
            marked = colour and self.shorter.failed
            lines.append(click.style(text, fg=COLOURS[None]) if marked else text)
        lines += [self.overspeed] if self.overspeed else []
        return [*lines, headline]

    def json(self) -> dict[str, Any]:
        """Return the verdict as JSON values."""
        from frictool.campaign.views.played_view import played_json, shorter_json

        return {
            **played_json(self.verdict, self.test.names, self.test.about, self.decided),
            "shorter_steps": None if self.shorter is None else shorter_json(self.shorter),
        }


def read_test(model: Model, spec: Spec, scenario: Path | None) -> DesignTest | None:
    """Return the test to simulate; print a note and return None if no test can be simulated.

    `scenario`: scenario of the test; None for the default test.
    """
    from frictool.campaign.design_trial import design_test, unjudged_target, untested_reason
    from frictool.documents.registry import load, same_axis
    from frictool.documents.scenario import Scenario

    if reason := untested_reason(model, spec):
        note(f"not simulated: {reason}")
        return None
    if remark := unjudged_target(spec):
        note(remark)
    if scenario is None:
        return design_test(model, spec)
    steps = load(scenario, Scenario)
    same_axis({Path("model"): model, scenario: steps})
    return design_test(model, spec, steps, str(scenario))


def play(test: DesignTest, controller: Controller) -> PlayedTest:
    """Simulate a test with a controller, then shorter steps if it passes; return the verdicts."""
    from frictool.campaign.shorter_steps import play_shorter_steps
    from frictool.campaign.views.played_view import all_met

    note_step(f"simulating {len(test.plants)} plants")
    verdict = test.judge(controller)
    shorter = play_shorter_steps(test, controller) if all_met(verdict) else None
    return PlayedTest(test, verdict, controller.friction_compensation is not None, shorter)
